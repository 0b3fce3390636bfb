// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/geometry/intersection.h"

#include "model/problem.h"

namespace sarblock {

/// Start positions for all points (model.md, section 5), corrections at zero: the given coordinates
/// of a point where the files have some; else the exact intersection of its looks (a compromise
/// where flight-path errors keep the circles apart); else, with one look and a known height, the
/// look's circle at that height. A point that cannot be started is left out of `problem` with its
/// reason; so is one that has neither two looks nor control. Looks at which the model has no value
/// at the start are left out and counted. Forms the weights at the start. Throws InputError for a
/// pass whose states are too rough to be read. `max_steps`: most steps for a point whose circles
/// lie far apart; it starts where these steps end. Parallel over points.
struct StartReport {
  BlockState state;
  std::vector<std::size_t> looks_not_evaluated;  ///< look indices, ascending
};
[[nodiscard]] StartReport ComputeStartValues(AdjustmentProblem* problem,
                                             ProgressSink* progress,
                                             int max_steps = IntersectionOptions{}.max_iterations);

/// Passes that lost more than a third of their looks to a consensus may have diverged as a whole.
/// Each is resected anew from the points that other passes determine, fixed: its corrections start
/// from their priors and follow a loss whose scale shrinks from the residuals there. The new
/// corrections are taken where its looks then fit twice as well, in the median. Corrections that
/// passes share stay. True if any pass was moved.
[[nodiscard]] bool RelocatePasses(const AdjustmentProblem& problem, BlockState* state);

}  // namespace sarblock
