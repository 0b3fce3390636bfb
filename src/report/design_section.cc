// SPDX-License-Identifier: Apache-2.0
// The section of a design study: curves against what was swept, accuracy against cost, all rows.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "page.h"
#include "shown_result.h"
#include "study_page.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::array kSweptAxes = {"along", "across", "up"};
constexpr std::array kSweepColors = {"blue", "green", "orange"};

/// "overlap 0.6, control.count 8".
std::string CaseOf(const StudyCsv& table, std::size_t row) {
  std::string name = table.Text(row, "axis_1") + " " + table.Text(row, "value_1");
  const std::string second = table.Text(row, "axis_2");
  return second.empty() ? name : name + ", " + second + " " + table.Text(row, "value_2");
}

/// Median and worst sigmas of a study of one axis; values that are no numbers count from 1.
PageFigure SweepFigure(const StudyCsv& table) {
  bool numbers = true;
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    numbers = numbers && !std::isnan(table.Number(r, "number_1"));
  }
  XyChart chart;
  chart.x.label = table.Text(0, "axis_1") + (numbers ? "" : ", as listed");
  chart.y.label = "sigma [m]";
  for (std::size_t axis = 0; axis < kSweptAxes.size(); ++axis) {
    for (const bool worst : {true, false}) {
      ChartSeries line{fmt::format("{}, {}", kSweptAxes[axis], worst ? "worst point" : "median"),
                       worst ? "line" : "dash",
                       kSweepColors[axis],
                       {},
                       {},
                       {},
                       {},
                       {}};
      const std::string column =
          fmt::format("{}_sigma_{}_m", worst ? "max" : "median", kSweptAxes[axis]);
      for (std::size_t r = 0; r < table.rows.size(); ++r) {
        if (!table.Determined(r)) continue;
        line.x.push_back(numbers ? table.Number(r, "number_1") : static_cast<double>(r + 1));
        line.y.push_back(table.Number(r, column));
        line.names.push_back(table.Text(r, "value_1"));
      }
      chart.series.push_back(std::move(line));
    }
  }
  FitY(&chart);
  return {"design-sweep",
          "Accuracy against " + table.Text(0, "axis_1"),
          "Lines: the worst point. Dashed: the median of the points.",
          "wide",
          ChartJson("design-sweep", chart)};
}

/// The column that is traded for cost, and what it is: "worst point, sigma up [m]".
struct Traded {
  std::string column, words;
};
Traded TradedOf(const StudyCsv& table) {
  Traded out{table.Text(0, "traded"), ""};
  if (out.column.empty()) out.column = "max_sigma_up_m";
  const std::size_t begin = out.column.find("sigma_") + 6;
  out.words = fmt::format("{}, sigma {} [m]",
                          out.column.starts_with("max") ? "worst point" : "median",
                          out.column.substr(begin, out.column.size() - begin - 2));
  return out;
}

PageFigure CostFigure(const StudyCsv& table) {
  const Traded traded = TradedOf(table);
  XyChart chart;
  chart.x.label = "cost";
  chart.y.label = traded.words;
  ChartSeries front{"nothing is cheaper and better", "points", "blue", {}, {}, {}, {}, {}};
  ChartSeries other{"others", "points", "grey", {}, {}, {}, {}, {}};
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    if (!table.Determined(r)) continue;
    ChartSeries& series = table.Text(r, "pareto") == "1" ? front : other;
    series.x.push_back(table.Number(r, "cost"));
    series.y.push_back(table.Number(r, traded.column));
    series.names.push_back(CaseOf(table, r));
  }
  constexpr std::size_t kMaxWritten = 6;  // more names hide each other
  front.written = front.x.size() <= kMaxWritten;
  for (ChartSeries* series : {&other, &front}) {
    if (!series->x.empty()) chart.series.push_back(std::move(*series));
  }
  FitY(&chart);
  return {"design-cost",
          "Accuracy against cost",
          "Blue: nothing is cheaper and better.",
          "wide",
          ChartJson("design-cost", chart)};
}

constexpr std::size_t kMaxShownCases = 800;

/// What is traded, of every case: values of the first axis down, of the second one to the right.
PageTable MatrixOf(const StudyCsv& table) {
  const Traded traded = TradedOf(table);
  PageTable out;
  out.title = Capital(traded.words);
  const std::vector<std::string> down = table.Values("value_1"), right = table.Values("value_2");
  out.columns.push_back({table.Text(0, "axis_1"), false});
  for (const std::string& value : right) {
    out.columns.push_back({table.Text(0, "axis_2") + " " + value, true});
  }
  for (const std::string& value : down) {
    std::vector<std::string> row(right.size() + 1, "-");
    row[0] = value;
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      if (table.Text(r, "value_1") != value || !table.Determined(r)) continue;
      const auto at = std::find(right.begin(), right.end(), table.Text(r, "value_2"));
      row[static_cast<std::size_t>(at - right.begin()) + 1] =
          Shown(table.Number(r, traded.column), 3);
    }
    out.rows.push_back(std::move(row));
  }
  return out;
}

