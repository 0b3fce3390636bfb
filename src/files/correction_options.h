// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/files/block_file.h"
#include "sarblock/model/options.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tables/toml.h"

namespace sarblock::files {

struct ResultFile;

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

/// The keys of an `[adjust.prior.NAME]` table, in the order of the manual.
std::span<const AdjustOption> PriorOptions();

/// The tables of `[adjust.prior]` by name, without a check against passes and corrections.
std::vector<JointPrior> ReadPriors(const TomlTable& priors);

/// Refuses priors that do not fit their passes and correction groups (BindJointPriors), at the
/// place of what is wrong.
void RequireFitting(const TomlTable& table,
                    const std::vector<std::string>& pass_ids,
                    const std::vector<CorrectionGroup>& groups,
                    const std::vector<JointPrior>& priors);

/// `[adjust.prior.NAME]` tables as TOML.
std::string DumpPriors(const std::vector<JointPrior>& priors);

/// The `[adjust]` table of a parsed block file.
AdjustTable ReadAdjust(const TomlTable& block_toml, const std::vector<std::string>& pass_ids);

/// The name of the value that an option of type text has: "covariance", "quality.test".
std::string NameOfChoice(std::string_view key, const AdjustTable& options);

/// The correction groups that a result was made with, given or chosen, from the configuration in
/// its summary; none for `intersect`. Throws InputError where the configuration is not one that
/// `adjust` writes.
[[nodiscard]] std::vector<CorrectionGroup> CorrectionsOf(const ResultFile& result);

}  // namespace sarblock::files
