// SPDX-License-Identifier: Apache-2.0
#include "strip_residuals.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "charts.h"
#include "statistics.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::size_t kMostResidualCharts = 18;
constexpr std::size_t kMostResidualDots = 400;
constexpr std::size_t kMedianBins = 10, kLeastInMedianBin = 3;

using Place = std::array<double, 2>;

/// How far a place lies ahead of what station k looks at, along the track [m].
double Ahead_m(std::span<const StripStation> strip,
               std::size_t k,
               const MapPlane& plane,
               const Place& place_m) {
  const Place before = plane.Place(strip[k > 0 ? k - 1 : k].antenna_m);
  const Place after = plane.Place(strip[std::min(k + 1, strip.size() - 1)].antenna_m);
  const Place track = {after[0] - before[0], after[1] - before[1]};
  Place origin = plane.Place(strip[k].antenna_m), ahead = track;
  if (strip[k].near_m.allFinite() && strip[k].far_m.allFinite()) {
    origin = plane.Place(strip[k].near_m);
    const Place far = plane.Place(strip[k].far_m);
    ahead = {origin[1] - far[1], far[0] - origin[0]};  // across the line from near to far
    if (ahead[0] * track[0] + ahead[1] * track[1] < 0.0) ahead = {-ahead[0], -ahead[1]};
  }
  return ((place_m[0] - origin[0]) * ahead[0] + (place_m[1] - origin[1]) * ahead[1]) /
         std::hypot(ahead[0], ahead[1]);
}

double TrendOf_1(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  if (x.size() < 5) return 0.0;
  const double mean_x = std::accumulate(x.begin(), x.end(), 0.0) / n;
  const double mean_y = std::accumulate(y.begin(), y.end(), 0.0) / n;
  double xx = 0.0, xy = 0.0, yy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
    yy += (y[i] - mean_y) * (y[i] - mean_y);
  }
  const double trend_1 = std::abs(xy) / std::sqrt(xx * yy) * std::sqrt(n);
  return std::isfinite(trend_1) ? trend_1 : 0.0;
}

PageFigure FigureOfStrip(const ResultFolder& result,
                         const StripResiduals& strip,
                         std::size_t number) {
  XyChart chart;
  chart.x.label = "time along the strip [s]";
  chart.y.label = "residual [m]";

  constexpr const char* kColors[] = {"sky", "yellow"};
  constexpr const char* kLineColors[] = {"blue", "orange"};
  const std::vector<std::uint32_t> shown = SampleIndices(strip.time_s.size(), kMostResidualDots);
  for (std::size_t k = 0; k < 2; ++k) {
    ChartSeries dots{kLookComponents[k], "points", kColors[k], {}, {}, {}, {}, {}};
    for (const std::uint32_t i : shown) {
      dots.x.push_back(strip.time_s[i]);
      dots.y.push_back(strip.residual_m[k][i]);
      const std::uint32_t point = result.file.looks.point[strip.looks[i]];
      dots.names.emplace_back(result.file.points.ids[point]);
    }
    chart.series.push_back(std::move(dots));
  }
  for (std::size_t k = 0; k < 2; ++k) {
    ChartSeries line{
        std::string(kLookComponents[k]) + ", median", "line", kLineColors[k], {}, {}, {}, {}, {}};
    for (const BinnedMedian& bin :
         MedianInBins(strip.time_s, strip.residual_m[k], kMedianBins, kLeastInMedianBin)) {
      line.x.push_back(bin.x);
      line.y.push_back(bin.value);
    }
    if (line.x.size() > 1) chart.series.push_back(std::move(line));
  }
  const std::string id = fmt::format("along-{}", number);
  return {id, "Pass " + result.file.passes[strip.pass].id, "", "small", ChartJson(id, chart)};
}

}  // namespace

double StripTimeOf_s(std::span<const StripStation> strip,
                     const MapPlane& plane,
                     const Place& place_m) {
  if (strip.size() < 2) return kAbsent;
  double ahead_m = Ahead_m(strip, 0, plane, place_m);
  for (std::size_t k = 1; k < strip.size(); ++k) {
    const double next_m = Ahead_m(strip, k, plane, place_m);
    const bool last = k + 1 == strip.size();
    if (next_m <= 0.0 || last) {
      const double part = ahead_m / (ahead_m - next_m);
      if (!(part >= -1.0 && part <= 2.0)) return kAbsent;
      return strip[k - 1].time_s + part * (strip[k].time_s - strip[k - 1].time_s);
    }
    ahead_m = next_m;
  }
  return kAbsent;
}

double StripResiduals::Trend_1() const {
  return std::max(TrendOf_1(time_s, residual_m[0]), TrendOf_1(time_s, residual_m[1]));
}

std::vector<StripResiduals> ResidualsAlongStrips(const ResultFolder& result) {
  const ResultLooks& looks = result.file.looks;
  const MapPlane plane(result);
  std::vector<std::span<const StripStation>> strip_of(result.file.passes.size());
  for (const auto& strip : StripsOf(result.file)) strip_of[strip.front().pass] = strip;
  std::vector<StripResiduals> by_pass(result.file.passes.size());
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const Eigen::Vector3d& position_m = result.file.points.results.position_m[looks.point[i]];
    const std::array<double, 2> residual_m{looks.range_residual_m[i], looks.azimuth_residual_m[i]};
    if (looks.rejected[i] != 0 || !position_m.allFinite() || std::isnan(residual_m[0]) ||
        std::isnan(residual_m[1])) {
      continue;
    }
    const double time_s = StripTimeOf_s(strip_of[looks.pass[i]], plane, plane.Place(position_m));
    if (std::isnan(time_s)) continue;
    StripResiduals& pass = by_pass[looks.pass[i]];
    pass.looks.push_back(i);
    pass.time_s.push_back(time_s);
    for (std::size_t k = 0; k < 2; ++k) pass.residual_m[k].push_back(residual_m[k]);
  }
  std::vector<StripResiduals> out;
  for (std::uint32_t p = 0; p < by_pass.size(); ++p) {
    by_pass[p].pass = p;
    if (!by_pass[p].looks.empty()) out.push_back(std::move(by_pass[p]));
  }
  return out;
}

std::vector<PageItem> StripResidualItems(const ResultFolder& result) {
  std::vector<StripResiduals> strips = ResidualsAlongStrips(result);
  if (strips.empty()) {
    if (result.file.looks.size() == 0 || result.file.summary.status == "predicted") return {};
    return {PageText{"Residuals along the strips: the result has no strips.csv to place them.",
                     "note"}};
  }
  std::string note =
      "Residuals of the looks of each pass against the time along its strip, with medians. They "
      "should scatter about zero all along: an offset asks for a bias, a slope for a drift, a bow "
      "for a quadratic term of the flight path. Each chart has its own scale.";
  const std::size_t all = strips.size();
  if (all > kMostResidualCharts) {
    std::stable_sort(
        strips.begin(), strips.end(), [](const StripResiduals& a, const StripResiduals& b) {
          return a.Trend_1() > b.Trend_1();
        });
    strips.resize(kMostResidualCharts);
    note += fmt::format(" The {} of {} passes with the largest trend.", kMostResidualCharts, all);
  }
  PageFigures figures;
  for (std::size_t i = 0; i < strips.size(); ++i) {
    figures.figures.push_back(FigureOfStrip(result, strips[i], i));
  }
  return {PageText{"Along the strips", "heading"}, std::move(figures), PageText{note, "note"}};
}

}  // namespace sarblock
