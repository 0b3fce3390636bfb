// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numeric>

#include "charts.h"
#include "html.h"
#include "sections.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::size_t kMostCharts = 18;
constexpr std::size_t kMostParameterRows = 40;
constexpr const char* kTrackAxes[] = {"along", "across", "up"};
constexpr const char* kTrackColors[] = {"blue", "orange", "green"};

bool Corrected(const ReportStrip& strip) {
  return !strip.correction_m.empty() && !std::isnan(strip.correction_m.front()[0]);
}

/// Largest correction over its standard deviation, along the strip.
double Significance(const ReportStrip& strip) {
  double largest = 0.0;
  for (std::size_t i = 0; i < strip.correction_m.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double ratio = std::abs(strip.correction_m[i][k]) / strip.correction_sigma_m[i][k];
      if (std::isfinite(ratio)) largest = std::max(largest, ratio);
    }
  }
  return largest;
}

PageFigure StripFigure(const ReportStrip& strip, std::size_t number) {
  XyChart chart;
  chart.x = {"strip from start to end", false, -1.0, 1.0};
  chart.y.label = "correction [m]";
  for (std::size_t k = 0; k < 3; ++k) {
    ChartSeries band{"", "band", kTrackColors[k], {}, {}, {}, {}, {}};
    ChartSeries line{kTrackAxes[k], "line", kTrackColors[k], {}, {}, {}, {}, {}};
    for (std::size_t i = 0; i < strip.correction_m.size(); ++i) {
      const double value_m = strip.correction_m[i][k];
      const double sigma_m = strip.correction_sigma_m[i][k];
      line.x.push_back(strip.strip_time_1[i]);
      line.y.push_back(value_m);
      if (std::isnan(sigma_m)) continue;
      band.x.push_back(strip.strip_time_1[i]);
      band.y.push_back(value_m);
      band.low.push_back(value_m - 2.0 * sigma_m);
      band.high.push_back(value_m + 2.0 * sigma_m);
    }
    const bool moved = std::any_of(line.y.begin(), line.y.end(), [](double v) { return v != 0.0; });
    if (!moved) continue;
    if (!band.x.empty()) chart.series.push_back(std::move(band));
    chart.series.push_back(std::move(line));
  }
  const std::string id = fmt::format("strip-{}", number);
  return {id, "Pass " + strip.pass, "", "small", ChartJson(id, chart)};
}

PageTable ParameterTable(const ResultFolder& result) {
  std::vector<std::size_t> order(result.parameters.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const double sa = result.parameters[a].significance, sb = result.parameters[b].significance;
    return std::isnan(sb) ? !std::isnan(sa) : sa > sb;
  });
  PageTable table;
  table.title = "Corrections, the most significant first";
  table.columns = {{"pass", false},
                   {"parameter", false},
                   {"value", true},
                   {"sigma", true},
                   {"unit", false},
                   {"prior sigma", true},
                   {"significance", true}};
  const std::size_t rows = std::min(order.size(), kMostParameterRows);
  for (std::size_t i = 0; i < rows; ++i) {
    const ReportParameter& p = result.parameters[order[i]];
    table.rows.push_back({p.pass,
                          p.name,
                          Shown(p.value),
                          Shown(p.sigma, 3),
                          p.unit,
                          Shown(p.prior_sigma, 3),
                          std::isnan(p.significance) ? "-" : Shown(p.significance, 3) + " sigma"});
  }
  const auto weak = std::count_if(result.parameters.begin(),
                                  result.parameters.end(),
                                  [](const ReportParameter& p) { return p.significance < 2.0; });
  const auto unlearned = std::count_if(
      result.parameters.begin(), result.parameters.end(), [](const ReportParameter& p) {
        return p.sigma > 0.9 * p.prior_sigma;
      });
  table.note = fmt::format(
      "{} of {} parameters. {} are below 2 sigma: the data do not ask for them. {} keep more than "
      "nine tenths of their prior sigma: the observations say little of them.",
      rows,
      order.size(),
      weak,
      unlearned);
  return table;
}

PageTable CorrelationTable(const ResultFolder& result) {
  PageTable table;
  table.title = "Correlations above 0.95";
  table.columns = {{"correction", false}, {"and", false}, {"correlation", true}};
  const auto name = [&](std::uint32_t i) {
    return result.parameters[i].pass + " " + result.parameters[i].name;
  };
  for (const ReportCorrelation& c : result.correlations) {
    table.rows.push_back({name(c.a), name(c.b), fmt::format("{:+.4f}", c.correlation_1)});
  }
  table.note = fmt::format(
      "{} of {}, the strongest first. The values of such a pair can be exchanged for each other "
      "with hardly a change of the fit: positions do not suffer, the single values mean little.",
      result.correlations.size(),
      result.correlation_count);
  return table;
}

