// SPDX-License-Identifier: Apache-2.0
#include "studies/study.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/threads.h"
#include "manual.h"
#include "program.h"
#include "report/svg_plot.h"
#include "session.h"
#include "studies/densification.h"
#include "studies/design.h"
#include "studies/design_law.h"
#include "studies/stability.h"
#include "studies/tradeoff.h"
#include <fmt/core.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

/// Name and content.
using StudyFile = std::pair<std::string, std::string>;

/// What a study says beside its table.
struct StudyAnswer {
  std::vector<std::string> words;   ///< lines for people, also written to NAME.txt
  std::vector<std::string> tables;  ///< lines printed above them: tables for a terminal
  /// Further files of the folder, name and content: plots, more tables.
  std::vector<StudyFile> files;
  /// The table with the columns that need all rows, where the kind has such: written in place of
  /// the one that grew.
  std::optional<StudyTable> table;
};

/// A study read from its file, ready to run.
struct PreparedStudy {
  StudyPlan plan;
  /// Everything that the rows are a function of, as text: EffectiveStudyText and the texts of the
  /// scenes it names. A folder with rows of another identity is not resumed.
  std::string identity;
  std::function<StudyAnswer(const StudyTable& table)> conclude;
};

/// One kind of study: `sarblock study NAME STUDY.toml -o DIR` writes DIR/NAME.csv. Everything but
/// these two functions is common: the options, the threads, resuming, the files.
struct StudyKind {
  const char* name;
  const char* help;
  /// `threads` are those of the session, for tasks that run one by one.
  PreparedStudy (*prepare)(const std::string& file,
                           const std::vector<std::string>& overrides,
                           int threads);
  /// Dotted keys of the study file that `--set` may name.
  std::vector<std::string> (*keys)();
  bool divisible;  ///< whether parts of it may be computed apart
};

// ---- speed against accuracy

constexpr std::array kStages{
    TradeoffStage::kModel, TradeoffStage::kSolver, TradeoffStage::kCovariance};

/// Choices of a stage in the order of the rows.
std::vector<std::string> ChoicesOf(const std::vector<TradeoffRow>& rows, TradeoffStage stage) {
  std::vector<std::string> names;
  for (const TradeoffRow& row : rows) {
    if (row.stage != stage) continue;
    if (std::find(names.begin(), names.end(), row.choice) == names.end()) {
      names.push_back(row.choice);
    }
  }
  return names;
}

/// The error that a stage trades: of the covariance in that stage, of positions in all others. At
/// least the floor of the plot: the limit of equality, or the last digit where digits are compared.
double ErrorOf(const TradeoffRow& row) {
  const double error = row.stage == TradeoffStage::kCovariance ? row.errors.covariance_error
                                                               : row.errors.position_error;
  return std::max(error, row.stage == TradeoffStage::kSolver ? 1e-16 : kSamePosition);
}

