// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "study/stability_study.h"

namespace sarblock {

/// Reads a stability study (docs/studies.md): `families` lists names, each with the values it has
/// by default; `[[family]]` gives `name` and `values`. Without either: all families. Throws
/// InputError with FILE:LINE: field for syntax, unknown keys, wrong types, families that do not
/// exist or stand twice, and values outside the range a family has by default.
[[nodiscard]] StabilityStudy ReadStability(const std::filesystem::path& path,
                                           const std::vector<std::string>& overrides = {});

/// The same from text; `file` is its name in messages.
[[nodiscard]] StabilityStudy ParseStability(std::string_view text,
                                            const std::string& file,
                                            const std::vector<std::string>& overrides = {});

/// Dotted keys that overrides may name.
[[nodiscard]] std::vector<std::string> StabilityKeys();

}  // namespace sarblock
