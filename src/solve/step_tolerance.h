// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "model/problem.h"

namespace sarblock {

/// The part of a tolerance that a small block gets: few unknowns share what is left among them, and
/// one step more costs nothing. A hundredth up to 10 points, all of it from 1000 on.
[[nodiscard]] double ShareOf(double tolerance_1, const AdjustmentProblem& problem);

}  // namespace sarblock
