// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/elimination.h"
#include "sarblock/adjust/montecarlo_result.h"
#include "sarblock/adjust/options.h"
#include "sarblock/adjust/problem.h"
#include "sarblock/adjust/result.h"
#include "sarblock/core/progress.h"

#include <cstdint>
#include <vector>

namespace sarblock {

/// What the looks of a solved block would read without noise.
struct ExactReadings {
  std::vector<double> time_s;        ///< by look in use: the cone equation's solution
  std::vector<double> range_m;       ///< by look in use: the range equation's
  std::vector<double> time_sigma_s;  ///< by look in use: of the azimuth time
};

/// Readings of the solution `state`: points, corrected paths and biases as estimated. Throws
/// InputError where the time of a look leaves its path.
[[nodiscard]] ExactReadings ReadExactly(const AdjustmentProblem& problem, const BlockState& state);

/// A draw of everything that an adjustment takes for random, about a solution: the looks' times and
/// ranges, the control coordinates and the priors' values. `block` is a copy of problem.block. One
/// stream of random numbers a look, a control point and a parameter: a function of seed and run.
void RedrawSolution(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const ExactReadings& exact,
                    std::uint64_t seed,
                    std::uint64_t run,
                    Block* block,
                    std::vector<double>* prior_values);

/// Repeats the adjustment of a solved block options.montecarlo_runs times, each with noise drawn
/// anew about the solution (RedrawSolution) and started from it, and compares the errors with the
/// rigorous covariance `covariance_m2`, by point in east, north, up. Same weights, looks, groups
/// and loss as the solution's; blunders are not simulated. Runs are parallel; the result does not
/// depend on the number of threads. docs/theory/montecarlo.md.
[[nodiscard]] MonteCarloReport RunMonteCarlo(const AdjustmentProblem& problem,
                                             const BlockState& state,
                                             const Weighting& weighting,
                                             const AdjustOptions& options,
                                             const std::vector<SymmetricEnu>& covariance_m2,
                                             ProgressSink* progress);

}  // namespace sarblock
