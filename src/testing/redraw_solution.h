// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstdint>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// What the looks of a solved block would read without noise.
struct ExactReadings {
  // By look in use:
  std::vector<double> range_m;        ///< the range equation's solution
  std::vector<double> azimuth;        ///< the cone equation's: time [s] or measured Doppler [Hz]
  std::vector<double> azimuth_sigma;  ///< of that
};

/// Readings of the solution `state`: points, corrected paths and biases as estimated. Throws
/// InputError where the time of a look leaves its path.
[[nodiscard]] ExactReadings ReadExactly(const AdjustmentProblem& problem, const BlockState& state);

/// A draw of everything that an adjustment takes for random, about a solution: the looks' ranges
/// and times or Dopplers, the control coordinates and the priors' values. `block` is a copy of
/// problem.block. One stream of random numbers a look, a control point and a parameter: a function
/// of seed and run.
void RedrawSolution(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const ExactReadings& exact,
                    std::uint64_t seed,
                    std::uint64_t run,
                    Block* block,
                    std::vector<double>* prior_values);

}  // namespace sarblock
