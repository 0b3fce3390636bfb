// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

namespace sarblock {

/// The file of a table in a folder: NAME.csv or NAME.csv.gz; nothing if neither is there. Both at
/// once are refused.
[[nodiscard]] std::optional<std::filesystem::path> FindTable(const std::filesystem::path& folder,
                                                             std::string_view name);

}  // namespace sarblock
