// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>

#include "table_source.h"

namespace sarblock {

/// The tables of a folder or of a file that holds them. Throws InputError if it does not exist, is
/// a file of another kind, or is a result for a block or the reverse.
[[nodiscard]] std::unique_ptr<TableSource> TablesAt(const std::filesystem::path& path,
                                                    FolderContent content);
/// The folder from which names in a block's options count: its own, or that of its file.
[[nodiscard]] std::filesystem::path FolderOf(const std::filesystem::path& block);

/// What stands there, as far as it can be told before it is read: a folder without a summary.json
/// is taken for a block. Throws InputError for an HDF5 file of others.
[[nodiscard]] FolderContent ContentAt(const std::filesystem::path& path);

/// The file of a table in a folder: NAME.csv or NAME.csv.gz; nothing if neither is there. Both at
/// once are refused.
[[nodiscard]] std::optional<std::filesystem::path> FindTable(const std::filesystem::path& folder,
                                                             std::string_view name);

}  // namespace sarblock