/// A line a choice through its sizes.
template <typename PointOf>
Plot Draw(Plot plot,
          const std::vector<TradeoffRow>& rows,
          TradeoffStage stage,
          const PointOf& point_of) {
  plot.x.scale = plot.y.scale = PlotScale::kLog;
  for (const std::string& choice : ChoicesOf(rows, stage)) {
    PlotSeries series;
    series.name = choice;
    SetStyle(plot.series.size(), &series);
    for (const TradeoffRow& row : rows) {
      if (row.stage != stage || row.choice != choice) continue;
      const std::array<double, 2> point = point_of(row);
      if (std::isfinite(point[0]) && std::isfinite(point[1])) series.points.push_back(point);
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

Plot PlotError(const std::vector<TradeoffRow>& rows, TradeoffStage stage) {
  Plot plot;
  plot.title = fmt::format("{}: error against speed", NameOf(stage));
  plot.x.label = fmt::format("speed by {} time, reference = 1",
                             rows.front().clock == TradeoffClock::kWall ? "wall" : "CPU");
  plot.y.label = stage == TradeoffStage::kCovariance ? "largest relative error of a 3 x 3"
                                                     : "largest shift [sigma]";
  plot.notes = {"a line: one choice,", "from small to large"};
  return Draw(std::move(plot), rows, stage, [](const TradeoffRow& row) {
    return std::array{row.speed_ratio, ErrorOf(row)};
  });
}

Plot PlotTime(const std::vector<TradeoffRow>& rows, TradeoffStage stage) {
  const bool wall = rows.front().clock == TradeoffClock::kWall;
  Plot plot;
  plot.title = fmt::format("{}: time", NameOf(stage));
  plot.x.label = "points";
  plot.y.label = wall ? "wall time [s]" : "CPU time [s]";
  return Draw(std::move(plot), rows, stage, [wall](const TradeoffRow& row) {
    return std::array{static_cast<double>(row.points), wall ? row.wall_s : row.cpu_s};
  });
}

StudyAnswer ConcludeTradeoff(const TradeoffStudy& study, const StudyTable& table) {
  std::vector<TradeoffRow> rows = TradeoffRowsOf(table);
  MarkPareto(&rows);
  StudyAnswer answer;
  for (const std::size_t points : SizesOf(rows)) {
    answer.words.push_back(Recommend(rows, points, study.goal));
  }
  answer.table = TradeoffTable(rows);
  answer.files.emplace_back("tradeoff.md", TradeoffPage(rows, study.goal));
  std::vector<PlotPanel> errors, times;
  for (const TradeoffStage stage : kStages) {
    if (ChoicesOf(rows, stage).empty()) continue;
    errors.emplace_back(PlotError(rows, stage));
    times.emplace_back(PlotTime(rows, stage));
  }
  answer.files.emplace_back("tradeoff_error.svg", SvgOf(errors, 1));
  answer.files.emplace_back("tradeoff_time.svg", SvgOf(times, 1));
  return answer;
}

PreparedStudy PrepareTradeoff(const std::string& file,
                              const std::vector<std::string>& overrides,
                              int threads) {
  const auto study = std::make_shared<TradeoffStudy>(ReadTradeoffStudy(file, overrides));
  return {PlanTradeoff(*study, threads), study->identity, [study](const StudyTable& table) {
            return ConcludeTradeoff(*study, table);
          }};
}

// ---- control and design

/// Distinct texts of a column in the order they appear.
std::vector<std::string> Distinct(const StudyTable& table, std::string_view column) {
  std::vector<std::string> found;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const std::string text = table.Text(row, column);
    if (std::find(found.begin(), found.end(), text) == found.end()) found.push_back(text);
  }
  return found;
}

std::string TitleOf(const std::string& what, const std::string& variant) {
  return variant.empty() ? what : what + ": " + variant;
}

Plot AgainstControl(std::string title, std::string quantity) {
  Plot plot;
  plot.title = std::move(title);
  plot.x = {.label = "control points", .scale = PlotScale::kRoot, .range = {}};
  plot.y = {.label = std::move(quantity), .scale = PlotScale::kLog, .range = {}};
  return plot;
}

/// Values that stay within a factor of three are seen better on a linear axis.
void ChooseScale(Plot* plot) {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const PlotSeries& series : plot->series) {
    for (const auto& point : series.points) {
      if (!std::isfinite(point[0]) || !std::isfinite(point[1])) continue;
      least = std::min(least, point[1]);
      most = std::max(most, point[1]);
    }
  }
  if (most < 3.0 * least) plot->y.scale = PlotScale::kLinear;
}

/// Worst sigma of a variant against the number of control points, one line per layout.
Plot PlotWorst(const StudyTable& table, const std::string& variant, const std::string& direction) {
  Plot plot = AgainstControl(TitleOf("Worst point", variant), "sigma_" + direction + " [m]");
  const std::string column = "max_sigma_" + direction + "_m";
  for (const std::string& layout : Distinct(table, "layout")) {
    PlotSeries series;
    bool own = false;  // a row beside that without control
    const bool exchanged = layout.starts_with("exchange ");
    const bool placed = exchanged || layout.starts_with("greedy ");  // has its own start
    for (std::size_t row = 0; row < table.size(); ++row) {
      const std::string of = table.Text(row, "layout");
      // Without control every layout begins in the same place.
      if ((of != layout && (of != "none" || placed)) || table.Text(row, "variant") != variant) {
        continue;
      }
      own = own || of == layout;
      const double count = table.Number(row, "control_points");
      if (!series.points.empty() && count < series.points.back()[0]) {  // another placement
        series.points.push_back({kNaN, kNaN});
      }
      series.points.push_back({count, table.Number(row, column)});
    }
    if (layout == "none" || !own) continue;
    series.name = layout;
    SetStyle(plot.series.size(), &series);
    if (exchanged) series.mark = PlotMark::kMarkers;
    plot.series.push_back(std::move(series));
  }
  ChooseScale(&plot);
  return plot;
}

/// Median of positions and of differences of neighbours, the best layout of each number of points.
Plot PlotRelative(const StudyTable& table, const std::vector<std::string>& variants) {
  Plot plot =
      AgainstControl("Positions and differences of neighbours, up, best layout", "sigma [m]");
  for (std::size_t v = 0; v < variants.size() && v < PlotSeries::kColours; ++v) {
    std::map<double, std::array<double, 2>> best;  // by number of control points
    for (std::size_t row = 0; row < table.size(); ++row) {
      if (table.Text(row, "variant") != variants[v] || table.Number(row, "determined") != 1.0) {
        continue;
      }
      const std::array<double, 2> sigmas_m = {table.Number(row, "median_sigma_u_m"),
                                              table.Number(row, "median_difference_sigma_u_m")};
      const auto [at, added] = best.emplace(table.Number(row, "control_points"), sigmas_m);
      if (!added && sigmas_m[0] < at->second[0]) at->second = sigmas_m;
    }
    PlotSeries position, difference;
    for (const auto& [count, sigmas_m] : best) {
      position.points.push_back({count, sigmas_m[0]});
      difference.points.push_back({count, sigmas_m[1]});
    }
    position.name = variants[v].empty() ? "median sigma_u" : variants[v];
    position.colour = difference.colour = v;
    difference.dash = PlotDash::kDashed;
    plot.series.push_back(std::move(position));
    plot.series.push_back(std::move(difference));
  }
  plot.notes = {"solid: positions", "dashed: differences"};
  return plot;
}

/// Normalised errors squared of the verified rows with their simultaneous bounds.
std::optional<Plot> PlotVerified(const StudyTable& table, const std::string& name) {
  Plot plot;
  plot.title = "Monte Carlo against prediction";
  plot.x.label = "row of " + name + ".csv";
  plot.y.label = "mean of e' Q^-1 e / 3";
  PlotSeries found, bound;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const double nees = table.Number(row, "nees");
    if (std::isnan(nees)) continue;
    const auto x = static_cast<double>(row + 1);
    found.points.push_back({x, nees});
    bound.points.push_back({x, 1.0});
    bound.bars.push_back({table.Number(row, "nees_lower"), table.Number(row, "nees_upper")});
  }
  if (found.points.empty()) return std::nullopt;
  found.name = "found";
  found.mark = PlotMark::kMarkers;
  bound.name = "expected, with bound";
  bound.mark = PlotMark::kLine;
  bound.colour = 4;
  plot.series = {bound, found};
  return plot;
}

