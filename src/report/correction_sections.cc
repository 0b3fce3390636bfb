// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numeric>

#include "page.h"
#include "result_page.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::size_t kMaxCharts = 18;
constexpr std::size_t kMaxParameterRows = 300;
constexpr const char* kTrackAxes[] = {"along", "across", "up"};
constexpr const char* kTrackColors[] = {"blue", "orange", "green"};

using Strip = std::span<const StripStation>;

bool Corrected(const Strip& strip) { return !std::isnan(strip.front().correction_m[0]); }

/// Largest correction over its standard deviation, along the strip.
double Significance(const Strip& strip) {
  double largest = 0.0;
  for (const StripStation& station : strip) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double ratio = std::abs(station.correction_m[k]) / station.correction_sigma_m[k];
      if (std::isfinite(ratio)) largest = std::max(largest, ratio);
    }
  }
  return largest;
}

PageFigure StripFigure(const std::string& pass, const Strip& strip, std::size_t number) {
  XyChart chart;
  chart.x = {"strip from start to end", false, -1.0, 1.0};
  chart.y.label = "correction [m]";
  for (std::size_t k = 0; k < 3; ++k) {
    ChartSeries band{"", "band", kTrackColors[k], {}, {}, {}, {}, {}};
    ChartSeries line{kTrackAxes[k], "line", kTrackColors[k], {}, {}, {}, {}, {}};
    const auto axis = static_cast<Eigen::Index>(k);
    for (const StripStation& station : strip) {
      const double value_m = station.correction_m[axis];
      const double sigma_m = station.correction_sigma_m[axis];
      line.x.push_back(station.strip_time);
      line.y.push_back(value_m);
      if (std::isnan(sigma_m)) continue;
      band.x.push_back(station.strip_time);
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
  return {id, "Pass " + pass, "", "small", ChartJson(id, chart)};
}

PageTable ParameterTable(const ResultFolder& result) {
  std::vector<std::size_t> order(result.file.parameters.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const double sa = result.file.parameters[a].significance();
    const double sb = result.file.parameters[b].significance();
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
  const std::size_t rows = std::min(order.size(), kMaxParameterRows);
  for (std::size_t i = 0; i < rows; ++i) {
    const ParameterResult& p = result.file.parameters[order[i]];
    const double significance = p.significance();
    table.rows.push_back({p.owner,
                          p.name,
                          Shown(p.value),
                          Shown(p.sigma, 3),
                          p.unit,
                          Shown(p.prior_sigma, 3),
                          std::isnan(significance) ? "-" : Shown(significance, 3) + " sigma"});
  }
  const auto weak = std::count_if(result.file.parameters.begin(),
                                  result.file.parameters.end(),
                                  [](const ParameterResult& p) { return p.significance() < 2.0; });
  const auto unlearned = std::count_if(
      result.file.parameters.begin(), result.file.parameters.end(), [](const ParameterResult& p) {
        return p.sigma > 0.9 * p.prior_sigma;
      });
  table.note = fmt::format(
      "{} of {} parameters. {} are below 2 sigma: the data do not ask for them. {} keep more than "
      "nine tenths of their prior sigma: the observations say little about them.",
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
    return result.file.parameters[i].owner + " " + result.file.parameters[i].name;
  };
  for (const ReportCorrelation& c : result.correlations) {
    table.rows.push_back({name(c.a), name(c.b), fmt::format("{:+.4f}", c.correlation)});
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
  for (const CandidateResult& c : result.file.candidates) {
    if (c.kept) table.marked.push_back(table.rows.size());
    table.rows.push_back({c.name,
                          c.passes,
                          ReadableCount(static_cast<double>(c.parameters)),
                          Shown(c.f, 3),
                          Shown(c.probability, 2),
                          Shown(c.delta_bic, 3),
                          Shown(c.condition, 2),
                          c.verdict(),
                          c.reason});
  }
  return table;
}

/// Medians of the standard deviations of differences.
PageText PairText(const files::ResultFile& file) {
  const auto median = [&](const auto& value_m) {
    std::vector<double> values_m;
    for (const PairResult& pair : file.pairs) values_m.push_back(value_m(pair));
    return Shown(SampleQuantile(std::move(values_m), 0.5), 3);
  };
  const auto sigma = [&](std::size_t axis) {
    return median([&](const PairResult& pair) { return std::sqrt(pair.covariance_m2[axis]); });
  };
  const std::array<const char*, 3> axes = AxisNames(file.frame);
  return {fmt::format("Relative accuracy: differences of {} pairs of points have median sigmas of "
                      "{} m {}, {} m {} and {} m {}; the 1979 paper gives {} m across and {} m in "
                      "height by range noise.",
                      ReadableCount(file.pairs.size()),
                      sigma(0),
                      axes[0],
                      sigma(1),
                      axes[1],
                      sigma(2),
                      axes[2],
                      median([](const PairResult& pair) { return pair.sigma_leberl_across_m; }),
                      median([](const PairResult& pair) { return pair.sigma_leberl_up_m; })),
          ""};
}

}  // namespace

PageSection CorrectionSection(const ResultFolder& result) {
  PageSection section{"corrections", "Corrections of the passes", {}};
  if (result.file.parameters.empty()) {
    section.items.emplace_back(
        PageText{"No corrections were estimated: the flight paths were taken as given.", "note"});
    return section;
  }
  std::vector<Strip> strips = StripsOf(result.file);
  std::erase_if(strips, [](const Strip& strip) { return !Corrected(strip); });
  const std::size_t all = strips.size();
  if (all > kMaxCharts) {
    std::stable_sort(strips.begin(), strips.end(), [](const Strip& a, const Strip& b) {
      return Significance(a) > Significance(b);
    });
    strips.resize(kMaxCharts);
  }
  const bool predicted = result.file.summary.status == "predicted";
  if (!strips.empty() && !predicted) {
    PageFigures figures;
    for (std::size_t i = 0; i < strips.size(); ++i) {
      const std::string& pass = result.file.passes[strips[i].front().pass].id;
      figures.figures.push_back(StripFigure(pass, strips[i], i));
    }
    section.items.emplace_back(std::move(figures));
    std::string note =
        "Position correction along, across and up over each strip, with its band of two sigma. "
        "Each chart has its own scale.";
    if (all > kMaxCharts) {
      note += fmt::format(" The {} most significant of {} passes.", kMaxCharts, all);
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
  const files::ResultSummary& summary = result.file.summary;
  if (result.file.candidates.empty()) {
    std::string groups;
    for (const auto& [key, value] : summary.configuration) {
      if (key.starts_with("correction.")) groups += key + " = " + value + "\n";
    }
    if (result.file.parameters.empty()) {
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
    const auto count = [&](bool CandidateResult::*is) {
      return std::count_if(result.file.candidates.begin(),
                           result.file.candidates.end(),
                           [is](const CandidateResult& c) { return c.*is; });
    };
    section.items.emplace_back(PageText{
        fmt::format(
            "Corrections were chosen by the program: {} of {} candidates were kept, each because "
            "it is determinable, significant and pays; {} are held by priors, their own or "
            "estimated ones, so that what they may be is part of all standard deviations.{}",
            count(&CandidateResult::kept),
            result.file.candidates.size(),
            count(&CandidateResult::held),
            summary.selection_settled ? "" : " The choice had not settled when it was stopped."),
        ""});
    section.items.emplace_back(CandidateTable(result));
    if (!summary.selected_model.empty()) {
      section.items.emplace_back(PagePre{"The model chosen", summary.selected_model});
    }
  }
  if (!result.file.simplifications.empty()) {
    PageTable table;
    table.title = "What can be left out of the model";
    table.columns = {{"simplification", false},
                     {"moves a point by up to [m]", true},
                     {"its sigma [m]", true},
                     {"part", true},
                     {"verdict", false}};
    for (const SimplificationBound& s : result.file.simplifications) {
      table.rows.push_back(
          {s.name, Shown(s.bound_m, 3), Shown(s.sigma_m, 3), ShownPercent(s.fraction), s.verdict});
    }
    section.items.emplace_back(std::move(table));
  }
  if (!result.file.pairs.empty()) section.items.emplace_back(PairText(result.file));
  return section;
}

}  // namespace sarblock
