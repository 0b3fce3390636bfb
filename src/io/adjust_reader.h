// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <string>
#include <string_view>
#include <vector>

#include "toml_reader.h"

namespace sarblock {

/// Names of an enumeration's values, in its order.
const std::vector<std::string>& Names(CorrectionChoice);
const std::vector<std::string>& Names(RobustLoss);
const std::vector<std::string>& Names(CovarianceLevel);
const std::vector<std::string>& Names(Datum);
const std::vector<std::string>& Names(Engine);
const std::vector<std::string>& Names(CeresSolver);
const std::vector<std::string>& Names(CovarianceMethod);
const std::vector<std::string>& Names(VarianceComponents);
const std::vector<std::string>& Names(BlunderTest);
const std::vector<std::string>& Names(FamilyWise);
const std::vector<std::string>& Names(Snooping);
const std::vector<std::string>& Names(SelectionOptions::Mode);
const std::vector<std::string>& Names(PairChoice);  ///< kList has no name: it is a file's

template <typename Enum>
const std::string& NameIn(Enum value) {
  return Names(value)[static_cast<std::size_t>(value)];
}

/// Kinds of correction groups in the order of CorrectionGroup::model.
const std::vector<std::string>& CorrectionKinds();

/// Applies `KEY=VALUE` overrides to the `[adjust]` table (made if missing) of a block file.
void ApplyOverrides(const std::vector<std::string>& overrides, toml::table* block_toml);

/// The `[adjust]` table of a parsed block file.
AdjustOptions ReadAdjust(const TomlTable& block_toml, const std::vector<std::string>& pass_ids);

/// The groups of `[adjust.correction]`, kinds in the order of CorrectionKinds().
std::vector<CorrectionGroup> ReadCorrections(const TomlTable& correction,
                                             const std::vector<std::string>& pass_ids);

/// The `[adjust.selection]` table; `groups` where correction tables stand beside it.
void ReadSelection(const TomlTable& table, bool groups, SelectionOptions* options);
/// The same as TOML.
std::string DumpSelection(const AdjustOptions& options);

/// Last parts of the option table's keys that begin with `prefix` and have no further dot.
std::vector<std::string> OptionKeys(std::string_view prefix);

/// A number x with x * factor == value where one exists near value / factor, so that a unit
/// converted for a file comes back to the same double.
double InUnit(double value, double factor);

/// `[adjust.correction]` groups as TOML.
std::string DumpCorrections(const std::vector<CorrectionGroup>& groups);

}  // namespace sarblock