/// Median (dashed) and worst (solid) sigmas against the swept value, or against its place in the
/// list where the values are not numbers.
Plot PlotSweep(const DesignStudy& study, const StudyTable& table) {
  Plot plot;
  plot.title = "Accuracy against " + study.axes.front().name;
  plot.x.label = study.axes.front().name;
  plot.y = {.label = "sigma [m]", .scale = PlotScale::kLog, .range = {}};
  bool numbers = true;
  for (std::size_t row = 0; row < table.size(); ++row) {
    numbers = numbers && std::isfinite(table.Number(row, "number_1"));
  }
  if (!numbers) {
    plot.x.label += ", as listed";
    for (std::size_t row = 0; row < table.size(); ++row) {
      plot.notes.push_back(fmt::format("{}: {}", row + 1, study.axes.front().values[row]));
    }
  }
  for (std::size_t axis = 0; axis < kDesignDirections.size(); ++axis) {
    for (const bool worst : {true, false}) {
      PlotSeries series;
      series.name = std::string(kDesignDirections[axis]) + (worst ? ", worst point" : ", median");
      series.colour = axis;
      series.dash = worst ? PlotDash::kSolid : PlotDash::kDashed;
      series.open = !worst;
      const std::string column =
          fmt::format("{}_sigma_{}_m", worst ? "max" : "median", kDesignDirections[axis]);
      for (std::size_t row = 0; row < table.size(); ++row) {
        const double x = numbers ? table.Number(row, "number_1") : static_cast<double>(row + 1);
        series.points.push_back({x, table.Number(row, column)});
      }
      plot.series.push_back(std::move(series));
    }
  }
  ChooseScale(&plot);
  return plot;
}

