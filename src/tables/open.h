// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/tables/output.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "table.h"

namespace sarblock {

/// Texts by the name of their file; a file whose text is absent does not exist.
using FileTexts = std::vector<std::pair<std::string, std::optional<std::string_view>>>;
[[nodiscard]] std::unique_ptr<TableSource> TablesOfTexts(FileTexts texts, FolderContent content);

/// The tables of a folder or of a file that holds them. Throws InputError if it does not exist, is
/// a file of another kind, or is a result for a block or the reverse.
[[nodiscard]] std::unique_ptr<TableSource> TablesAt(const std::filesystem::path& path,
                                                    FolderContent content);
/// The folder from which names in a block's options count: its own, or that of its file.
[[nodiscard]] std::filesystem::path FolderOf(const std::filesystem::path& block);

/// Kind of the content at a path, as far as it shows before reading: a folder without a
/// summary.json is taken for a block. Throws InputError for an HDF5 file of another program.
[[nodiscard]] FolderContent ContentAt(const std::filesystem::path& path);

/// The file of a table in a folder: NAME.csv or NAME.csv.gz; nothing if neither is there. Both at
/// once are refused.
[[nodiscard]] std::optional<std::filesystem::path> FindTable(const std::filesystem::path& folder,
                                                             std::string_view name);

/// Size and checksum of a table's text, uncompressed where the file is a .csv.gz.
struct TableSum {
  std::string table;  ///< "points"
  std::uint64_t bytes = 0;
  std::string sha256;
};

/// Checksums of all tables in a folder. A result lists them in summary.json, and a reader compares
/// the tables with that list: tables of two runs, or tables changed since, are rejected.
[[nodiscard]] std::vector<TableSum> SumsOfTables(const std::filesystem::path& folder,
                                                 FolderContent content);

/// Has `write` write what is to be a block or a result: a folder, or one HDF5 file where the name
/// of `target` ends in ".h5". It appears as a whole or not at all; tables of an older content that
/// were not written now are removed. With Compression::kGzip a file's datasets are deflated.
void WriteTables(FolderContent content,
                 const std::filesystem::path& target,
                 Compression compression,
                 const BlockIds& ids,
                 const std::function<void(TableSink*)>& write);

}  // namespace sarblock