/// Every case with its numbers.
PageTable CasesOf(const StudyCsv& table) {
  PageTable out;
  out.title = "All designs";
  out.columns = {{"design", false}};
  for (const char* measure : {"median", "worst"}) {
    for (const char* axis : kSweptAxes) {
      out.columns.push_back({fmt::format("{} {} [m]", measure, axis), true});
    }
  }
  out.columns.push_back({"looks per point", true});
  const bool cost = table.HasNumbers("cost");
  if (cost) out.columns.push_back({"cost", true});
  for (std::size_t r = 0; r < std::min(kMaxShownCases, table.rows.size()); ++r) {
    const std::string message = table.Text(r, "message");
    std::vector<std::string> row = {CaseOf(table, r) + (message.empty() ? "" : ": " + message)};
    for (const char* measure : {"median", "max"}) {
      for (const char* axis : kSweptAxes) {
        row.push_back(Shown(table.Number(r, fmt::format("{}_sigma_{}_m", measure, axis)), 3));
      }
    }
    row.push_back(Shown(table.Number(r, "looks_per_point"), 3));
    if (cost) row.push_back(ReadableCount(table.Number(r, "cost")));
    out.rows.push_back(std::move(row));
  }
  if (table.rows.size() > kMaxShownCases) {
    out.note = fmt::format("The first {} of {} designs.", kMaxShownCases, table.rows.size());
  }
  return out;
}

/// The case with the least of a column.
std::size_t LeastOf(const StudyCsv& table, const std::string& column, bool reached) {
  std::size_t least = table.rows.size();
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    if (!table.Determined(r) || (reached && table.Text(r, "reached") != "1")) continue;
    if (std::isnan(table.Number(r, column))) continue;
    if (least == table.rows.size() || table.Number(r, column) < table.Number(least, column)) {
      least = r;
    }
  }
  return least;
}

}  // namespace

StudyPart DesignPart(const StudyCsv& table) {
  StudyPart out;
  out.section = {"design", "Design of the block", {}};
  out.word = "Designs compared";
  const std::size_t none = table.rows.size();
  const bool cost = table.HasNumbers("cost"), goals = table.HasNumbers("reached");
  std::size_t open = 0, reached = 0;
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    open += table.Determined(r) ? 0U : 1U;
    reached += table.Text(r, "reached") == "1" ? 1U : 0U;
  }
  out.sentences.push_back(fmt::format("{} designs were compared.", table.rows.size()));
  if (goals) {
    out.state = reached > 0 ? HeadlineState::kAccepted : HeadlineState::kNotAccepted;
    out.word = reached > 0 ? fmt::format("{} of {} designs reach the goals", reached, none)
                           : std::string("No design reaches the goals");
  }
  if (open > 0) {
    out.attention.push_back(fmt::format("{} designs give no block that is determined.", open));
  }
  if (const std::size_t best = LeastOf(table, "max_sigma_up_m", false); best != none) {
    out.facts.push_back({"Best height of the worst point",
                         Shown(table.Number(best, "max_sigma_up_m"), 3) + " m",
                         CaseOf(table, best)});
  }
  if (const std::size_t cheapest = cost ? LeastOf(table, "cost", goals) : none; cheapest != none) {
    out.facts.push_back({goals ? "Cheapest that reaches the goals" : "Cheapest",
                         ReadableCount(table.Number(cheapest, "cost")),
                         CaseOf(table, cheapest)});
  }
  const bool one_axis = !table.rows.empty() && table.Text(0, "axis_2").empty();
  PageFigures figures;
  if (one_axis) figures.figures.push_back(SweepFigure(table));
  if (cost) figures.figures.push_back(CostFigure(table));
  if (!figures.figures.empty()) out.section.items.emplace_back(std::move(figures));
  if (!table.rows.empty() && !one_axis) out.section.items.emplace_back(MatrixOf(table));
  PageTable whole = CasesOf(table);
  for (std::size_t r = 0; r < std::min(kMaxShownCases, table.rows.size()); ++r) {
    if (table.Text(r, goals ? "reached" : "pareto") == "1") whole.marked.push_back(r);
  }
  if (!whole.marked.empty()) {
    whole.note += whole.note.empty() ? "" : " ";
    whole.note += goals ? "Marked: reaches all goals." : "Marked: nothing is cheaper and better.";
  }
  out.section.items.emplace_back(std::move(whole));
  return out;
}

}  // namespace sarblock
