// SPDX-License-Identifier: Apache-2.0
#include "page.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <string_view>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

const char* ClassOf(HeadlineState state) {
  switch (state) {
    case HeadlineState::kAccepted:
      return "accepted";
    case HeadlineState::kTestsFailed:
      return "failed";
    case HeadlineState::kNotAccepted:
      return "refused";
    case HeadlineState::kNeutral:
      break;
  }
  return "neutral";
}

std::string Base64(std::string_view bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group =
          (group << 8U) | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k <= bytes.size() ? kDigits[(group >> (18U - 6U * static_cast<unsigned>(k))) & 63U]
                                   : '=';
    }
  }
  return out;
}

class Renderer {
 public:
  std::string Render(const Page& page) {
    std::string contents;
    for (const PageSection& section : page.sections) {
      contents +=
          fmt::format("<li><a href=\"#{}\">{}</a></li>\n", section.id, EscapeHtml(section.title));
      html_ +=
          fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n", section.id, EscapeHtml(section.title));
      for (const PageItem& item : section.items) {
        std::visit([this](const auto& value) { Add(value); }, item);
      }
      html_ += "</section>\n";
    }
    const std::map<std::string_view, std::string> values = {
        {"title", EscapeHtml(page.title)},
        {"kind", EscapeHtml(page.kind)},
        {"subtitle", EscapeHtml(page.subtitle)},
        {"state", ClassOf(page.headline.state)},
        {"word", EscapeHtml(page.headline.word)},
        {"verdict", HeadlineText(page)},
        {"contents", contents},
        {"sections", html_},
        {"version", EscapeHtml(Version())},
        {"style", std::string(AssetText("style.css"))},
        {"charts", std::string(AssetText("charts.js"))},
        {"map", std::string(AssetText("map.js"))},
        {"tables", std::string(AssetText("tables.js"))},
        {"script", std::string(AssetText("report.js"))},
        {"chart_library", std::string(AssetText("chart.min.js"))},
        {"chart_licence", EscapeHtml(AssetText("chart_licence.txt"))},
        {"data", EscapeScriptJson("{\"charts\":[" + charts_ + "]}")}};
    return Fill(AssetText("page.html"), values);
  }

 private:
  /// The template with every {{name}} replaced.
  static std::string Fill(std::string_view text,
                          const std::map<std::string_view, std::string>& values) {
    std::string out;
    for (;;) {
      const std::size_t open = text.find("{{");
      out += text.substr(0, open);
      if (open == std::string_view::npos) return out;
      const std::size_t close = text.find("}}", open);
      out += values.at(text.substr(open + 2, close - open - 2));
      text.remove_prefix(close + 2);
    }
  }

  static std::string Facts(const std::vector<PageFact>& facts) {
    if (facts.empty()) return "";
    std::string out = "<dl class=\"facts\">\n";
    for (const PageFact& fact : facts) {
      out += fmt::format("<div><dt>{}</dt><dd><b>{}</b> <span>{}</span></dd></div>\n",
                         EscapeHtml(fact.label),
                         EscapeHtml(fact.value),
                         EscapeHtml(fact.remark));
    }
    return out + "</dl>\n";
  }

  static std::string HeadlineText(const Page& page) {
    std::string out;
    for (const std::string& sentence : page.headline.sentences) {
      out += "<p>" + KeepPercent(EscapeHtml(sentence)) + "</p>\n";
    }
    out += Facts(page.facts);
    if (!page.headline.attention.empty()) {
      out += "<p class=\"attention\">Look at:</p>\n<ul>\n";
      for (const std::string& line : page.headline.attention) {
        out += "<li>" + KeepPercent(EscapeHtml(line)) + "</li>\n";
      }
      out += "</ul>\n";
    }
    return out;
  }

  /// With spaces before percent signs that do not break.
  static std::string KeepPercent(std::string text) {
    constexpr std::string_view kBreaking = " %", kKept = "&#160;%";
    for (std::size_t at = text.find(kBreaking); at != std::string::npos;
         at = text.find(kBreaking, at)) {
      text.replace(at, kBreaking.size(), kKept);
    }
    return text;
  }

  void Add(const PageText& text) {
    if (text.kind == "heading") {
      html_ += fmt::format("<h3>{}</h3>\n", EscapeHtml(text.text));
      return;
    }
    html_ += fmt::format("<p{}>{}</p>\n",
                         text.kind.empty() ? "" : " class=\"" + text.kind + "\"",
                         EscapeHtml(text.text));
  }

