// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

namespace sarblock {

/// Applies `KEY=VALUE` overrides to the `[adjust]` table (made if missing) of a block file.
void ApplyOverrides(const std::vector<std::string>& overrides, toml::table* block_toml);

}  // namespace sarblock
