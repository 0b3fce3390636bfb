// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>

#include "charts.h"
#include "result_folder.h"
#include "shown.h"
#include "study_page.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr const char* kLayoutColors[] = {"blue", "orange", "green", "purple"};
constexpr std::size_t kMostLayouts = 4;  // of a panel; drawn runs or single layouts are the fifth

bool Determined(const StudyCsv& table, std::size_t row) {
  return table.Text(row, "determined") != "0";
}

/// What a panel shows: a column, and where runs with drawn noise measured the same, theirs.
struct Measure {
  const char* id;
  const char* predicted;
  const char* measured;
  const char* title;
};
/// Heights by their root mean square, which the runs measure, or by their median.
std::vector<Measure> MeasuresOf(const StudyCsv& table) {
  std::vector<Measure> measures{{"max-u", "max_sigma_u_m", "", "Height, the worst point"},
                                {"max-h", "max_sigma_h_m", "", "Plan, the worst point"}};
  measures.insert(measures.begin(),
                  table.HasNumbers("rms_sigma_u_m")
                      ? Measure{"u", "rms_sigma_u_m", "montecarlo_rms_u_m", "Height, all points"}
                      : Measure{"u", "median_sigma_u_m", "", "Height, median of the points"});
  std::erase_if(measures, [&](const Measure& m) { return !table.HasNumbers(m.predicted); });
  return measures;
}

/// Rows of one variant by layout. A block without control starts the line of every layout.
struct LayoutRows {
  std::string layout;
  std::vector<std::size_t> rows;
};

std::vector<LayoutRows> LayoutsOf(const StudyCsv& table, const std::string& variant) {
  std::vector<LayoutRows> out;
  std::vector<std::size_t> without;
  for (const std::string& layout : table.Values("layout")) {
    LayoutRows one{layout, {}};
    for (const std::size_t r : RowsOf(table, "layout", layout, "control_points")) {
      if (Determined(table, r) && table.Text(r, "variant") == variant) one.rows.push_back(r);
    }
    if (layout == "none") without = one.rows;
    if (!one.rows.empty() && layout != "none") out.push_back(std::move(one));
  }
  for (LayoutRows& layout : out) {
    if (layout.rows.size() > 1 && table.Number(layout.rows.front(), "control_points") > 0.0) {
      layout.rows.insert(layout.rows.begin(), without.begin(), without.end());
    }
  }
  if (out.empty() && !without.empty()) out.push_back({"none", without});
  return out;
}

/// Panels of one measure of one variant, five series each at most.
void AddPanels(const StudyCsv& table,
               const std::vector<LayoutRows>& layouts,
               const Measure& measure,
               const std::string& id,
               PageFigures* figures) {
  std::vector<ChartSeries> lines, runs;
  ChartSeries single{"single layouts", "points", "ink", {}, {}, {}, {}, {}};
  single.written = true;
  for (const LayoutRows& layout : layouts) {
    const char* color = kLayoutColors[lines.size() % std::size(kLayoutColors)];
    ChartSeries line{layout.layout, "marks", color, {}, {}, {}, {}, {}};
    ChartSeries dots{"runs with drawn noise", "points", "ink", {}, {}, {}, {}, {}};
    for (const std::size_t r : layout.rows) {
      const double x = table.Number(r, "control_points");
      line.x.push_back(x);
      line.y.push_back(table.Number(r, measure.predicted));
      line.names.push_back(r == layout.rows.back() ? layout.layout : "");
      const double measured = table.Number(r, measure.measured);
      if (std::isnan(measured)) continue;
      dots.x.push_back(x);
      dots.y.push_back(measured);
      dots.names.push_back(layout.layout);
    }
    if (layout.rows.size() == 1) {
      single.x.push_back(line.x.front());
      single.y.push_back(line.y.front());
      single.names.push_back(layout.layout);
      continue;
    }
    line.written = true;
    lines.push_back(std::move(line));
    runs.push_back(std::move(dots));
  }
  for (std::size_t first = 0; first < lines.size() || !single.x.empty(); first += kMostLayouts) {
    XyChart chart;
    chart.x.label = "control points";
    chart.y = {"sigma [m]", true, kAbsent, kAbsent};
    ChartSeries dots{"runs with drawn noise", "points", "ink", {}, {}, {}, {}, {}};
    const std::size_t end = std::min(lines.size(), first + kMostLayouts);
    for (std::size_t i = first; i < end; ++i) {
      chart.series.push_back(lines[i]);
      dots.x.insert(dots.x.end(), runs[i].x.begin(), runs[i].x.end());
      dots.y.insert(dots.y.end(), runs[i].y.begin(), runs[i].y.end());
      dots.names.insert(dots.names.end(), runs[i].names.begin(), runs[i].names.end());
    }
    const bool dotted = !dots.x.empty();
    if (dotted) chart.series.push_back(std::move(dots));
    if (end == lines.size() && !single.x.empty() && chart.series.size() <= kMostLayouts) {
      chart.series.push_back(std::move(single));
      single.x.clear();
    }
    FitY(&chart);
    const std::string panel = first == 0 ? id : fmt::format("{}-{}", id, first / kMostLayouts + 1);
    figures->figures.push_back(
        {panel,
         std::string(measure.title) + (first == 0 ? "" : ", further layouts"),
         "",
         "half",
         ChartJson(panel, chart)});
  }
}

