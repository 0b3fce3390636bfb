// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <span>
#include <string>
#include <vector>

#include "tables/toml.h"

namespace sarblock {

/// The keys of an `[adjust.prior.NAME]` table, in the order of the manual.
std::span<const AdjustOption> PriorOptions();

/// The tables of `[adjust.prior]` by name, without looking at what they speak of.
std::vector<JointPrior> ReadPriors(const TomlTable& priors);

/// Refuses priors that do not fit their passes and correction groups (BindJointPriors), at the
/// place of what is wrong.
void RequireFitting(const TomlTable& table,
                    const std::vector<std::string>& pass_ids,
                    const std::vector<CorrectionGroup>& groups,
                    const std::vector<JointPrior>& priors);

/// `[adjust.prior.NAME]` tables as TOML.
std::string DumpPriors(const std::vector<JointPrior>& priors);

}  // namespace sarblock
