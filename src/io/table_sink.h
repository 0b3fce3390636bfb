// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "table_columns.h"
#include "table_writer.h"

namespace sarblock {

/// Where the tables of a block or a result are written: a folder or one file of all.
class TableSink {
 public:
  virtual ~TableSink() = default;
  /// A table with these of its columns; one is open at a time.
  [[nodiscard]] virtual std::unique_ptr<TableWriter> Open(std::string_view table,
                                                          std::span<const TableColumn> columns) = 0;
  /// block.toml or summary.json, after the tables.
  virtual void WriteText(std::string_view file, std::string_view text) = 0;
  /// Where files go that are no tables; nothing where there is no folder.
  [[nodiscard]] virtual std::optional<std::filesystem::path> folder() const = 0;
};

}  // namespace sarblock