  void Add(const PageTable& table) {
    if (table.folded) {
      html_ += fmt::format("<details>\n<summary>{}</summary>\n", EscapeHtml(table.title));
    } else if (!table.title.empty()) {
      html_ += fmt::format("<h3>{}</h3>\n", EscapeHtml(table.title));
    }
    html_ += fmt::format("<div class=\"scroll\"><table{}>\n<thead><tr>",
                         table.plain ? " class=\"plain\"" : "");
    for (const PageColumn& column : table.columns) {
      html_ += fmt::format(
          "<th{}>{}</th>", column.number ? " class=\"n\"" : "", EscapeHtml(column.title));
    }
    html_ += "</tr></thead>\n<tbody>\n";
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      const bool marked =
          std::find(table.marked.begin(), table.marked.end(), r) != table.marked.end();
      html_ += marked ? "<tr class=\"marked\">" : "<tr>";
      for (std::size_t c = 0; c < table.rows[r].size(); ++c) {
        const bool number = c < table.columns.size() && table.columns[c].number;
        html_ += fmt::format(
            "<td{}>{}</td>", number ? " class=\"n\"" : "", EscapeHtml(table.rows[r][c]));
      }
      html_ += "</tr>\n";
    }
    html_ += "</tbody>\n</table></div>\n";
    if (!table.note.empty()) Add(PageText{table.note, "note"});
    if (table.folded) html_ += "</details>\n";
  }

  void Add(const PageFigure& figure) {
    html_ += fmt::format(
        "<figure class=\"{0}\"><h3>{1}</h3>\n<div class=\"canvas\"><canvas id=\"{2}\" role=\"img\" "
        "aria-label=\"{1}\"></canvas></div>\n",
        figure.size,
        EscapeHtml(figure.title),
        EscapeHtml(figure.id));
    if (!figure.caption.empty()) {
      html_ += fmt::format("<figcaption>{}</figcaption>\n", EscapeHtml(figure.caption));
    }
    html_ += "</figure>\n";
    charts_ += (charts_.empty() ? "" : ",\n") + figure.json;
  }

  void Add(const PageFigures& group) {
    html_ += "<div class=\"figures\">\n";
    for (const PageFigure& figure : group.figures) Add(figure);
    html_ += "</div>\n";
  }

  void Add(const PagePicture& picture) {
    html_ += fmt::format(
        "<figure class=\"wide\"><h3>{0}</h3>\n<img alt=\"{0}\" "
        "src=\"data:image/svg+xml;base64,{1}\"></figure>\n",
        EscapeHtml(picture.title),
        Base64(picture.svg));
  }

  void Add(const PageFacts& facts) { html_ += Facts(facts.facts); }

  void Add(const PageList& list) {
    html_ += "<ul>\n";
    for (const std::string& item : list.items) html_ += "<li>" + EscapeHtml(item) + "</li>\n";
    html_ += "</ul>\n";
  }

  void Add(const PagePre& pre) {
    html_ += fmt::format("<details>\n<summary>{}</summary>\n<pre>{}</pre>\n</details>\n",
                         EscapeHtml(pre.title),
                         EscapeHtml(pre.text));
  }

  std::string html_;
  std::string charts_;
};

}  // namespace

std::string RenderPage(const Page& page) { return Renderer().Render(page); }

namespace {

constexpr std::string_view kReplacement = "\xef\xbf\xbd";
constexpr std::string_view kThinSpace = "\xe2\x80\xaf";  // narrow and not breaking

/// Bytes of the well-formed UTF-8 sequence at `at`; 0 where there is none.
std::size_t SequenceLength(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(at);
  if (lead < 0x80U) return 1;
  const std::size_t length = lead >= 0xf0U ? 4 : (lead >= 0xe0U ? 3 : 2);
  if (lead < 0xc2U || lead > 0xf4U || at + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xc0U) != 0x80U) return 0;
  }
  const unsigned second = byte(at + 1);
  const bool overlong = (lead == 0xe0U && second < 0xa0U) || (lead == 0xf0U && second < 0x90U);
  const bool surrogate = lead == 0xedU && second >= 0xa0U;
  const bool beyond = lead == 0xf4U && second >= 0x90U;
  return overlong || surrogate || beyond ? 0 : length;
}

