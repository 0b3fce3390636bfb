// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sarblock {

/// The study file's text after the overrides, for `--dump-config` and as a study's identity: the
/// same keys and values give the same text, whatever the comments. Checks syntax only.
[[nodiscard]] std::string EffectiveStudyText(const std::filesystem::path& path,
                                             const std::vector<std::string>& overrides = {});

}  // namespace sarblock
