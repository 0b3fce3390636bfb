// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <unordered_map>

#include "page.h"
#include "result_page.h"
#include <fmt/format.h>

namespace sarblock {
namespace {

constexpr double kHistogramEnd = 5.0;
constexpr std::size_t kHistogramBins = 40;
constexpr std::size_t kMaxQuantiles = 600;

double NormalDensity(double w) {
  return std::exp(-0.5 * w * w) / std::sqrt(2.0 * std::numbers::pi);
}

PageFigure HistogramFigure(const std::vector<float>& w, std::size_t k) {
  const Histogram histogram = CountInBins(w, -kHistogramEnd, kHistogramEnd, kHistogramBins);
  const double bin = 2.0 * kHistogramEnd / static_cast<double>(kHistogramBins);
  XyChart chart;
  chart.x = {"standardised residual w", false, -kHistogramEnd, kHistogramEnd};
  chart.y = {"looks", false, 0.0, kAbsent};
  ChartSeries steps{"looks", "steps", k == 0 ? "blue" : "green", {}, {}, {}, {}, {}};
  for (std::size_t b = 0; b < kHistogramBins; ++b) {
    steps.x.push_back(-kHistogramEnd + bin * static_cast<double>(b));
    steps.y.push_back(static_cast<double>(histogram.counts[b]));
  }
  steps.x.push_back(kHistogramEnd);
  steps.y.push_back(0.0);
  ChartSeries normal{"expected", "line", "ink", {}, {}, {}, {}, {}};
  const auto total = static_cast<double>(histogram.total());
  for (int i = 0; i <= 80; ++i) {
    const double at = -kHistogramEnd + 2.0 * kHistogramEnd * i / 80.0;
    normal.x.push_back(at);
    normal.y.push_back(total * bin * NormalDensity(at));
  }
  chart.series = {steps, normal};
  const std::size_t outside = histogram.below + histogram.above;
  const std::string id = fmt::format("histogram-{}", kLookComponents[k]);
  return {id,
          Capital(kLookComponents[k]) + " residuals",
          outside == 0 ? ""
                       : fmt::format("{} beyond {} are counted in the outermost bins.",
                                     ReadableCount(static_cast<double>(outside)),
                                     kHistogramEnd),
          "half",
          ChartJson(id, chart)};
}

PageFigure QuantileFigure(const std::vector<float>& w, std::size_t k) {
  XyChart chart;
  chart.x.label = "normal quantile";
  chart.y.label = "standardised residual w";
  ChartSeries dots{"looks", "points", k == 0 ? "blue" : "green", {}, {}, {}, {}, {}};
  for (const QuantilePoint& point : NormalQuantilePlot(w, kMaxQuantiles)) {
    dots.x.push_back(point.expected);
    dots.y.push_back(point.value);
  }
  const double end = dots.x.empty() ? 3.0 : std::max(-dots.x.front(), dots.x.back());
  ChartSeries line{"expected", "line", "ink", {-end, end}, {-end, end}, {}, {}, {}};
  chart.series = {line, dots};
  const std::string id = fmt::format("quantiles-{}", kLookComponents[k]);
  return {id,
          Capital(kLookComponents[k]) + " against the normal distribution",
          "",
          "half",
          ChartJson(id, chart)};
}

struct Moments {
  double mean = kAbsent, deviation = kAbsent, largest = kAbsent;
};
Moments MomentsOf(const std::vector<float>& values) {
  double sum = 0.0, squares = 0.0, largest = 0.0;
  for (const float value : values) {
    const auto v = static_cast<double>(value);
    sum += v;
    squares += v * v;
    largest = std::max(largest, std::abs(v));
  }
  const auto n = static_cast<double>(values.size());
  if (n == 0.0) return {};
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean)), largest};
}

std::vector<double> Doubles(const std::vector<float>& values) {
  return {values.begin(), values.end()};
}

PageTable ResidualTable(const ReportLooks& looks) {
  PageTable table;
  table.columns = {{"component", false},
                   {"looks", true},
                   {"rms residual [m]", true},
                   {"mean w", true},
                   {"deviation of w", true},
                   {"largest |w|", true},
                   {"median redundancy", true},
                   {"median detectable blunder [m]", true},
                   {"its median influence [m]", true}};
  for (std::size_t k = 0; k < 2; ++k) {
    const Moments residual = MomentsOf(looks.residual_m[k]);
    const Moments w = MomentsOf(looks.w[k]);
    table.rows.push_back({kLookComponents[k],
                          ReadableCount(static_cast<double>(looks.residual_m[k].size())),
                          Shown(std::hypot(residual.mean, residual.deviation), 3),
                          Shown(w.mean, 2),
                          Shown(w.deviation, 3),
                          Shown(w.largest, 3),
                          Shown(SampleQuantile(Doubles(looks.redundancy[k]), 0.5), 3),
                          Shown(SampleQuantile(Doubles(looks.mdb_m[k]), 0.5), 3),
                          Shown(SampleQuantile(Doubles(looks.influence_m[k]), 0.5), 3)});
  }
  table.note =
      "w should have mean 0 and deviation 1. A deviation of range and of azimuth that differ from "
      "1 in different ways call for variance components.";
  return table;
}

}  // namespace

