// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "facts.h"

namespace sarblock {

/// Ranges that are too long by a constant, from `longer_m` on; empty `passes`: of all.
[[nodiscard]] Hypothesis RangeBias(const std::vector<std::string>& passes,
                                   double longer_m,
                                   double step_m);

/// Adds the hypotheses of ranges that this block gives reason to try, with first values
/// of their sizes: those that the sightings suggest, and those that show in a solution alone.
void AddRangeMistakes(const Facts& facts, Hypotheses* out);

}  // namespace sarblock
