// SPDX-License-Identifier: Apache-2.0
#include "study_journal.h"

#include "sarblock/core/error.h"

#include <charconv>
#include <cstdint>
#include <utility>

#include "core/text.h"
#include "tables/csv.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::string_view kRecordFormat = "sarblock-study-progress 2 ";

/// Takes "WORD N" off a line; nothing where it reads otherwise.
bool TakeNumber(std::string_view* line, std::string_view word, std::size_t* value) {
  if (!line->starts_with(word)) return false;
  line->remove_prefix(word.size());
  const auto [end, error] = std::from_chars(line->data(), line->data() + line->size(), *value);
  if (error != std::errc()) return false;
  line->remove_prefix(static_cast<std::size_t>(end - line->data()));
  return true;
}

/// The line that ends a record. The checksum of its rows tells a damaged file from a whole one.
std::string LastLineOf(std::size_t task, std::string_view rows) {
  return fmt::format("end {} {:016x}", task, Fnv1a(rows));
}

/// The line behind the first one of a journal, without its end.
std::string_view SecondLineOf(std::string_view text) {
  const std::size_t first = text.find('\n');
  if (first == std::string_view::npos) return {};
  text.remove_prefix(first + 1);
  const std::size_t second = text.find('\n');
  return second == std::string_view::npos ? std::string_view() : text.substr(0, second);
}

}  // namespace

std::string StudyJournalHead(const StudyIdentity& identity) {
  std::uint64_t hash = Fnv1a(Version());
  hash = Fnv1a(StudyHeadingText(identity.columns), hash);
  hash = Fnv1a(fmt::format("{}\n{}\n{}", identity.name, identity.tasks, identity.text), hash);
  std::string head = fmt::format("{}{:016x}\n", kRecordFormat, hash);
  if (!identity.part.IsWhole()) {
    head += fmt::format("part {} {}\n", identity.part.index, identity.part.count);
  }
  return head;
}

TaskPart PartOfJournal(std::string_view text) {
  std::string_view line = SecondLineOf(text);
  TaskPart part;
  if (TakeNumber(&line, "part ", &part.index) && TakeNumber(&line, " ", &part.count) &&
      line.empty() && part.index < part.count) {
    return part;
  }
  return {};
}

StudyJournal ReadStudyJournal(std::string_view text, std::size_t begin, std::size_t tasks) {
  StudyJournal journal;
  journal.end = begin;
  std::size_t at = begin;
  const auto next = [&]() -> std::optional<std::string_view> {
    const std::size_t stop = text.find('\n', at);
    if (stop == std::string_view::npos) return std::nullopt;
    const std::string_view line = text.substr(at, stop - at);
    at = stop + 1;
    return line;
  };
  for (;;) {
    std::optional<std::string_view> line = next();
    std::size_t task = 0, count = 0;
    if (!line || !TakeNumber(&*line, "task ", &task) || !TakeNumber(&*line, " rows ", &count) ||
        !line->empty() || task >= tasks) {
      return journal;
    }
    const std::size_t rows_begin = at;
    for (std::size_t i = 0; i < count; ++i) {
      if (!next()) return journal;
    }
    const std::string_view rows = text.substr(rows_begin, at - rows_begin);
    line = next();
    if (!line || *line != LastLineOf(task, rows)) return journal;
    journal.rows[task] = rows;
    journal.end = at;
  }
}

std::vector<TableColumn> AskedColumns(const std::vector<StudyColumn>& columns) {
  std::vector<TableColumn> asked;
  for (const StudyColumn& column : columns) asked.push_back({column.name, ColumnNeed::kRequired});
  return asked;
}

std::vector<StudyRow> StudyRowsOf(CsvReader reader, const std::vector<StudyColumn>& columns) {
  std::vector<StudyRow> rows;
  while (reader.Next()) {
    StudyRow row(columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (!reader.Given(i)) continue;
      if (columns[i].kind == StudyCellKind::kText) {
        row[i] = std::string(reader.Text(i));
      } else if (columns[i].kind == StudyCellKind::kNumber) {
        row[i] = reader.Number(i);
      } else {
        row[i] = static_cast<std::int64_t>(reader.Number(i));
      }
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string StudyRecord(std::size_t task, std::size_t rows, std::string_view text) {
  return fmt::format("task {} rows {}\n{}{}\n", task, rows, text, LastLineOf(task, text));
}

std::string StudyHeadingText(const std::vector<StudyColumn>& columns) {
  std::string line;
  for (const StudyColumn& column : columns) {
    if (!line.empty()) line += ',';
    AppendCsvText(column.name, &line);
  }
  return line + '\n';
}

std::string StudyRowsText(const std::vector<StudyRow>& rows) {
  std::string text;
  for (const StudyRow& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0) text += ',';
      if (const auto* number = std::get_if<double>(&row[i])) {
        AppendNumber(*number, &text);
      } else if (const auto* integer = std::get_if<std::int64_t>(&row[i])) {
        text += std::to_string(*integer);
      } else if (const auto* words = std::get_if<std::string>(&row[i])) {
        AppendCsvText(*words, &text);
      }
    }
    text += '\n';
  }
  return text;
}

std::vector<StudyRow> StudyRowsOf(const std::string& text,
                                  const std::vector<StudyColumn>& columns,
                                  const std::string& file) {
  const std::string whole = StudyHeadingText(columns) + text;
  return StudyRowsOf(CsvReader(file, whole, AskedColumns(columns)), columns);
}

}  // namespace sarblock
