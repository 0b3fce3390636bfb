// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "charts.h"
#include "html.h"
#include "result_folder.h"
#include "shown.h"
#include "study_page.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

/// What a stage decides, in words.
std::string StageInWords(const std::string& stage) {
  if (stage == "model") return "Model of the block";
  if (stage == "solver") return "Solver";
  if (stage == "covariance") return "Covariance";
  if (stage == "precision") return "Arithmetic";
  return Capital(stage);
}

/// The error that a stage trades for speed: of covariances where the stage changes them.
std::string ErrorColumn(const StudyCsv& table, const std::vector<std::size_t>& rows) {
  for (const std::size_t r : rows) {
    if (table.Number(r, "covariance_error") > 0.0) return "covariance_error";
  }
  return "position_error_sigma";
}

/// One stage at one size of the block; every choice is named beside its point.
PageFigure TradeoffFigure(const StudyCsv& table,
                          const std::string& stage,
                          const std::string& points,
                          const std::vector<std::size_t>& rows,
                          std::size_t number) {
  const std::string column = ErrorColumn(table, rows);
  // The reference has no error: it stands a decade below the smallest.
  double least = kAbsent;
  for (const std::size_t r : rows) {
    const double error = table.Number(r, column);
    if (error > 0.0) least = std::fmin(least, error);
  }
  const double floor = std::isnan(least) ? 1e-16 : least / 10.0;
  XyChart chart;
  chart.x = {"wall time [s]", true, kAbsent, kAbsent};
  chart.y = {
      column == "covariance_error" ? "relative error of covariances" : "shift of points [sigma]",
      true,
      kAbsent,
      kAbsent};
  ChartSeries front{"nothing is faster and better", "points", "blue", {}, {}, {}, {}, {}};
  ChartSeries other{"others", "points", "grey", {}, {}, {}, {}, {}};
  front.written = other.written = true;
  for (const std::size_t r : rows) {
    if (std::isnan(table.Number(r, "wall_s"))) continue;  // was not run
    ChartSeries& series = table.Text(r, "pareto") == "1" ? front : other;
    const double error = table.Number(r, column);
    series.x.push_back(table.Number(r, "wall_s"));
    series.y.push_back(error > 0.0 ? error : floor);
    series.names.push_back(table.Text(r, "choice"));
  }
  for (ChartSeries* series : {&other, &front}) {
    if (!series->x.empty()) chart.series.push_back(std::move(*series));
  }
  FitY(&chart);
  const std::string id = fmt::format("tradeoff-{}", number);
  return {id,
          StageInWords(stage) +
              (points.empty() ? "" : ", " + ReadableCount(std::atof(points.c_str())) + " points"),
          std::isnan(least) ? "No choice of this stage has an error."
                            : "Choices without an error stand at the lower edge.",
          "half",
          ChartJson(id, chart)};
}

/// The ends of the bargain: what is fastest, and what it costs at most.
std::vector<PageFact> FactsOfChoices(const StudyCsv& table) {
  std::vector<PageFact> facts;
  const auto largest = [&table](const char* column) {
    std::size_t most = table.rows.size();
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      const double value = table.Number(r, column);
      if (value > (most == table.rows.size() ? 0.0 : table.Number(most, column))) most = r;
    }
    return most;
  };
  const auto named = [&table](std::size_t r) {
    return table.Text(r, "choice") + ", " + ReadableCount(table.Number(r, "points")) + " points";
  };
  const std::size_t fastest = largest("speed_ratio"), weakest = largest("position_error_sigma");
  if (fastest < table.rows.size()) {
    facts.push_back({"Fastest",
                     Shown(table.Number(fastest, "speed_ratio"), 3) + " times the reference",
                     named(fastest)});
  }
  if (weakest < table.rows.size()) {
    facts.push_back({"Largest shift of a point",
                     Shown(table.Number(weakest, "position_error_sigma"), 2) + " sigma",
                     named(weakest)});
  }
  return facts;
}

}  // namespace

StudyPart TradeoffPart(const StudyCsv& table) {
  StudyPart out;
  out.section = {"tradeoff", "Speed against accuracy", {}};
  out.word = "Speed against accuracy";
  out.facts = FactsOfChoices(table);
  std::size_t run = 0;
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    if (!std::isnan(table.Number(r, "wall_s"))) ++run;
  }
  out.sentences.push_back(fmt::format("{} choices in {} stages were run against their references.",
                                      run,
                                      table.Values("stage").size()));
  PageFigures figures;
  for (const std::string& stage : table.Values("stage")) {
    const std::vector<std::size_t> of_stage = RowsOf(table, "stage", stage, "wall_s");
    std::size_t fastest = table.rows.size();
    for (const std::size_t r : of_stage) {
      if (table.Text(r, "pareto") == "1" &&
          (fastest == table.rows.size() ||
           table.Number(r, "speed_ratio") > table.Number(fastest, "speed_ratio"))) {
        fastest = r;
      }
    }
    if (fastest < table.rows.size()) {
      out.sentences.push_back(
          fmt::format("{}: {} is {} times as fast as the reference, with points moved by {} sigma "
                      "and covariances by {}.",
                      Capital(stage),
                      table.Text(fastest, "choice"),
                      Shown(table.Number(fastest, "speed_ratio"), 3),
                      Shown(table.Number(fastest, "position_error_sigma"), 2),
                      Shown(table.Number(fastest, "covariance_error"), 2)));
    }
    for (const std::string& points : table.Values("points")) {
      std::vector<std::size_t> rows;
      for (const std::size_t r : of_stage) {
        if (table.Text(r, "points") == points && !std::isnan(table.Number(r, "wall_s"))) {
          rows.push_back(r);
        }
      }
      if (rows.empty()) continue;
      figures.figures.push_back(TradeoffFigure(table, stage, points, rows, figures.figures.size()));
    }
  }
  out.section.items.emplace_back(std::move(figures));
  PageTable whole = WholeTable(table, {"stage", "choice"});
  for (std::size_t r = 0; r < whole.rows.size(); ++r) {
    if (table.Text(r, "pareto") == "1") whole.marked.push_back(r);
  }
  whole.note += whole.note.empty() ? "" : " ";
  whole.note += "Marked: nothing is both faster and more accurate.";
  out.section.items.emplace_back(std::move(whole));
  return out;
}

}  // namespace sarblock
