// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "study/study_table.h"
#include "tables/csv.h"

namespace sarblock {

/// What tells one study from another.
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

/// The whole records behind the first `begin` bytes. What stands behind a record that is cut or
/// damaged is not read.
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
[[nodiscard]] std::vector<StudyRow> StudyRowsOf(CsvReader reader,
                                                const std::vector<StudyColumn>& columns);
[[nodiscard]] std::vector<TableColumn> AskedColumns(const std::vector<StudyColumn>& columns);

}  // namespace sarblock