HeatMap PlotDesignMatrix(const DesignStudy& study,
                         const StudyTable& table,
                         const std::string& column,
                         const std::string& title) {
  HeatMap map;
  map.title = title;
  map.rows_label = study.axes[0].name;
  map.columns_label = study.axes[1].name;
  map.rows = study.axes[0].values;
  map.columns = study.axes[1].values;
  for (std::size_t row = 0; row < table.size(); ++row) {
    map.values.push_back(table.Number(row, column));
    if (!study.goals.empty()) map.framed.push_back(table.Number(row, "reached") == 1.0);
  }
  if (!study.goals.empty()) map.notes = {"framed: reaches all goals"};
  return map;
}

/// Accuracy against cost; what nothing beats in both is joined by a line.
Plot PlotCost(const DesignStudy& study, const StudyTable& table) {
  const std::string quantity = DesignQuantity(study);
  Plot plot;
  plot.title = "Accuracy against cost";
  plot.x.label = "cost" + (study.prices.currency.empty() ? "" : " [" + study.prices.currency + "]");
  plot.y = {.label = quantity.starts_with("max") ? "worst point [m]" : "median [m]",
            .scale = PlotScale::kLog,
            .range = {}};
  PlotSeries best, others;
  best.name = "nothing is cheaper and better";
  others.name = "others";
  others.mark = PlotMark::kMarkers;
  others.colour = PlotSeries::kBlack;
  others.open = true;
  for (std::size_t row = 0; row < table.size(); ++row) {
    PlotSeries& series = table.Number(row, "pareto") == 1.0 ? best : others;
    series.points.push_back({table.Number(row, "cost"), table.Number(row, quantity)});
  }
  std::sort(best.points.begin(), best.points.end());
  plot.series = {others, best};
  ChooseScale(&plot);
  return plot;
}

/// Sigma of a direction against what is swept, both logarithmic: values as markers, laws as lines.
Plot PlotLaws(const DesignStudy& study, const std::vector<FittedLaw>& laws, std::size_t axis) {
  const std::string& swept = study.axes[study.law->axis].name;
  Plot plot;
  plot.title = fmt::format("Growth {} with {}, worst point", kDesignDirections[axis], swept);
  plot.x = {.label = swept, .scale = PlotScale::kLog, .range = {}};
  plot.y = {
      .label = study.law->part == DesignLaw::Part::kPaths ? "what the paths add [m]" : "sigma [m]",
      .scale = PlotScale::kLog,
      .range = {}};
  for (const FittedLaw& fitted : laws) {
    if (fitted.axis != axis || !fitted.column.starts_with("max_")) continue;
    PlotSeries values, line;
    const std::string derived =
        std::isnan(fitted.derived) ? "" : fmt::format(", derived {:.2f}", fitted.derived);
    values.name = fmt::format("{}{}p {:.2f}{}",
                              fitted.value,
                              fitted.value.empty() ? "" : ": ",
                              fitted.law.exponent,
                              derived);
    SetStyle(fitted.place, &values);
    line.colour = values.colour;
    line.dash = values.dash;
    values.mark = PlotMark::kMarkers;
    line.mark = PlotMark::kLine;
    values.points = fitted.values;
    for (const auto& [x, y] : fitted.values) {
      line.points.push_back({x, fitted.law.factor * std::pow(x, fitted.law.exponent)});
    }
    plot.series.push_back(std::move(line));
    plot.series.push_back(std::move(values));
  }
  plot.notes = {"lines: sigma = c x^p, least squares", "in logarithms"};
  return plot;
}

/// densification_worst.svg: the worst sigma_u and sigma_h of each variant against the number of
/// control points, a line a layout. densification_relative.svg: positions beside differences of
/// neighbours, and the verified rows with their bounds.
std::vector<StudyFile> PlotsOf(const DensificationStudy& /*study*/, const StudyTable& table) {
  const std::vector<std::string> variants = Distinct(table, "variant");
  std::vector<PlotPanel> worst;
  for (const std::string& variant : variants) {
    for (const char* direction : {"u", "h"}) worst.push_back(PlotWorst(table, variant, direction));
  }
  std::vector<PlotPanel> relative = {PlotRelative(table, variants)};
  if (auto verified = PlotVerified(table, "densification")) {
    relative.emplace_back(*std::move(verified));
  }
  return {{"densification_worst.svg", SvgOf(worst, 1)},
          {"densification_relative.svg", SvgOf(relative, 1)}};
}

