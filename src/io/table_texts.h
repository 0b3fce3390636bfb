// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "table_source.h"

namespace sarblock {

/// Texts by the name of their file; a file whose text is absent does not stand there.
using FileTexts = std::vector<std::pair<std::string, std::optional<std::string_view>>>;
[[nodiscard]] std::unique_ptr<TableSource> TablesOfTexts(FileTexts texts, FolderContent content);

}  // namespace sarblock
