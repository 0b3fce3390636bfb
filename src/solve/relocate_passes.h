// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "model/problem.h"

namespace sarblock {

/// Passes that lost more than a third of their looks to a consensus may have been led away as a
/// whole. Each is resected anew from the points that other passes determine, held: its corrections
/// start from their priors and follow a loss whose scale shrinks from the residuals there. They are
/// taken where its looks fit twice as well then, in the median. Corrections that passes share stay.
/// True if any pass was moved.
[[nodiscard]] bool RelocatePasses(const AdjustmentProblem& problem, BlockState* state);

}  // namespace sarblock
