// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "model/problem.h"

namespace sarblock {

/// A tolerance for a block of so many points: few unknowns share what is left among them, and one
/// step more costs nothing. Scaled by points / 1000, within [0.01, 1].
[[nodiscard]] double ToleranceFor(double tolerance_1, const AdjustmentProblem& problem);

}  // namespace sarblock
