// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstdint>
#include <vector>

#include "model/problem.h"

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

}  // namespace sarblock