PageTable CandidateTable(const ResultFolder& result) {
  PageTable table;
  table.title = "Candidates";
  table.columns = {{"candidate", false},
                   {"passes", false},
                   {"adds", true},
                   {"F", true},
                   {"p", true},
                   {"change of BIC", true},
                   {"condition", true},
                   {"verdict", false},
                   {"reason", false}};
  for (const ReportCandidate& c : result.candidates) {
    if (c.verdict == "kept") table.marked.push_back(table.rows.size());
    table.rows.push_back({c.name,
                          c.passes,
                          ReadableCount(c.parameters_1),
                          Shown(c.f_1, 3),
                          Shown(c.probability_1, 2),
                          Shown(c.delta_bic_1, 3),
                          Shown(c.condition, 2),
                          c.verdict,
                          c.reason});
  }
  return table;
}

}  // namespace

PageSection CorrectionSection(const ResultFolder& result) {
  PageSection section{"corrections", "Corrections of the passes", {}};
  if (result.parameters.empty()) {
    section.items.emplace_back(
        PageText{"No corrections were estimated: the flight paths were taken as given.", "note"});
    return section;
  }
  std::vector<const ReportStrip*> strips;
  for (const ReportStrip& strip : result.strips) {
    if (Corrected(strip)) strips.push_back(&strip);
  }
  const std::size_t all = strips.size();
  if (all > kMostCharts) {
    std::stable_sort(strips.begin(), strips.end(), [](const auto* a, const auto* b) {
      return Significance(*a) > Significance(*b);
    });
    strips.resize(kMostCharts);
  }
  const bool predicted = result.summary.status == "predicted";
  if (!strips.empty() && !predicted) {
    PageFigures figures;
    for (std::size_t i = 0; i < strips.size(); ++i) {
      figures.figures.push_back(StripFigure(*strips[i], i));
    }
    section.items.emplace_back(std::move(figures));
    std::string note =
        "Position correction along, across and up over each strip, with its band of two sigma. "
        "Each chart has its own scale.";
    if (all > kMostCharts) {
      note += fmt::format(" The {} most significant of {} passes.", kMostCharts, all);
    }
    section.items.emplace_back(PageText{note, "note"});
  }
  section.items.emplace_back(ParameterTable(result));
  if (result.correlation_count > 0) {
    section.items.emplace_back(CorrelationTable(result));
  } else {
    section.items.emplace_back(PageText{"No two corrections are correlated above 0.95.", "note"});
  }
  return section;
}

PageSection ModelSection(const ResultFolder& result) {
  PageSection section{"model", "What was modelled and why", {}};
  const ReportSummary& summary = result.summary;
  if (result.candidates.empty()) {
    std::string groups;
    for (const auto& [key, value] : summary.configuration) {
      if (key.starts_with("correction.")) groups += key + " = " + value + "\n";
    }
    if (result.parameters.empty()) {
      section.items.emplace_back(
          PageText{"Range spheres and Doppler cones of the looks, no corrections.", ""});
    } else {
      section.items.emplace_back(PageText{
          "The corrections were given in the block's [adjust] table, not chosen by the program "
          "(corrections = \"auto\" would try them one by one and list its reasons here).",
          ""});
      if (!groups.empty()) section.items.emplace_back(PagePre{"Correction groups", groups});
    }
  } else {
    const auto kept = std::count_if(result.candidates.begin(),
                                    result.candidates.end(),
                                    [](const ReportCandidate& c) { return c.verdict == "kept"; });
    section.items.emplace_back(PageText{
        fmt::format(
            "Corrections were chosen by the program: {} of {} candidates were kept, each because "
            "it is determinable, significant and pays.{}",
            kept,
            result.candidates.size(),
            summary.selection_settled ? "" : " The choice had not settled when it was stopped."),
        ""});
    section.items.emplace_back(CandidateTable(result));
    if (!summary.selected_model.empty()) {
      section.items.emplace_back(PagePre{"The model chosen", summary.selected_model});
    }
  }
  if (!result.simplifications.empty()) {
    PageTable table;
    table.title = "What can be left out of the model";
    table.columns = {{"simplification", false},
                     {"moves a point by up to [m]", true},
                     {"its sigma [m]", true},
                     {"part", true},
                     {"verdict", false}};
    for (const ReportSimplification& s : result.simplifications) {
      table.rows.push_back(
          {s.name, Shown(s.bound_m, 3), Shown(s.sigma_m, 3), ShownPercent(s.fraction), s.verdict});
    }
    section.items.emplace_back(std::move(table));
  }
  if (result.pairs.count > 0) {
    const std::array<const char*, 3> axes = AxisNames(summary);
    section.items.emplace_back(
        PageText{fmt::format("Relative accuracy: differences of {} pairs of points have median "
                             "sigmas of {} m {}, {} m {} and {} m {}; the 1979 paper gives {} m "
                             "across and {} m in height by range noise.",
                             ReadableCount(static_cast<double>(result.pairs.count)),
                             Shown(result.pairs.median_sigma_m[0], 3),
                             axes[0],
                             Shown(result.pairs.median_sigma_m[1], 3),
                             axes[1],
                             Shown(result.pairs.median_sigma_m[2], 3),
                             axes[2],
                             Shown(result.pairs.median_leberl_across_m, 3),
                             Shown(result.pairs.median_leberl_up_m, 3)),
                 ""});
  }
  return section;
}

}  // namespace sarblock
