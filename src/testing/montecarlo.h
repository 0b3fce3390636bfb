// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <vector>

#include "model/problem.h"

namespace sarblock {

/// Repeats the adjustment of a solved block options.montecarlo_runs times (or those of them that
/// options.montecarlo_part holds), each with noise drawn anew about the solution (RedrawSolution)
/// and started from it, and compares the errors with the rigorous covariance `covariance_m2`, by
/// point in east, north, up. Same weights, looks and groups as the solution's, by least squares;
/// blunders are not simulated. Runs are parallel; what a run adds depends neither on the number of
/// threads nor on the other runs. docs/theory/montecarlo.md.
[[nodiscard]] MonteCarloDraws DrawMonteCarlo(const AdjustmentProblem& problem,
                                             const BlockState& state,
                                             const AdjustOptions& options,
                                             const std::vector<SymmetricEnu>& covariance_m2,
                                             ProgressSink* progress);

}  // namespace sarblock
