// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "report/svg_plot.h"
#include "studies/stability.h"
#include "studies/study.h"
#include "study_command.h"

namespace sarblock::cli {
namespace {

/// Digits of a column against the condition, a marker a row.
PlotSeries DigitsAgainstCondition(const StudyTable& table,
                                  const char* column,
                                  const char* name,
                                  std::size_t colour) {
  PlotSeries series;
  series.name = name;
  series.mark = PlotMark::kMarkers;
  series.colour = colour;
  for (std::size_t row = 0; row < table.size(); ++row) {
    series.points.push_back({table.Number(row, "condition"), table.Number(row, column)});
  }
  return series;
}

/// The decades that hold every condition of the table.
double LargestCondition(const StudyTable& table) {
  double largest = 10.0;
  for (std::size_t row = 0; row < table.size(); ++row) {
    // NaN leaves it as it is.
    largest = std::fmax(largest, table.Number(row, "condition"));
  }
  return std::pow(10.0, std::ceil(std::log10(largest)));
}

PlotAxis Condition(double largest) {
  return {.label = "condition k of the column-scaled Jacobian",
          .scale = PlotScale::kLog,
          .range = {{1.0, largest}}};
}

/// A line without markers in black.
PlotSeries Line(const char* name, PlotDash dash, std::vector<std::array<double, 2>> points) {
  PlotSeries series;
  series.name = name;
  series.mark = PlotMark::kLine;
  series.dash = dash;
  series.colour = PlotSeries::kBlack;
  series.points = std::move(points);
  return series;
}

/// Digits that a rounding of `digits` leaves where the condition counts with its `power`.
PlotSeries Law(const char* name, PlotDash dash, double digits, double power, double largest) {
  const double end = std::min(largest, std::pow(10.0, digits / power));
  return Line(name, dash, {{1.0, digits}, {end, digits - power * std::log10(end)}});
}

std::string PlotMethods(const StudyTable& table) {
  const double largest = LargestCondition(table);
  Plot plot;
  plot.title = "Digits of the covariance by method";
  plot.x = Condition(largest);
  plot.y = {.label = "correct digits of the worst 3 x 3 block", .range = {{0.0, 16.0}}};
  plot.series = {DigitsAgainstCondition(table, "covariance_digits", "production", 0),
                 DigitsAgainstCondition(table, "normal_digits", "all normals, double", 1),
                 DigitsAgainstCondition(table, "ceres_digits", "Ceres, sparse QR", 2),
                 DigitsAgainstCondition(table, "single_digits", "all normals, single", 3),
                 Law("16 - log k", PlotDash::kSolid, 16.0, 1.0, largest),
                 Law("16 - 2 log k", PlotDash::kDashed, 16.0, 2.0, largest),
                 Law("7.2 - 2 log k", PlotDash::kDotted, 7.2, 2.0, largest)};
  return SvgOf(plot);
}

std::string PlotErrors(const StudyTable& table) {
  const double largest = LargestCondition(table);
  Plot plot;
  plot.title = "Largest error of a position or correction";
  plot.x = Condition(largest);
  plot.y = {.label = "error [sigma]", .scale = PlotScale::kLog, .range = {}};
  constexpr std::array kOutcomes = {std::pair{StabilityOutcome::kOk, 0u},
                                    std::pair{StabilityOutcome::kWarned, 3u},
                                    std::pair{StabilityOutcome::kWrong, 4u}};
  for (const auto& [outcome, colour] : kOutcomes) {
    PlotSeries series;
    series.name = NameOf(outcome);
    series.mark = PlotMark::kMarkers;
    series.colour = colour;
    for (std::size_t row = 0; row < table.size(); ++row) {
      if (table.Text(row, "outcome") != series.name) continue;
      series.points.push_back({table.Number(row, "condition"), table.Number(row, "error_sigma")});
    }
    plot.series.push_back(std::move(series));
  }
  plot.series.push_back(Line(
      "wrong unless warned of", PlotDash::kDashed, {{1.0, kMostError_1}, {largest, kMostError_1}}));
  return SvgOf(plot);
}

}  // namespace

PreparedStudy PrepareStability(const std::string& file,
                               const std::vector<std::string>& overrides,
                               int /*threads*/) {
  const auto study = std::make_shared<StabilityStudy>(ReadStability(file, overrides));
  PreparedStudy prepared;
  prepared.plan = PlanStability(*study);
  prepared.identity = EffectiveStudyText(file, overrides);
  prepared.conclude = [study](const StudyTable& table, ProgressSink*) {
    StudyAnswer answer;
    answer.words = DescribeStability(*study, table);
    answer.files = {{"stability_methods.svg", PlotMethods(table)},
                    {"stability_errors.svg", PlotErrors(table)}};
    return answer;
  };
  return prepared;
}

}  // namespace sarblock::cli