/// design_curve.svg of one axis, design_maps.svg of two: the accuracy, and where there are prices
/// against cost. design_law.svg (design_verified.svg without laws): laws of growth and the verified
/// rows. `table` as MarkPareto() leaves it.
std::vector<StudyFile> PlotsOf(const DesignStudy& study, const StudyTable& table) {
  const bool curve = study.axes.size() == 1;
  std::vector<PlotPanel> accuracy, laws;
  if (curve) {
    accuracy.emplace_back(PlotSweep(study, table));
  } else {
    for (const char* direction : kDesignDirections) {
      accuracy.emplace_back(PlotDesignMatrix(study,
                                             table,
                                             fmt::format("max_sigma_{}_m", direction),
                                             fmt::format("Worst point, sigma {} [m]", direction)));
    }
  }
  if (study.prices.Given()) accuracy.emplace_back(PlotCost(study, table));
  const std::vector<FittedLaw> fitted = FitLaws(study, table);
  for (std::size_t axis = 0; axis < kDesignDirections.size() && !fitted.empty(); ++axis) {
    laws.emplace_back(PlotLaws(study, fitted, axis));
  }
  if (auto verified = PlotVerified(table, "design")) laws.emplace_back(*std::move(verified));
  std::vector<StudyFile> files = {
      {curve ? "design_curve.svg" : "design_maps.svg", SvgOf(accuracy, 1)}};
  if (!laws.empty()) {
    files.emplace_back(fitted.empty() ? "design_verified.svg" : "design_law.svg", SvgOf(laws, 1));
  }
  return files;
}

StudyAnswer ConcludeDensification(const DensificationStudy& study, const StudyTable& table) {
  return {DescribeDensification(study, table), {}, PlotsOf(study, table), {}};
}

PreparedStudy PrepareDensification(const std::string& file,
                                   const std::vector<std::string>& overrides,
                                   int /*threads*/) {
  const auto read = std::make_shared<DensificationFile>(ReadDensification(file, overrides));
  return {PlanDensification(read->study), read->identity, [read](const StudyTable& table) {
            return ConcludeDensification(read->study, table);
          }};
}

StudyAnswer ConcludeDesign(const DesignStudy& study, const StudyTable& table) {
  StudyAnswer answer;
  answer.words = DescribeDesign(study, table);
  const StudyTable marked = MarkPareto(study, table);
  answer.tables = DesignTables(study, marked);
  answer.files = PlotsOf(study, marked);
  if (study.law) {
    const std::vector<FittedLaw> laws = FitLaws(study, marked);
    for (std::string& line : LawLines(study, laws)) answer.tables.push_back(std::move(line));
    for (std::string& line : DescribeLaws(study, laws)) answer.words.push_back(std::move(line));
    answer.files.emplace_back("design_law.csv", StudyTableText(LawTable(study, laws)));
  }
  if (study.prices.Given()) answer.table = marked;
  return answer;
}

PreparedStudy PrepareDesign(const std::string& file,
                            const std::vector<std::string>& overrides,
                            int /*threads*/) {
  const auto read = std::make_shared<DesignFile>(ReadDesign(file, overrides));
  return {PlanDesign(read->study), read->identity, [read](const StudyTable& table) {
            return ConcludeDesign(read->study, table);
          }};
}

// ---- stability

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

/// The decades that cover every condition of the table.
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
  plot.series.push_back(
      Line("wrong unless warned of", PlotDash::kDashed, {{1.0, kMaxError}, {largest, kMaxError}}));
  return SvgOf(plot);
}

PreparedStudy PrepareStability(const std::string& file,
                               const std::vector<std::string>& overrides,
                               int /*threads*/) {
  const auto study = std::make_shared<StabilityStudy>(ReadStability(file, overrides));
  return {PlanStability(*study),
          EffectiveStudyText(file, overrides),
          [study](const StudyTable& table) -> StudyAnswer {
            return {DescribeStability(*study, table),
                    {},
                    {{"stability_methods.svg", PlotMethods(table)},
                     {"stability_errors.svg", PlotErrors(table)}},
                    {}};
          }};
}

