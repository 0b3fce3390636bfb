// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "block_ids.h"
#include "folder_content.h"
#include "table_reader.h"

namespace sarblock {

/// Where the tables of a block or a result come from: a folder, one file of all (container.h) or
/// texts in memory.
class TableSource {
 public:
  explicit TableSource(FolderContent content) : content_(content) {}
  virtual ~TableSource() = default;
  /// Name for messages and text of a file that must be there.
  [[nodiscard]] virtual std::pair<std::string, std::string> Read(std::string_view file) const = 0;
  /// A table by its name without ending ("points"), or nothing if it does not stand there.
  [[nodiscard]] virtual std::unique_ptr<TableReader> Open(
      std::string_view table, std::span<const TableColumn> columns) const = 0;
  /// The name for messages of a table that must be there.
  [[nodiscard]] virtual std::string NameOf(std::string_view table) const = 0;
  /// The name that something takes that gives itself none.
  [[nodiscard]] virtual std::string DefaultName() const = 0;
  /// The ids that TableReader::IndexOfText() counts in; none where texts stand in their rows.
  [[nodiscard]] virtual BlockIds Ids() const { return {}; }
  /// A table that must be there.
  [[nodiscard]] std::unique_ptr<TableReader> Require(std::string_view table,
                                                     std::span<const TableColumn> columns) const;
  [[nodiscard]] FolderContent content() const { return content_; }

 protected:
  [[noreturn]] void FailMissing(const std::string& file, const char* what) const;
  FolderContent content_;
};

}  // namespace sarblock
