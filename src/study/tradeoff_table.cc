// SPDX-License-Identifier: Apache-2.0
#include "tradeoff_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <utility>

namespace sarblock {
namespace {

constexpr char kPareto[] = "pareto";

/// Calls visit(name, value) for every column in the order of the file. One list for both ways.
template <typename Row, typename Visit>
void VisitColumns(Row& row, const Visit& visit) {
  visit("stage", row.stage);
  visit("choice", row.choice);
  visit("points", row.points);
  visit("looks", row.looks);
  visit("wall_s", row.wall_s);
  visit("peak_mib", row.peak_mib);
  visit("speed_ratio", row.speed_ratio_1);
  visit("position_error_sigma", row.errors.position_error_1);
  visit("covariance_error", row.errors.covariance_error_1);
  visit(kPareto, row.pareto);
  visit("reference", row.reference);
  visit("accepted", row.accepted);
  visit("corrections", row.corrections);
  visit("iterations", row.iterations);
  visit("repeats", row.repeats);
  visit("threads", row.threads);
  visit("cpu_s", row.cpu_s);
  visit("clock", row.clock);
  visit("speed_low", row.speed_low_1);
  visit("speed_high", row.speed_high_1);
  visit("position_median_sigma", row.errors.position_median_1);
  visit("covariance_median", row.errors.covariance_median_1);
  visit("rms_error_m", row.errors.rms_error_m);
  visit("nees", row.errors.nees_1);
  visit("points_missing", row.errors.points_missing);
  visit("points_unjudged", row.errors.points_unjudged);
  visit("note", row.note);
}

template <typename Value>
constexpr bool kIsNamed =
    std::is_same_v<Value, TradeoffStage> || std::is_same_v<Value, TradeoffClock>;

StudyCell Cell(double value) {
  // Infinity is no number of a table: what is beyond all measure is not given.
  return std::isfinite(value) ? StudyCell(value) : StudyCell();
}
StudyCell Cell(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text.empty() ? StudyCell() : StudyCell(std::move(text));
}
StudyCell Cell(TradeoffStage stage) { return std::string(NameOf(stage)); }
StudyCell Cell(TradeoffClock clock) { return std::string(NameOf(clock)); }
template <typename Integer>
requires std::is_integral_v<Integer> StudyCell Cell(Integer value) {
  return static_cast<std::int64_t>(value);
}

/// True for a count that a row which was not run has no value of.
bool IsOfARun(std::string_view name, const TradeoffRow& row) {
  constexpr std::array<std::string_view, 5> kCounts{
      "looks", "corrections", "iterations", "points_missing", "points_unjudged"};
  return row.repeats == 0 && std::find(kCounts.begin(), kCounts.end(), name) != kCounts.end();
}

template <typename Named>
void Find(std::initializer_list<Named> all, const std::string& name, Named* out) {
  for (const Named one : all) {
    if (name == NameOf(one)) {
      *out = one;
      return;
    }
  }
  throw std::logic_error("'" + name + "' is no name of a tradeoff table");
}

void Read(const StudyTable& table, std::size_t row, std::string_view name, TradeoffStage* stage) {
  Find({TradeoffStage::kModel,
        TradeoffStage::kSolver,
        TradeoffStage::kCovariance,
        TradeoffStage::kPrecision},
       table.Text(row, name),
       stage);
}
void Read(const StudyTable& table, std::size_t row, std::string_view name, TradeoffClock* clock) {
  Find({TradeoffClock::kWall, TradeoffClock::kCpu}, table.Text(row, name), clock);
}
void Read(const StudyTable& table, std::size_t row, std::string_view name, std::string* text) {
  *text = table.Text(row, name);
}
void Read(const StudyTable& table, std::size_t row, std::string_view name, double* value) {
  *value = table.Number(row, name);
}
template <typename Integer>
void Read(const StudyTable& table, std::size_t row, std::string_view name, Integer* value) {
  const double number = table.Number(row, name);
  *value = std::isnan(number) ? Integer{} : static_cast<Integer>(number);
}

}  // namespace

std::vector<StudyColumn> TradeoffColumns() {
  std::vector<StudyColumn> columns;
  const TradeoffRow row;
  VisitColumns(row, [&](const char* name, const auto& value) {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, double>) {
      columns.push_back({name, StudyCellKind::kNumber});
    } else if constexpr (std::is_same_v<Value, std::string> || kIsNamed<Value>) {
      columns.push_back({name, StudyCellKind::kText});
    } else {
      columns.push_back({name, StudyCellKind::kInteger});
    }
  });
  return columns;
}

StudyRow CellsOf(const TradeoffRow& row) {
  StudyRow cells;
  VisitColumns(row, [&](std::string_view name, const auto& value) {
    cells.push_back(name == kPareto || IsOfARun(name, row) ? StudyCell() : Cell(value));
  });
  return cells;
}

std::vector<TradeoffRow> TradeoffRowsOf(const StudyTable& table) {
  std::vector<TradeoffRow> rows(table.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    VisitColumns(rows[i],
                 [&](std::string_view name, auto& value) { Read(table, i, name, &value); });
  }
  return rows;
}

StudyTable TradeoffTable(const std::vector<TradeoffRow>& rows) {
  std::vector<StudyRow> cells;
  for (const TradeoffRow& row : rows) {
    StudyRow& line = cells.emplace_back();
    VisitColumns(row, [&](std::string_view name, const auto& value) {
      line.push_back(IsOfARun(name, row) ? StudyCell() : Cell(value));
    });
  }
  return {TradeoffColumns(), std::move(cells)};
}

}  // namespace sarblock