// ---- the command

/// Every kind of study; a new one is a line here and its Prepare function.
constexpr std::array kKinds = {
    StudyKind{"densification",
              "How much control, where, and what the next point is worth",
              PrepareDensification,
              DensificationKeys,
              true},
    StudyKind{"design",
              "One or two keys of a scene swept: accuracy, goals and cost of each block",
              PrepareDesign,
              DesignKeys,
              true},
    StudyKind{"tradeoff",
              "Speed against accuracy of everything a user can choose, one stage at a time",
              PrepareTradeoff,
              TradeoffKeys,
              false},  // timed, each row beside its reference
    StudyKind{"stability",
              "Extreme blocks, compared with the same adjustment in 50 digits",
              PrepareStability,
              StabilityKeys,
              true},
};

struct StudyArguments {
  std::string file;
  std::vector<std::string> parts;  ///< folders, of `join`
  std::string part;
  std::string out;
  bool restart = false;
  ForeignFiles foreign = ForeignFiles::kRefuse;
};

void WriteFile(const std::filesystem::path& path, const std::string& text) {
  AtomicFile file(path);
  file.Write(text);
  file.Commit();
}

StudyIdentity IdentityOf(const StudyKind& kind, const PreparedStudy& study, TaskPart part = {}) {
  return {kind.name, study.plan.columns, study.plan.tasks.size(), study.identity, part};
}

StudyStart StartIn(const StudyArguments& arguments) {
  const bool replaces = arguments.foreign == ForeignFiles::kReplace &&
                        !HoldsOurs(FolderContent::kStudy, arguments.out);  // nothing to go on from
  return arguments.restart || replaces ? StudyStart::kRestart : StudyStart::kResume;
}

/// Figures that every run of a study reports, and those of this kind of run.
nlohmann::json Summary(const StudyKind& kind,
                       const StudyTable& table,
                       std::size_t kept,
                       const StudyArguments& arguments,
                       const nlohmann::json& more) {
  nlohmann::json summary = {{"format", "sarblock-study-summary 1"},
                            {"study", kind.name},
                            {"folder", arguments.out},
                            {"rows", table.size()},
                            {"tasks_kept", kept}};
  summary.update(more);
  return summary;
}

void ShowSummary(const nlohmann::json& summary, const std::string& words, const Session& session) {
  if (session.json) {
    fmt::print("{}\n", summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else {
    session.Print(words);
  }
}

/// Words, plots and the table where it has columns that need all rows.
void Conclude(const StudyKind& kind,
              const PreparedStudy& study,
              const StudyTable& table,
              const StudyArguments& arguments,
              std::size_t kept,
              const Session& session) {
  const std::filesystem::path folder = arguments.out;
  StudyAnswer answer = study.conclude(table);
  std::vector<std::string> files = {fmt::format("{}.csv", kind.name)};
  answer.files.emplace_back(fmt::format("{}.txt", kind.name),
                            fmt::format("{}\n", fmt::join(answer.words, "\n")));
  if (answer.table) WriteFile(folder / files.front(), StudyTableText(*answer.table));
  for (const auto& [name, text] : answer.files) {
    WriteFile(folder / name, text);
    files.push_back(name);
  }
  ShowSummary(
      Summary(kind,
              table,
              kept,
              arguments,
              {{"tasks", study.plan.tasks.size()}, {"words", answer.words}, {"files", files}}),
      fmt::format("{}{}{}\n{} rows; {} written to {}\n",
                  fmt::join(answer.tables, "\n"),
                  answer.tables.empty() ? "" : "\n",
                  fmt::join(answer.words, "\n"),
                  table.size(),
                  fmt::join(files, ", "),
                  arguments.out),
      session);
}

int RunOneStudy(const StudyKind& kind, const StudyArguments& arguments, const Session& session) {
  if (session.dump_config) {
    fmt::print("{}", EffectiveStudyText(arguments.file, session.set));
    return kAccepted;
  }
  const TaskPart part = TaskPartOf(arguments.part).value_or(TaskPart{});
  RequireFolderFor(FolderContent::kStudy, arguments.out, arguments.foreign);
  const StudyStart start = StartIn(arguments);
  const ThreadLimit limit(session.Threads());
  const PreparedStudy study = Naming(
      arguments.file, [&] { return kind.prepare(arguments.file, session.set, session.Threads()); });
  StudyRows rows(arguments.out, IdentityOf(kind, study, part), start);
  if (rows.kept() > 0) {
    session.Warn(fmt::format("sarblock: {} of {} tasks of the study are there already",
                             rows.kept(),
                             study.plan.tasks.size()));
  }
  const StudyTable table = Naming(
      arguments.file, [&] { return RunStudy(study.plan, &rows, session.progress.get(), part); });
  if (part.IsWhole()) {
    Conclude(kind, study, table, arguments, rows.kept(), session);
  } else {
    ShowSummary(
        Summary(kind, table, rows.kept(), arguments, {{"part", arguments.part}}),
        fmt::format(
            "{}: {} rows written to {}; \"sarblock study join\" makes the study of all parts\n",
            NameOf(part),
            table.size(),
            arguments.out),
        session);
  }
  return kAccepted;
}

/// The kind of study of which a folder holds a part, and the study as it ran there.
std::pair<const StudyKind*, std::string> StudyIn(const std::filesystem::path& folder) {
  for (const StudyKind& kind : kKinds) {
    const std::filesystem::path file = folder / fmt::format("{}.study.toml", kind.name);
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored)) return {&kind, file.string()};
  }
  throw InputError(FilePlace{folder.string(), 0, ""}, "holds no part of a study");
}