PageSection ResidualSection(const ResultFolder& result) {
  PageSection section{"residuals", "Residuals", StripResidualItems(result)};
  const ReportLooks& looks = result.looks;
  if (looks.w[0].empty() && looks.w[1].empty()) {
    section.items.emplace_back(PageText{result.file.summary.status == "predicted"
                                            ? "A prediction has no residuals: nothing was measured."
                                            : "The result has no standardised residuals: they come "
                                              "with a covariance of the adjustment.",
                                        "note"});
    if (!looks.residual_m[0].empty()) section.items.emplace_back(ResidualTable(looks));
    return section;
  }
  section.items.emplace_back(PageText{"Standardised", "heading"});
  PageFigures figures;
  for (std::size_t k = 0; k < 2; ++k) {
    if (looks.w[k].empty()) continue;
    figures.figures.push_back(HistogramFigure(looks.w[k], k));
    figures.figures.push_back(QuantileFigure(looks.w[k], k));
  }
  section.items.emplace_back(std::move(figures));
  section.items.emplace_back(ResidualTable(looks));
  return section;
}

namespace {

constexpr std::size_t kMaxResidualCharts = 18;
constexpr std::size_t kMaxResidualDots = 400;
constexpr std::size_t kMedianBins = 10, kMinInMedianBin = 3;

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

double TrendOf(const std::vector<double>& x, const std::vector<double>& y) {
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
  const double trend = std::abs(xy) / std::sqrt(xx * yy) * std::sqrt(n);
  return std::isfinite(trend) ? trend : 0.0;
}

PageFigure FigureOfStrip(const ResultFolder& result,
                         const StripResiduals& strip,
                         std::size_t number) {
  XyChart chart;
  chart.x.label = "time along the strip [s]";
  chart.y.label = "residual [m]";

  constexpr const char* kColors[] = {"sky", "yellow"};
  constexpr const char* kLineColors[] = {"blue", "orange"};
  const std::vector<std::uint32_t> shown = SampleIndices(strip.time_s.size(), kMaxResidualDots);
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
         MedianInBins(strip.time_s, strip.residual_m[k], kMedianBins, kMinInMedianBin)) {
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

double StripResiduals::Trend() const {
  return std::max(TrendOf(time_s, residual_m[0]), TrendOf(time_s, residual_m[1]));
}

std::vector<StripResiduals> ResidualsAlongStrips(const ResultFolder& result) {
  const files::ResultLooks& looks = result.file.looks;
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
  if (all > kMaxResidualCharts) {
    std::stable_sort(
        strips.begin(), strips.end(), [](const StripResiduals& a, const StripResiduals& b) {
          return a.Trend() > b.Trend();
        });
    strips.resize(kMaxResidualCharts);
    note += fmt::format(" The {} of {} passes with the largest trend.", kMaxResidualCharts, all);
  }
  PageFigures figures;
  for (std::size_t i = 0; i < strips.size(); ++i) {
    figures.figures.push_back(FigureOfStrip(result, strips[i], i));
  }
  return {PageText{"Along the strips", "heading"}, std::move(figures), PageText{note, "note"}};
}

namespace {

double ResidualOf_m(const files::ResultLooks& looks, std::size_t look, std::size_t component) {
  return component == 0 ? looks.range_residual_m[look] : looks.azimuth_residual_m[look];
}

/// The largest |w| by point: the looks of one point share a blunder, so they are one row.
PageTable WorstTable(const ResultFolder& result, double critical) {
  PageTable table;
  table.title = "Worst looks by point";
  table.columns = {{"point", false},
                   {"largest w", true},
                   {"of", false},
                   {"residual [m]", true},
                   {"redundancy", true},
                   {"minimal detectable blunder [m]", true},
                   {"its influence on the point [m]", true},
                   {"further w of the point", false}};
  const files::ResultFile& file = result.file;
  const files::ResultLooks& looks = file.looks;
  std::vector<std::vector<ReportLook>> d_point;
  std::unordered_map<std::uint32_t, std::size_t> row_of;
  for (const ReportLook& look : result.looks.worst) {
    const auto [found, added] = row_of.emplace(looks.point[look.look], d_point.size());
    if (added) d_point.emplace_back();
    d_point[found->second].push_back(look);
  }
  constexpr std::size_t kMaxRows = 100, kMaxFurtherRows = 4;
  const auto name = [&](const ReportLook& look) {
    return file.passes[looks.pass[look.look]].id + " " + kLookComponents[look.component];
  };
  const auto w_of = [&](const ReportLook& look) {
    return static_cast<double>(looks.quality.w[look.component][look.look]);
  };
  for (std::size_t p = 0; p < std::min(d_point.size(), kMaxRows); ++p) {
    const ReportLook& first = d_point[p].front();
    const auto figure = [&](const std::array<std::vector<float>, 2>& of_looks) {
      const std::vector<float>& values = of_looks[first.component];
      return Shown(values.empty() ? kAbsent : static_cast<double>(values[first.look]), 3);
    };
    std::string further;
    for (std::size_t i = 1; i < d_point[p].size(); ++i) {
      if (i > kMaxFurtherRows) {
        further += fmt::format(" and {} more", d_point[p].size() - i);
        break;
      }
      further += fmt::format(
          "{}{} {}", i == 1 ? "" : ", ", name(d_point[p][i]), Shown(w_of(d_point[p][i]), 3));
    }
    if (std::abs(w_of(first)) > critical) table.marked.push_back(p);
    table.rows.push_back({std::string(file.points.ids[looks.point[first.look]]),
                          Shown(w_of(first), 3),
                          name(first),
                          Shown(ResidualOf_m(looks, first.look, first.component), 3),
                          figure(looks.quality.redundancy),
                          figure(looks.mdb_m),
                          figure(looks.influence_m),
                          further});
  }
  table.note = fmt::format(
      "The {} largest |w| whose redundancy is {} at least, by point; beyond the critical value "
      "they "
      "are marked. The minimal detectable blunder is found with a power of {}; smaller ones may "
      "stay, and move the point by up to the influence.",
      result.looks.worst.size(),
      ReportLooks::kMinTested,
      ShownPercent(file.summary.tests ? file.summary.tests->power : kAbsent));
  return table;
}

PageTable FindingTable(const files::ResultSummary& summary) {
  constexpr std::size_t kRows = 300;
  PageTable table;
  table.title = "What the search for blunders found";
  table.columns = {{"round", true},
                   {"point", false},
                   {"passes", false},
                   {"component", false},
                   {"w", true},
                   {"located", false},
                   {"done", false},
                   {"note", false}};
  for (std::size_t i = 0; i < std::min(kRows, summary.findings.size()); ++i) {
    const files::ResultFinding& f = summary.findings[i];
    std::vector<std::string> suspects = f.passes;
    if (f.control) suspects.emplace_back("control");
    table.rows.push_back({std::to_string(f.round),
                          f.point,
                          fmt::format("{}", fmt::join(suspects, ", ")),
                          f.component,
                          Shown(f.w, 3),
                          f.located ? "yes" : "no",
                          f.action,
                          f.note});
  }
  table.note =
      fmt::format("{} findings in {} rounds{}.",
                  summary.findings.size(),
                  *summary.snooping_rounds,
                  summary.findings.size() > kRows ? "; the others are in summary.json" : "");
  return table;
}

}  // namespace

PageSection WorstLooksSection(const ResultFolder& result) {
  PageSection section{"worst", "Worst looks", {}};
  const ReportLooks& looks = result.looks;
  const auto& tests = result.file.summary.tests;
  if (looks.worst.empty()) {
    section.items.emplace_back(PageText{"No look was tested.", "note"});
  } else {
    if (tests) {
      section.items.emplace_back(PageText{
          fmt::format("{} observations were tested one by one at level {}: |w| above {} is rare. "
                      "{} range, {} azimuth and {} control components are above it, {} "
                      "are expected by chance. {} looks belong to points with one degree of "
                      "freedom, where a blunder shows but cannot be located.",
                      ReadableCount(tests->tests),
                      Shown(tests->alpha, 2),
                      Shown(tests->critical_w, 3),
                      tests->above[0],
                      tests->above[1],
                      tests->above[2],
                      Shown(tests->expected_above, 2),
                      ReadableCount(tests->not_localisable)),
          ""});
    }
    section.items.emplace_back(WorstTable(result, tests ? tests->critical_w : kAbsent));
  }
  if (result.file.summary.snooping_rounds && !result.file.summary.findings.empty()) {
    section.items.emplace_back(FindingTable(result.file.summary));
  }
  if (!looks.left_out.empty()) {
    PageTable table;
    table.title = "Looks that were left out";
    table.columns = {
        {"pass", false}, {"point", false}, {"reason", false}, {"largest residual [m]", true}};
    const files::ResultLooks& all = result.file.looks;
    for (const auto& [look, k] : looks.left_out) {
      table.rows.push_back({result.file.passes[all.pass[look]].id,
                            std::string(result.file.points.ids[all.point[look]]),
                            NameOf(all.reason[look]),
                            Shown(ResidualOf_m(all, look, k), 3) + " " + kLookComponents[k]});
    }
    table.note = fmt::format(
        "{} of {}, the largest residuals first. A list to use again: --rejections with "
        "residuals.csv.",
        looks.left_out.size(),
        ReadableCount(looks.rejected));
    section.items.emplace_back(std::move(table));
  }
  return section;
}

}  // namespace sarblock