std::string Grouped(const std::string& number) {
  const std::size_t start = number.find_first_of("0123456789");
  std::size_t end = number.find_first_not_of("0123456789", start);
  if (end == std::string::npos) end = number.size();
  if (start == std::string::npos || end - start < 5) return number;
  std::string out = number.substr(0, start);
  for (std::size_t i = start; i < end; ++i) {
    if (i > start && (end - i) % 3 == 0) out += kThinSpace;
    out += number[i];
  }
  return out + number.substr(end);
}

}  // namespace

std::string EscapeHtml(std::string_view text) {
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = SequenceLength(text, i);
    const char c = text[i];
    if (length == 0 || (static_cast<unsigned char>(c) < 0x20U && c != '\t' && c != '\n') ||
        c == '\x7f') {
      out += kReplacement;
      ++i;
      continue;
    }
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += text.substr(i, length);
    }
    i += length;
  }
  return out;
}

std::string EscapeScriptJson(std::string_view json) {
  std::string out;
  out.reserve(json.size() + json.size() / 64);
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (c == '<' || c == '>' || c == '&') {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else if (json.substr(i, 3) == "\xe2\x80\xa8" || json.substr(i, 3) == "\xe2\x80\xa9") {
      out += json[i + 2] == '\xa8' ? "\\u2028" : "\\u2029";
      i += 2;
    } else {
      out += c;
    }
  }
  return out;
}

std::string ReadableNumber(double value, int digits) {
  if (std::isnan(value)) return "-";
  if (std::isinf(value)) return value > 0 ? "infinite" : "-infinite";
  if (value == 0.0) return "0";
  const double size = std::abs(value);
  if (size < 1e-5 || size >= 1e9) return fmt::format("{:.{}e}", value, digits - 1);
  const int before = static_cast<int>(std::floor(std::log10(size))) + 1;
  return Grouped(fmt::format("{:.{}f}", value, std::max(0, digits - before)));
}

std::string ReadableCount(double count) {
  return std::isnan(count) ? "-" : Grouped(fmt::format("{:.0f}", count));
}

std::string Shown(double value, int digits) { return ReadableNumber(value, digits); }

std::string ShownPercent(double part) {
  return std::isnan(part) ? "-" : ReadableNumber(100.0 * part, 3) + " %";
}

std::string ShownWithSigma(double value, double sigma) {
  return std::isnan(sigma) ? Shown(value) : Shown(value) + " \xc2\xb1 " + Shown(sigma, 2);
}

std::string Capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') {
    text[0] = static_cast<char>(text[0] - 'a' + 'A');
  }
  return text;
}

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

namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// A well mixed function of an index (the finaliser of splitmix64).
std::uint64_t Mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

double QuantileOfSorted(const std::vector<double>& sorted, double probability) {
  if (sorted.empty()) return kNothing;
  const double position = probability * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(position);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return sorted[low] + (position - static_cast<double>(low)) * (sorted[high] - sorted[low]);
}

double Cross(const std::array<double, 2>& o,
             const std::array<double, 2>& a,
             const std::array<double, 2>& b) {
  return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
}

}  // namespace

double SampleQuantile(std::vector<double> values, double probability) {
  return SampleQuantiles(std::move(values), std::array{probability})[0];
}

std::vector<double> SampleQuantiles(std::vector<double> values,
                                    std::span<const double> probabilities) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  std::sort(values.begin(), values.end());
  std::vector<double> out;
  for (const double p : probabilities) out.push_back(QuantileOfSorted(values, p));
  return out;
}

std::size_t Histogram::total() const {
  return std::accumulate(counts.begin(), counts.end(), std::size_t{0});
}

Histogram CountInBins(std::span<const float> values, double lower, double upper, std::size_t bins) {
  Histogram out{lower, upper, std::vector<std::size_t>(bins, 0)};
  const double per_bin = (upper - lower) / static_cast<double>(bins);
  for (const float value : values) {
    const auto v = static_cast<double>(value);
    if (std::isnan(v)) continue;
    if (v < lower) ++out.below;
    if (v > upper) ++out.above;
    const double last = static_cast<double>(bins - 1);
    const double bin = std::clamp(std::floor((v - lower) / per_bin), 0.0, last);
    ++out.counts[static_cast<std::size_t>(bin)];
  }
  return out;
}

