// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tables/csv.h"
#include "tables/toml.h"

namespace sarblock {

/// What all studies have in common: rows that are computed independently, kept as they finish,
/// and shown in the study's order.

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

/// Whether a report shows a column; it refuses tables without one that it needs.
enum class InReport { kYes, kNo, kNeeded };

/// One column of a study's table; units are in the name, as in every table (docs/formats.md). Code
/// that writes, reads, joins or shows a table takes its columns from one list.
struct StudyColumn {
  std::string name;
  StudyCellKind kind = StudyCellKind::kNumber;
  InReport report = InReport::kYes;
};

/// A cell: nothing, a finite number, a whole number or a text without line breaks.
using StudyCell = std::variant<std::monostate, double, std::int64_t, std::string>;
using StudyRow = std::vector<StudyCell>;

/// A row by the names of its columns; what is not set stays empty.
class StudyRowMaker {
 public:
  /// `columns` must outlive it.
  explicit StudyRowMaker(const std::vector<StudyColumn>& columns)
      : columns_(columns), row_(columns.size()) {}

  /// A number that is not finite stays empty. std::logic_error where there is no such column.
  StudyRowMaker& Set(std::string_view column, StudyCell cell);
  StudyRowMaker& Count(std::string_view column, std::size_t count);
  /// Sets the column `message`, on one line.
  StudyRowMaker& Message(std::string text);
  [[nodiscard]] const StudyRow& row() const { return row_; }

 private:
  const std::vector<StudyColumn>& columns_;
  StudyRow row_;
};

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

/// A piece of a study that is computed and stored as a whole: one row, or several that are only
/// meaningful together (candidates timed in turn with their reference). The rows are a function of
/// the study's file alone, not of other tasks or of the number of threads. `progress` says whether
/// to stop; updates to it are not shown while tasks run side by side.
struct StudyTask {
  std::string name;  ///< for people, beside the bar
  std::function<std::vector<StudyRow>(ProgressSink* progress)> compute;
};

/// Where finished tasks are kept (study.h). Calls come from one thread at a time.
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

/// Computes the tasks of a part that `store` does not have yet, keeps each task as it finishes, and
/// returns all rows in the order of the tasks. Throws Interrupted once `progress` is cancelled:
/// what was finished is kept. Any other exception of a task ends the study the same way; a study
/// that reports failed rows catches it itself. std::logic_error for a row that does not fit the
/// columns.
[[nodiscard]] StudyTable RunStudy(const StudyPlan& plan,
                                  StudyStore* store = nullptr,
                                  ProgressSink* progress = nullptr,
                                  TaskPart part = {});

/// What identifies a study.
struct StudyIdentity {
  std::string name;  ///< of the table: NAME.csv
  std::vector<StudyColumn> columns;
  std::size_t tasks = 0;
  std::string text;    ///< everything the rows are a function of: the effective study file, scenes
  TaskPart part = {};  ///< which of its tasks are computed here
};

/// NAME.progress: the finished tasks of a study in the order they finished.
///
///     sarblock-study-progress 2 HASH     FNV-1a, 64 bits, of the text, columns and version
///     part I N                           of a part alone: its tasks are those with task mod N = I
///     task T rows R                      then R lines as in NAME.csv, then
///     end T HASH                         with that of these lines
struct StudyJournal {
  std::map<std::size_t, std::string> rows;  ///< lines of the rows by task
  std::size_t end = 0;                      ///< of the last whole record, in bytes
};

/// The first line of a study, and that of its part where it is one.
[[nodiscard]] std::string StudyJournalHead(const StudyIdentity& identity);

/// The part that a journal says it holds; all where it says nothing.
[[nodiscard]] TaskPart PartOfJournal(std::string_view text);

/// The whole records after the first `begin` bytes. Nothing after a truncated or damaged record is
/// read.
[[nodiscard]] StudyJournal ReadStudyJournal(std::string_view text,
                                            std::size_t begin,
                                            std::size_t tasks);

/// One finished task.
[[nodiscard]] std::string StudyRecord(std::size_t task, std::size_t rows, std::string_view text);

/// The header line of NAME.csv, rows as its lines, and back. `file` names the lines in messages.
[[nodiscard]] std::string StudyHeadingText(const std::vector<StudyColumn>& columns);
[[nodiscard]] std::string StudyRowsText(const std::vector<StudyRow>& rows);
[[nodiscard]] std::vector<StudyRow> StudyRowsOf(const std::string& text,
                                                const std::vector<StudyColumn>& columns,
                                                const std::string& file);

enum class StudyStart {
  kResume,   ///< keep what an earlier run of the same study finished
  kRestart,  ///< remove it
};

/// The rows of a study in a folder.
///
/// `NAME.csv` is the table. It grows as tasks finish, in the study's order: at every moment it
/// has whole rows, from the first on. `NAME.progress` has every finished task in the order they
/// finished (study.h); a later run resumes from it. A record that a killed run left half written
/// there is dropped. `NAME.study.toml` is the identity's text: the study as it ran, for reports.
///
/// For a part both have the tasks of that part alone, in their order.
///
/// kResume throws InputError if the folder has rows of another study or of another part, or
/// NAME.csv without NAME.progress; both modes if another process has the study open.
class StudyRows final : public StudyStore {
 public:
  StudyRows(const std::filesystem::path& folder, StudyIdentity identity, StudyStart start);
  ~StudyRows() override;

  [[nodiscard]] const std::vector<StudyRow>* Find(std::size_t task) const override;
  void Keep(std::size_t task, const std::vector<StudyRow>& rows) override;
  /// Tasks taken over from an earlier run.
  [[nodiscard]] std::size_t kept() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A table as the text of NAME.csv.
[[nodiscard]] std::string StudyTableText(const StudyTable& table);

/// A NAME.csv read back. Throws InputError with file, line and column.
[[nodiscard]] StudyTable ReadStudyTable(const std::filesystem::path& file,
                                        std::vector<StudyColumn> columns);

/// The rows of every task of a study, in their order, from the folders of its parts. Throws
/// InputError naming the folder that holds no part, a part of another study, of another number of
/// parts, a part that is there twice or is not finished, and the parts that are missing.
[[nodiscard]] std::vector<std::vector<StudyRow>> JoinStudyParts(
    const std::vector<std::filesystem::path>& folders, const StudyIdentity& identity);

/// Takes `format`, `study`, `name`, `purpose` and `seed`, which every study file has, and refuses a
/// file of another kind; the rest is the reader's. `kind` is the command ("densification").
[[nodiscard]] StudyHeading TakeStudyHeading(const std::string& kind, SceneTable* table);

/// The study file's text after the overrides, for `--dump-config` and as a study's identity: the
/// same keys and values give the same text with any comments. Checks syntax only.
[[nodiscard]] std::string EffectiveStudyText(const std::filesystem::path& path,
                                             const std::vector<std::string>& overrides = {});

/// The text of NAME.study.toml: the study whose rows are in `table`, "NAME.csv".
[[nodiscard]] std::string StudyAsItRan(const std::string& table, const std::string& identity);

/// A scene as comment lines of TOML, its name before its text: a study as it ran, NAME.study.toml,
/// carries its scenes so and can be read as the study that it is.
[[nodiscard]] std::string SceneAsComment(const std::string& name, const std::string& text);

/// Texts of scenes by the names that a study gives them: those that the study's own text carries,
/// the others of files beside it.
[[nodiscard]] std::function<std::string(const std::string& name)> ScenesOf(
    const std::filesystem::path& study_file, const std::string& study_text);

}  // namespace sarblock