/// The least and the most control of the layout whose worst height is best: how weak the block is,
/// and what control does about it.
std::vector<PageFact> FactsOf(const StudyCsv& table) {
  constexpr const char* kWorst = "max_sigma_u_m";
  std::size_t best = table.rows.size();
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    if (!Determined(table, r) || std::isnan(table.Number(r, kWorst))) continue;
    if (best == table.rows.size() || table.Number(r, kWorst) < table.Number(best, kWorst)) best = r;
  }
  if (best == table.rows.size()) return {};
  const std::string layout = table.Text(best, "layout");
  const double least_m = table.Number(best, kWorst);
  std::vector<PageFact> facts{
      {"Worst height at best",
       Shown(least_m, 3) + " m",
       fmt::format("{}, {} control points", layout, table.Text(best, "control_points"))}};
  for (const std::size_t first : RowsOf(table, "layout", layout, "control_points")) {
    const double most_m = table.Number(first, kWorst);
    const bool same = table.Text(first, "variant") == table.Text(best, "variant");
    if (!same || !Determined(table, first) || !(most_m > least_m)) continue;
    const double gain_1 = 1.0 - least_m / most_m;
    constexpr double kHardly_1 = 0.1;
    facts.push_back({"More control",
                     gain_1 < kHardly_1 ? "hardly helps" : "helps",
                     fmt::format("from {} to {} points the worst height improves by {} %",
                                 table.Text(first, "control_points"),
                                 table.Text(best, "control_points"),
                                 Shown(100.0 * gain_1, 2))});
    break;
  }
  return facts;
}

}  // namespace

StudyPart DensificationPart(const StudyCsv& table) {
  StudyPart out;
  out.section = {"densification", "Control against accuracy", {}};
  out.word = "Control against accuracy";
  out.facts = FactsOf(table);
  std::size_t best = table.rows.size();
  double least = kAbsent, worst_nees = 0.0;
  std::size_t open = 0, tested = 0;
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    if (!Determined(table, r)) {
      ++open;
      continue;
    }
    const double sigma = table.Number(r, "median_sigma_u_m");
    if (sigma < least || std::isnan(least)) {
      least = sigma;
      best = r;
    }
    const double nees = table.Number(r, "nees");
    if (std::isnan(nees)) continue;
    ++tested;
    if (std::abs(nees - 1.0) > std::abs(worst_nees - 1.0) || worst_nees == 0.0) worst_nees = nees;
  }
  out.sentences.push_back(
      fmt::format("{} arrangements of control were compared.", table.rows.size()));
  if (best < table.rows.size()) {
    out.sentences.push_back(fmt::format(
        "The best height, a median sigma of {} m, has the layout {} with {} control points.",
        Shown(least, 3),
        table.Text(best, "layout"),
        table.Text(best, "control_points")));
  }
  if (tested > 0) {
    out.sentences.push_back(
        fmt::format("Where runs with drawn noise tested the prediction, the normalised error "
                    "squared was at worst {} (1 is expected).",
                    Shown(worst_nees, 3)));
  }
  if (open > 0) {
    out.attention.push_back(fmt::format("{} arrangements do not determine the block.", open));
  }
  std::size_t number = 0;
  for (const std::string& variant : table.Values("variant")) {
    const std::vector<LayoutRows> layouts = LayoutsOf(table, variant);
    ++number;
    if (layouts.empty()) continue;
    if (!variant.empty()) out.section.items.emplace_back(PageText{Capital(variant), "heading"});
    PageFigures figures;
    for (const Measure& measure : MeasuresOf(table)) {
      AddPanels(table,
                layouts,
                measure,
                number == 1 ? fmt::format("densification-{}", measure.id)
                            : fmt::format("densification-{}-variant-{}", measure.id, number),
                &figures);
    }
    out.section.items.emplace_back(std::move(figures));
  }
  out.section.items.emplace_back(
      PageText{"Lines: predicted by the covariance; of all points their root mean square. Black "
               "dots: root mean square errors of repeated adjustments with drawn noise.",
               "note"});
  out.section.items.emplace_back(WholeTable(table, {"layout", "variant"}));
  return out;
}

}  // namespace sarblock