int RunJoin(const StudyArguments& arguments, const Session& session) {
  RequireNoneOf(arguments.parts, arguments.out);
  const auto [kind, file] = StudyIn(arguments.parts.front());
  RequireFolderFor(FolderContent::kStudy, arguments.out, arguments.foreign);
  const StudyStart start = StartIn(arguments);
  const ThreadLimit limit(session.Threads());
  const PreparedStudy study = kind->prepare(file, {}, session.Threads());
  const StudyIdentity identity = IdentityOf(*kind, study);
  const std::vector<std::vector<StudyRow>> joined =
      JoinStudyParts({arguments.parts.begin(), arguments.parts.end()}, identity);
  StudyRows rows(arguments.out, identity, start);
  std::vector<StudyRow> all;
  for (std::size_t task = 0; task < joined.size(); ++task) {
    if (rows.Find(task) == nullptr) rows.Keep(task, joined[task]);
    all.insert(all.end(), joined[task].begin(), joined[task].end());
  }
  Conclude(*kind, study, {study.plan.columns, std::move(all)}, arguments, rows.kept(), session);
  return kAccepted;
}

}  // namespace

std::vector<std::string> StudyKeys(const std::string& command_path) {
  for (const StudyKind& kind : kKinds) {
    if (command_path == fmt::format("study {}", kind.name)) return kind.keys();
  }
  return {};
}

void AddStudy(CLI::App* app, Session* session) {
  CLI::App* study = app->add_subcommand("study", "Studies over many blocks, before a mission");
  study->require_subcommand(1);
  for (const StudyKind& kind : kKinds) {
    auto arguments = std::make_shared<StudyArguments>();
    CLI::App* command = study->add_subcommand(kind.name, kind.help);
    command->add_option("study", arguments->file, "Study file (TOML, docs/studies.md)")->required();
    command->add_option("-o,--output", arguments->out, "Folder to write to")->required();
    if (kind.divisible) {
      AddPart(command,
              &arguments->part,
              "Only the tasks I modulo N, for `study join`; I from 0 or from 1");
    }
    command->add_flag(
        "--restart", arguments->restart, "Compute all rows again, even those that the folder has");
    AddForce(command, &arguments->foreign);
    command->callback([=, &kind] {
      session->run = [=, &kind] { return RunOneStudy(kind, *arguments, *session); };
    });
  }
  auto arguments = std::make_shared<StudyArguments>();
  CLI::App* join = study->add_subcommand("join", "One study of the parts that --part computed");
  join->add_option("parts", arguments->parts, "Folders of all its parts")->required();
  join->add_option("-o,--output", arguments->out, "Folder to write to")->required();
  join->add_flag("--restart", arguments->restart, "Replace the study that the folder holds");
  AddForce(join, &arguments->foreign);
  join->callback([=] { session->run = [=] { return RunJoin(*arguments, *session); }; });
}

}  // namespace sarblock::cli
