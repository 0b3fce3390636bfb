// SPDX-License-Identifier: Apache-2.0
#include "sarblock/io/convert.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <exception>
#include <functional>
#include <memory>
#include <system_error>

#include "core/parallel.h"
#include "json_reader.h"
#include "open_tables.h"
#include "toml_reader.h"
#include "write_tables.h"

namespace sarblock {
namespace {

namespace fs = std::filesystem;

void CopyCell(const TableReader& reader, std::size_t column, CellKind kind, TableWriter* out) {
  switch (kind) {
    case CellKind::kNumber:
    case CellKind::kRowNumber:
      out->Number(reader.Number(column));
      return;
    case CellKind::kCount:
    case CellKind::kFlag:
      if (!reader.Given(column)) {
        out->Empty();
      } else if (kind == CellKind::kFlag) {
        out->Integer(reader.Flag(column) ? 1 : 0);
      } else {
        out->Integer(reader.Count(column));
      }
      return;
    case CellKind::kText:
      out->Text(reader.Text(column));
      return;
    case CellKind::kPass:
    case CellKind::kPoint:
      out->Id(reader.Id(column), reader.IndexOfText(column));
      return;
  }
}

/// The columns that the table has, those that nobody knows as text behind the others.
std::vector<TableColumn> ColumnsOf(const TableReader& reader,
                                   std::span<const TableColumn> described) {
  std::vector<TableColumn> columns;
  for (std::size_t i = 0; i < described.size(); ++i) {
    if (reader.Has(i)) columns.push_back(described[i]);
  }
  for (const std::string& name : reader.unknown_columns()) {
    columns.push_back({name, ColumnNeed::kOptional, CellKind::kText});
  }
  return columns;
}

/// Rows that a thread copies.
struct CopiedRows {
  std::unique_ptr<TableReader> from;
  std::unique_ptr<TableWriter> to;
  std::size_t rows = 0;
  std::exception_ptr error;
};

void CopyRows(std::span<const TableColumn> columns, CopiedRows* copied) {
  try {
    while (copied->from->Next()) {
      for (std::size_t i = 0; i < columns.size(); ++i) {
        CopyCell(*copied->from, i, columns[i].kind, copied->to.get());
      }
      copied->to->EndRow();
      ++copied->rows;
    }
  } catch (const InputError&) {
    copied->error = std::current_exception();
  }
  copied->from.reset();
}

/// All rows of a table by all threads: while some are copied, those copied before are written, in
/// their order. An error is that of the first row with one.
void CopyAllRows(std::span<const TableColumn> columns,
                 TableReader* reader,
                 TableWriter* writer,
                 const std::function<void(std::size_t)>& count) {
  const auto at_once = static_cast<std::size_t>(ThreadsAllowed());
  std::vector<CopiedRows> copied;
  bool ended = false;
  while (!ended || !copied.empty()) {
    std::vector<CopiedRows> copying;
    std::exception_ptr error;  // of the file, behind these rows
    try {
      while (!ended && copying.size() < at_once) {
        CopiedRows next{reader->Part(), writer->Part(), 0, {}};
        ended = next.from == nullptr;
        if (!ended) copying.push_back(std::move(next));
      }
    } catch (const InputError&) {
      error = std::current_exception();
    }
    ParallelForChunks(1 + copying.size(), 1, [&](std::size_t k, std::size_t, std::size_t) {
      if (k > 0) {
        CopyRows(columns, &copying[k - 1]);
        return;
      }
      for (CopiedRows& rows : copied) {
        writer->Append(*rows.to);
        rows.to.reset();
      }
    });
    for (const CopiedRows& rows : copying) {
      if (rows.error) std::rethrow_exception(rows.error);
      count(rows.rows);
    }
    if (error) std::rethrow_exception(error);
    copied = std::move(copying);
  }
}

void CopyTable(const TableSource& source,
               const TableDescription& table,
               TableSink* sink,
               ConversionReport* report,
               ProgressSink* progress) {
  const auto first = source.Open(table.name, table.columns);
  if (!first) return;
  const std::vector<TableColumn> columns = ColumnsOf(*first, table.columns);
  for (std::size_t i = table.columns.size(); i < columns.size(); ++i) {
    const auto same = [&](const TableColumn& column) { return column.name == columns[i].name; };
    if (columns[i].name.empty() || std::count_if(columns.begin(), columns.end(), same) > 1) {
      throw InputError(first->Place(0), "a column without a name of its own cannot be converted");
    }
  }
  const auto reader = source.Open(table.name, columns);
  const auto writer = sink->Open(table.name, columns);
  CopyAllRows(columns, reader.get(), writer.get(), [&](std::size_t rows) {
    report->rows += rows;
    Step(progress, "convert", report->rows, 0, std::string(table.name));
  });
  writer->Commit();
  ++report->tables;
}

/// Refuses a block.toml that is no TOML, a summary.json that is no JSON.
void RequireReadable(FolderContent content, const std::string& text, const std::string& name) {
  if (content == FolderContent::kBlock) {
    static_cast<void>(ParseToml(text, name));
  } else {
    static_cast<void>(JsonFile(text, name));
  }
}

/// Visible files of a folder that are no table of its kind.
std::vector<std::string> LeftOut(const fs::path& folder, FolderContent content) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    std::string name = entry.path().filename().string();
    const bool text = name == "block.toml" || name == "summary.json";
    const auto is_table = [&](const TableDescription& table) {
      return name == std::string(table.name) + ".csv" ||
             name == std::string(table.name) + ".csv.gz";
    };
    const auto tables = TablesOf(content);
    if (name.starts_with('.') || text || std::any_of(tables.begin(), tables.end(), is_table)) {
      continue;
    }
    names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

ConversionReport Convert(const fs::path& from,
                         const fs::path& to,
                         Compression compression,
                         ProgressSink* progress) {
  const FolderContent content = ContentAt(from);
  const auto source = TablesAt(from, content);
  std::error_code ignored;
  if (fs::equivalent(from, to, ignored)) {
    throw InputError(FilePlace{to.string(), 0, ""}, "is what is converted; another name is needed");
  }
  const char* const file = content == FolderContent::kBlock ? "block.toml" : "summary.json";
  const auto [name, text] = source->Read(file);
  RequireReadable(content, text, name);
  ConversionReport report{NameOf(content)};
  WriteTables(content, to, compression, source->Ids(), [&, &kept = text](TableSink* sink) {
    for (const TableDescription& table : TablesOf(content)) {
      CopyTable(*source, table, sink, &report, progress);
    }
    sink->WriteText(file, kept);
  });
  if (fs::is_directory(from)) report.left_out = LeftOut(from, content);
  return report;
}

}  // namespace sarblock
