// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "facts.h"

namespace sarblock {

/// Squints that are too large by a constant, from `value_rad` on; empty `passes`: of all.
[[nodiscard]] Hypothesis SquintBias(const std::vector<std::string>& passes,
                                    double value_rad,
                                    double step_rad);

/// Adds the hypotheses of look sides and cones that this block gives reason to try, with first
/// values of their sizes: those that the sightings suggest, and those that show in a solution
/// alone.
void AddConeMistakes(const Facts& facts, Hypotheses* out);

}  // namespace sarblock