std::vector<QuantilePoint> NormalQuantilePlot(std::span<const float> values, std::size_t most) {
  std::vector<float> sorted(values.begin(), values.end());
  std::erase_if(sorted, [](float v) { return std::isnan(v); });
  std::sort(sorted.begin(), sorted.end());
  const std::size_t n = sorted.size();
  const auto point = [&](std::size_t i) {
    const double p = (static_cast<double>(i) + 0.5) / static_cast<double>(n);
    return QuantilePoint{NormalQuantile(p), static_cast<double>(sorted[i])};
  };
  std::vector<QuantilePoint> out;
  if (n <= most) {
    for (std::size_t i = 0; i < n; ++i) out.push_back(point(i));
    return out;
  }
  const std::size_t tail = most / 4;
  const std::size_t middle = most - 2 * tail;
  for (std::size_t i = 0; i < tail; ++i) out.push_back(point(i));
  const std::size_t span = n - 2 * tail;
  for (std::size_t i = 0; i < middle; ++i)
    out.push_back(point(tail + (2 * i + 1) * span / (2 * middle)));
  for (std::size_t i = n - tail; i < n; ++i) out.push_back(point(i));
  return out;
}

std::vector<std::uint32_t> SampleIndices(std::size_t count, std::size_t most) {
  std::vector<std::uint32_t> out(count);
  std::iota(out.begin(), out.end(), 0U);
  if (count <= most) return out;
  const auto end = out.begin() + static_cast<std::ptrdiff_t>(most);
  std::nth_element(out.begin(), end, out.end(), [](auto a, auto b) { return Mixed(a) < Mixed(b); });
  out.resize(most);
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<BinnedMedian> MedianInBins(std::span<const double> x,
                                       std::span<const double> values,
                                       std::size_t bins,
                                       std::size_t least) {
  double low = kNothing, high = kNothing;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || std::isnan(values[i])) continue;
    low = std::fmin(low, x[i]);
    high = std::fmax(high, x[i]);
  }
  std::vector<BinnedMedian> out;
  if (!(high >= low)) return out;
  std::vector<std::vector<double>> of_bin(bins);
  const double width = high > low ? (high - low) / static_cast<double>(bins) : 1.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || std::isnan(values[i])) continue;
    const auto bin = static_cast<std::size_t>((x[i] - low) / width);
    of_bin[std::min(bin, bins - 1)].push_back(values[i]);
  }
  for (std::size_t b = 0; b < bins; ++b) {
    if (of_bin[b].empty() || of_bin[b].size() < least) continue;
    const std::size_t count = of_bin[b].size();
    out.push_back({low + (static_cast<double>(b) + 0.5) * width,
                   SampleQuantile(std::move(of_bin[b]), 0.5),
                   count});
  }
  return out;
}

double RoundDown125(double value) {
  if (!(value > 0.0) || !std::isfinite(value)) return 1.0;
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {10.0, 5.0, 2.0}) {
    if (step * power <= value * (1.0 + 1e-12)) return step * power;
  }
  return power;
}

ConvexHull::ConvexHull(std::vector<std::array<double, 2>> places_m) {
  std::erase_if(places_m,
                [](const auto& p) { return !std::isfinite(p[0]) || !std::isfinite(p[1]); });
  std::sort(places_m.begin(), places_m.end());
  places_m.erase(std::unique(places_m.begin(), places_m.end()), places_m.end());
  if (places_m.size() < 3) return;
  // Andrew's monotone chain: the lower hull, then the upper one.
  std::vector<std::array<double, 2>>& hull = corners_m_;
  const auto add = [&hull](const std::array<double, 2>& p, std::size_t least) {
    while (hull.size() >= least && Cross(hull[hull.size() - 2], hull.back(), p) <= 0.0) {
      hull.pop_back();
    }
    hull.push_back(p);
  };
  for (const auto& p : places_m) add(p, 2);
  const std::size_t lower = hull.size() + 1;
  for (std::size_t i = places_m.size() - 1; i-- > 0;) add(places_m[i], lower);
  hull.pop_back();
  if (hull.size() < 3) hull.clear();
}

bool ConvexHull::Contains(double x_m, double y_m) const {
  if (!HasArea()) return false;
  for (std::size_t i = 0; i < corners_m_.size(); ++i) {
    const auto& a = corners_m_[i];
    const auto& b = corners_m_[(i + 1) % corners_m_.size()];
    if (Cross(a, b, {x_m, y_m}) < 0.0) return false;
  }
  return true;
}

}  // namespace sarblock
