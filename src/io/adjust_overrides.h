// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

namespace sarblock {

/// Applies `KEY=VALUE` overrides to the `[adjust]` table of a block file, and those of
/// `trajectory.` to its `[trajectory]`; tables that are missing are made.
void ApplyOverrides(const std::vector<std::string>& overrides, toml::table* block_toml);

}  // namespace sarblock
