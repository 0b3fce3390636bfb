// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "facts.h"

namespace sarblock {

/// Times that are late by a constant, from `late_s` on; empty `passes`: of all.
[[nodiscard]] Hypothesis ConstantTime(const std::vector<std::string>& passes,
                                      double late_s,
                                      double step_s);

/// Adds the hypotheses of times that this block gives reason to try, with first values
/// of their sizes: those that the sightings suggest, and those that show in a solution alone.
void AddTimeMistakes(const Facts& facts, Hypotheses* out);

}  // namespace sarblock
