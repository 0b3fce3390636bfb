// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "charts.h"
#include "html.h"
#include "sections.h"
#include "statistics.h"
#include "strip_residuals.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr double kHistogramEnd = 5.0;
constexpr std::size_t kHistogramBins = 40;
constexpr std::size_t kMostQuantiles = 600;

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
  for (const QuantilePoint& point : NormalQuantilePlot(w, kMostQuantiles)) {
    dots.x.push_back(point.expected_1);
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
    const Moments w = MomentsOf(looks.w_1[k]);
    table.rows.push_back({kLookComponents[k],
                          ReadableCount(static_cast<double>(looks.residual_m[k].size())),
                          Shown(std::hypot(residual.mean, residual.deviation), 3),
                          Shown(w.mean, 2),
                          Shown(w.deviation, 3),
                          Shown(w.largest, 3),
                          Shown(SampleQuantile(Doubles(looks.redundancy_1[k]), 0.5), 3),
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
  if (looks.w_1[0].empty() && looks.w_1[1].empty()) {
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
    if (looks.w_1[k].empty()) continue;
    figures.figures.push_back(HistogramFigure(looks.w_1[k], k));
    figures.figures.push_back(QuantileFigure(looks.w_1[k], k));
  }
  section.items.emplace_back(std::move(figures));
  section.items.emplace_back(ResidualTable(looks));
  return section;
}

}  // namespace sarblock
