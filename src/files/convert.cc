// SPDX-License-Identifier: Apache-2.0
#include "sarblock/files/convert.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/threads.h"
#include "tables/json.h"
#include "tables/open.h"
#include "tables/toml.h"

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

/// Whether a cell of counts or flags may hold this number, or nothing.
bool IsAllowed(CellKind kind, double value) {
  if (std::isnan(value)) return true;
  if (kind == CellKind::kCount)
    return value >= 0.0 && value <= 4294967295.0 && value == std::floor(value);
  return value == 1.0 || (value == 0.0 && !std::signbit(value));
}

bool CopyNumbers(const TableReader& part, std::size_t column, CellKind kind, TableWriter* out) {
  const std::span<const double> values = part.NumbersAhead(column);
  if (values.size() != part.RowCount()) return false;
  const bool counts = kind == CellKind::kCount || kind == CellKind::kFlag;
  bool allowed = true;
  if (counts) {
    for (const double value : values) allowed &= IsAllowed(kind, value);
  } else if (!part.NoneAhead(column)) {
    constexpr auto kExponentBits =
        std::bit_cast<std::uint64_t>(std::numeric_limits<double>::infinity());
    constexpr auto kNanBits =
        std::bit_cast<std::uint64_t>(std::numeric_limits<double>::quiet_NaN());
    for (const double value : values) {
      const auto bits = std::bit_cast<std::uint64_t>(value);
      allowed &= (bits & kExponentBits) != kExponentBits || bits == kNanBits;
    }
  }
  return allowed && out->LendNumbers(column, values);
}

bool CopyTexts(const TableReader& part, std::size_t column, CellKind kind, TableWriter* out) {
  const std::span<const std::uint32_t> texts = part.TextNumbersAhead(column);
  std::uint32_t* const to = out->IndicesOf(column, part.RowCount());
  if (to == nullptr || texts.size() != part.RowCount()) return false;
  if (kind == CellKind::kPass) {  // few, each of which FindPassesAhead() has looked at
    std::vector<std::uint32_t> found;
    if (!part.IndicesAhead(column, &found)) return false;
    std::copy(texts.begin(), texts.end(), to);
    return true;
  }
  for (std::size_t row = 0; row < texts.size(); ++row) {
    const bool same = row > 0 && texts[row] == texts[row - 1];
    if (same) {
      to[row] = to[row - 1];
      continue;
    }
    const std::string_view text = part.TextAhead(column, texts[row]);
    if (kind == CellKind::kPoint && TableReader::ProblemOfId(text) != nullptr) return false;
    to[row] = kind == CellKind::kPoint ? texts[row] : out->IndexOf(column, text);
  }
  return true;
}

/// The rows of a part that no row has been read of as whole columns, from one file of all tables to
/// another. False where that cannot be or one of them is to be refused: CopyRows() then copies them
/// cell by cell and says why.
bool CopyColumns(std::span<const TableColumn> columns, const TableReader& part, TableWriter* out) {
  if (part.RowCount() == 0) return false;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const CellKind kind = columns[i].kind;
    const bool text =
        kind == CellKind::kText || kind == CellKind::kPass || kind == CellKind::kPoint;
    if (!(text ? CopyTexts(part, i, kind, out) : CopyNumbers(part, i, kind, out))) return false;
  }
  out->EndRows(part.RowCount());
  return true;
}

/// Looks at the ids of passes of a part, each once, whether they can be ids.
void FindPassesAhead(std::span<const TableColumn> columns, const TableReader& part) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].kind != CellKind::kPass) continue;
    static_cast<void>(part.LookupAhead(i, [](std::string_view id) {
      return TableReader::ProblemOfId(id) != nullptr ? TableReader::kUnknown : 0;
    }));
  }
}

/// Rows that a thread copies.
struct CopiedRows {
  std::unique_ptr<TableReader> from;
  std::unique_ptr<TableWriter> to;
  std::size_t rows = 0;
};

void CopyRows(std::span<const TableColumn> columns, CopiedRows* copied) {
  while (copied->from->Next()) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      CopyCell(*copied->from, i, columns[i].kind, copied->to.get());
    }
    copied->to->EndRow();
    ++copied->rows;
  }
}

/// All rows of a table by all threads: while some are copied, those copied before are written, in
/// their order.
void CopyAllRows(std::span<const TableColumn> columns,
                 TableReader* reader,
                 TableWriter* writer,
                 const std::function<void(std::size_t)>& count) {
  std::vector<CopiedRows> held(ItemsAtOnce());
  const auto next = [&](std::size_t place) {
    CopiedRows& copied = held[place];
    copied.from = reader->Part();
    if (copied.to == nullptr) copied.to = writer->Part();
    if (copied.from != nullptr) FindPassesAhead(columns, *copied.from);
    return copied.from != nullptr;
  };
  const auto copy = [&](std::size_t place) {
    CopiedRows& copied = held[place];
    copied.rows = copied.from->RowCount();
    if (!CopyColumns(columns, *copied.from, copied.to.get())) {
      copied.to = writer->Part();
      copied.rows = 0;
      CopyRows(columns, &copied);
      copied.to->EndPart();
    }
  };
  const auto write = [&](std::size_t place) {
    writer->Append(held[place].to.get());
    held[place].from.reset();  // whose columns were lent
    count(held[place].rows);
  };
  PipeInOrder(held.size(), next, copy, write);
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
