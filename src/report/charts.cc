// SPDX-License-Identifier: Apache-2.0
#include "charts.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using ChartValue = nlohmann::ordered_json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Five significant digits: finer than a pixel of any screen.
ChartValue Rounded(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0.0) return 0;
  const int places = 4 - static_cast<int>(std::floor(std::log10(std::abs(value))));
  if (places > 300 || places < -300) return value;
  const double scale = std::pow(10.0, std::abs(places));
  const double rounded =
      places >= 0 ? std::round(value * scale) / scale : std::round(value / scale) * scale;
  if (rounded == std::round(rounded) && std::abs(rounded) < 1e15) {
    return static_cast<std::int64_t>(rounded);
  }
  return rounded;
}

ChartValue List(const std::vector<double>& values) {
  ChartValue out = ChartValue::array();
  for (const double value : values) out.push_back(Rounded(value));
  return out;
}

/// One row after the other in one flat list.
template <std::size_t n>
ChartValue Flat(const std::vector<std::array<double, n>>& rows) {
  ChartValue out = ChartValue::array();
  for (const auto& row : rows) {
    for (const double value : row) out.push_back(Rounded(value));
  }
  return out;
}

ChartValue Lines(const std::vector<MapChart::Line>& lines) {
  ChartValue out = ChartValue::array();
  for (const MapChart::Line& line : lines) {
    out.push_back({{"name", line.name}, {"xy", Flat(line.places)}});
  }
  return out;
}

ChartValue AxisJson(const ChartAxis& axis) {
  ChartValue out = {{"label", axis.label}};
  if (axis.logarithmic) out["log"] = true;
  if (!std::isnan(axis.least)) out["min"] = Rounded(axis.least);
  if (!std::isnan(axis.most)) out["max"] = Rounded(axis.most);
  return out;
}

/// Ids of files need not be UTF-8: what is not becomes the replacement character.
std::string Dump(const ChartValue& json) {
  return json.dump(-1, ' ', false, ChartValue::error_handler_t::replace);
}

}  // namespace

std::string ChartJson(const std::string& id, const XyChart& chart) {
  ChartValue out = {{"id", id}, {"type", "xy"}, {"x", AxisJson(chart.x)}, {"y", AxisJson(chart.y)}};
  out["series"] = ChartValue::array();
  for (const ChartSeries& series : chart.series) {
    ChartValue one = {{"label", series.label},
                      {"style", series.style},
                      {"color", series.color},
                      {"x", List(series.x)},
                      {"y", List(series.y)}};
    if (!series.low.empty()) one["low"] = List(series.low);
    if (!series.high.empty()) one["high"] = List(series.high);
    if (!series.names.empty()) one["names"] = series.names;
    if (series.written) one["written"] = true;
    out["series"].push_back(std::move(one));
  }
  return Dump(out);
}

void FitY(XyChart* chart) {
  double low = kNone, high = kNone;
  for (const ChartSeries& series : chart->series) {
    for (const double y : series.y) {
      if (!(y > 0.0)) continue;
      low = std::fmin(low, y);
      high = std::fmax(high, y);
    }
  }
  if (std::isnan(low)) return;
  chart->y.logarithmic = high > 5.0 * low;
  const double margin = chart->y.logarithmic ? std::pow(high / low, 0.08) : 0.1 * (high - low);
  chart->y.least = chart->y.logarithmic ? low / margin : std::max(0.0, low - margin);
  chart->y.most = chart->y.logarithmic ? high * margin : high + margin;
  if (chart->y.least == chart->y.most) chart->y.least = chart->y.most = kNone;
}

std::string ChartJson(const std::string& id, const MapChart& chart) {
  ChartValue out = {{"id", id}, {"type", "map"}, {"unit", chart.unit}};
  out["tracks"] = Lines(chart.tracks);
  out["swaths"] = Lines(chart.swaths);
  out["points"] = Flat(chart.points);
  out["names"] = chart.point_names;
  out["values"] = ChartValue::array();
  for (const MapChart::Value& value : chart.values) {
    out["values"].push_back({{"label", value.label},
                             {"of", List(value.of_point)},
                             {"low", Rounded(value.low)},
                             {"high", Rounded(value.high)},
                             {"least", Rounded(value.least)},
                             {"most", Rounded(value.most)},
                             {"weakLow", value.weak_where_low}});
  }
  out["shown"] = chart.shown;
  out["log"] = chart.logarithmic;
  out["control"] = Flat(chart.control);
  out["controlNames"] = chart.control_names;
  out["checks"] = Flat(chart.checks);
  out["checkNames"] = chart.check_names;
  out["ellipses"] = Flat(chart.ellipses);
  out["errors"] = Flat(chart.errors);
  out["graticule"] = Lines(chart.graticule);
  out["unitMetres"] = chart.unit_m;
  return Dump(out);
}

}  // namespace sarblock
