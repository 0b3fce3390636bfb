// SPDX-License-Identifier: Apache-2.0
#include "convert.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <memory>
#include <string_view>
#include <system_error>
#include <vector>

#include "summary.h"
#include "tables/json.h"
#include "tables/open.h"
#include "tables/toml.h"

namespace sarblock::files {
namespace {

namespace fs = std::filesystem;

/// Throws where a cell of these rows is not what its column allows.
void CheckCells(Schema schema, const Batch& batch) {
  for (std::size_t number = 0; number < batch.rows; ++number) {
    const Row row(batch, number);
    for (std::size_t i = 0; i < schema.size(); ++i) {
      const CellKind kind = schema[i].kind;
      if (kind == CellKind::kPass || kind == CellKind::kPoint) {
        static_cast<void>(row.Id(i));
      } else if (kind == CellKind::kCount) {
        static_cast<void>(row.Count(i));
      } else if (kind == CellKind::kFlag) {
        static_cast<void>(row.Flag(i));
      } else if (kind != CellKind::kText) {
        static_cast<void>(row.Number(i));
      }
    }
  }
}

/// The columns that the table has, those that nobody knows as text behind the others.
std::vector<TableColumn> ColumnsOf(const TableReader& reader, Schema described) {
  std::vector<TableColumn> columns;
  for (std::size_t i = 0; i < described.size(); ++i) {
    if (reader.Has(i)) columns.push_back(described[i]);
  }
  for (const std::string& name : reader.unknown_columns()) {
    columns.push_back({name, ColumnNeed::kOptional, CellKind::kText});
  }
  return columns;
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
      throw InputError(first->PlaceAt(0, 0),
                       "a column without a name of its own cannot be converted");
    }
  }
  const auto reader = source.Open(table.name, columns);
  const auto writer = sink->Open(table.name, columns);
  struct Nothing {};
  ForBatches<Nothing>(
      reader.get(),
      [&](Batch* batch, Nothing*) {
        CheckCells(columns, *batch);
        writer->Format(batch);
      },
      [&](Batch* batch, Nothing*) {
        writer->Write(batch);
        report->rows += batch->rows;
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

/// The text of a summary.json beside these tables, whose checksums it lists.
std::string ListingTables(const std::string& text, const fs::path& folder) {
  auto summary = nlohmann::ordered_json::parse(text);
  if (!summary.is_object()) return text;
  const auto tables = TablesJson(SumsOfTables(folder, FolderContent::kResult));
  if (summary.contains("tables") && summary["tables"] == tables) return text;
  summary["tables"] = tables;
  return summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
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
    const auto folder = sink->folder();
    const bool lists = content == FolderContent::kResult && folder;
    sink->WriteText(file, lists ? ListingTables(kept, *folder) : kept);
  });
  if (fs::is_directory(from)) report.left_out = LeftOut(from, content);
  return report;
}

}  // namespace sarblock::files
