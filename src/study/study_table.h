// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace sarblock {

/// What all studies have in common: rows that are computed each for itself, kept as they finish,
/// and told in the study's order.

/// What every study file begins with (docs/studies.md).
struct StudyHeading {
  std::string name;
  std::string purpose;
  std::uint64_t seed = 1;
};

enum class StudyCellKind {
  kNumber,
  kInteger,
  kText,
};

/// One column of a study's table; units stand in the name, as in every table (docs/formats.md).
struct StudyColumn {
  std::string name;
  StudyCellKind kind = StudyCellKind::kNumber;
};

/// A cell: nothing, a finite number, a whole number or a text without line breaks.
using StudyCell = std::variant<std::monostate, double, std::int64_t, std::string>;
using StudyRow = std::vector<StudyCell>;

/// A finished table, for words and plots.
class StudyTable {
 public:
  StudyTable(std::vector<StudyColumn> columns, std::vector<StudyRow> rows);

  [[nodiscard]] const std::vector<StudyColumn>& columns() const { return columns_; }
  [[nodiscard]] const std::vector<StudyRow>& rows() const { return rows_; }
  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  /// Cell by the column's name; std::logic_error where there is no such column. An empty cell is
  /// NaN; a whole number may be read as a number.
  [[nodiscard]] double Number(std::size_t row, std::string_view column) const;
  /// The text; empty for an empty cell.
  [[nodiscard]] std::string Text(std::size_t row, std::string_view column) const;

 private:
  [[nodiscard]] const StudyCell& Cell(std::size_t row, std::string_view column) const;
  std::vector<StudyColumn> columns_;
  std::vector<StudyRow> rows_;
};

/// A piece of a study that is computed and kept as a whole: one row, or several that only make
/// sense together (candidates timed in turn with their reference). The rows are a function of the
/// study's file alone, not of other tasks or of the number of threads. `progress` tells whether to
/// stop; updates to it are not shown while tasks run side by side.
struct StudyTask {
  std::string name;  ///< for people, beside the bar
  std::function<std::vector<StudyRow>(ProgressSink* progress)> compute;
};

/// Where finished tasks are kept (io: study_rows.h). Calls come from one thread at a time.
class StudyStore {
 public:
  virtual ~StudyStore() = default;
  /// Rows of a task that an earlier run finished; null if it did not.
  [[nodiscard]] virtual const std::vector<StudyRow>* Find(std::size_t task) const = 0;
  virtual void Keep(std::size_t task, const std::vector<StudyRow>& rows) = 0;
};

enum class TaskOrder {
  kSideBySide,  ///< on all threads, begun in the order of the study
  kOneByOne,    ///< for what is timed, or uses all threads itself
};

/// "part 3/8" as --part takes it, 8/8 that of index 0; "a whole study".
[[nodiscard]] std::string NameOfStudy(const TaskPart& part);

/// A study ready to run.
struct StudyPlan {
  std::vector<StudyColumn> columns;
  std::vector<StudyTask> tasks;
  TaskOrder order = TaskOrder::kSideBySide;
};

/// Computes what of a part `store` does not have yet, keeps each task as it finishes, and returns
/// all rows in the order of the tasks. Throws Interrupted once `progress` is cancelled: what was
/// finished is kept. Any other exception of a task ends the study the same way; what a study wants
/// to tell of a row that failed it catches itself. std::logic_error for a row that does not fit the
/// columns.
[[nodiscard]] StudyTable RunStudy(const StudyPlan& plan,
                                  StudyStore* store = nullptr,
                                  ProgressSink* progress = nullptr,
                                  TaskPart part = {});

}  // namespace sarblock
