// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tables/toml.h"

namespace sarblock {

/// Kinds of correction groups in the order of CorrectionGroup::model.
const std::vector<std::string>& CorrectionKinds();

/// The keys of `[adjust.correction]` groups, in the order of the manual.
std::span<const AdjustOption> CorrectionOptions();

/// The groups of `[adjust.correction]`, kinds in the order of CorrectionKinds().
std::vector<CorrectionGroup> ReadCorrections(const TomlTable& correction,
                                             const std::vector<std::string>& pass_ids);

/// `[adjust.correction]` groups as TOML.
std::string DumpCorrections(const std::vector<CorrectionGroup>& groups);

/// Last parts of the options' keys that begin with `prefix` and have no further dot.
std::vector<std::string> KeysWithin(std::span<const AdjustOption> options, std::string_view prefix);

}  // namespace sarblock
