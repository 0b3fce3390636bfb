// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "csv_reader.h"

namespace sarblock {

/// What a folder is to its reader, for messages.
struct FolderKind {
  const char* name;   ///< "block"
  const char* holds;  ///< "block.toml, trajectories.csv and observations.csv"
};

/// Where the files of a block or a result come from: a folder or texts in memory.
class TableSource {
 public:
  explicit TableSource(FolderKind kind) : kind_(kind) {}
  virtual ~TableSource() = default;
  /// Name for messages and text of a file that must be there.
  [[nodiscard]] virtual std::pair<std::string, std::string> Read(std::string_view file) const = 0;
  /// A table by its name without ending ("points"), or nothing if it does not stand there.
  [[nodiscard]] virtual std::optional<CsvReader> Open(std::string_view table,
                                                      std::span<const CsvColumn> columns) const = 0;
  /// The name for messages of a table that must be there.
  [[nodiscard]] virtual std::string NameOf(std::string_view table) const = 0;
  /// The name that something takes that gives itself none.
  [[nodiscard]] virtual std::string DefaultName() const = 0;
  /// A table that must be there.
  [[nodiscard]] CsvReader Require(std::string_view table, std::span<const CsvColumn> columns) const;

 protected:
  [[noreturn]] void FailMissing(const std::string& file, const char* what) const;
  FolderKind kind_;
};

/// Throws InputError if it does not exist, is a file, or is a result for a block or the reverse.
void RequireFolder(const std::filesystem::path& folder, FolderKind kind);

/// The same, and its files.
[[nodiscard]] std::unique_ptr<TableSource> TablesOfFolder(const std::filesystem::path& folder,
                                                          FolderKind kind);

/// Texts by the name of their file; a file whose text is absent does not stand there.
using FileTexts = std::vector<std::pair<std::string, std::optional<std::string_view>>>;
[[nodiscard]] std::unique_ptr<TableSource> TablesOfTexts(FileTexts texts, FolderKind kind);

/// The file of a table in a folder: NAME.csv or NAME.csv.gz; nothing if neither is there. Both at
/// once are refused.
[[nodiscard]] std::optional<std::filesystem::path> FindTable(const std::filesystem::path& folder,
                                                             std::string_view name);

}  // namespace sarblock
