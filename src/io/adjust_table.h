// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <string>
#include <string_view>
#include <vector>

#include "tables/toml.h"

namespace sarblock {

/// The `[adjust]` table of a parsed block file.
AdjustOptions ReadAdjust(const TomlTable& block_toml, const std::vector<std::string>& pass_ids);

/// The name of the value that an option of type text has: "covariance", "quality.test".
std::string NameOfChoice(std::string_view key, const AdjustOptions& options);

}  // namespace sarblock
