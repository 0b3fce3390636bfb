// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "model/problem.h"
#include <ceres/problem.h>

namespace sarblock {

/// Newton steps of a Ceres problem without loss that is all but solved. Ceres takes a step where
/// the cost falls, and the cost cannot show a step below the root of its own rounding: residuals of
/// one sigma with an error of 1e-10 m in ranges of 1e6 m leave 1e-5 sigma. The gradient can. Takes
/// whole steps from Ceres' Jacobian (its normal equations, sparse LDL') while they shrink and more
/// than a share of `settled` sigmas is left, three at most, and none where the first is above
/// kLongestFinish_1 sigmas or the equations are singular. None either beyond kMostFinished points,
/// whose equations of all unknowns would take 13 GB at a million: an adjustment finishes them on
/// the reduced ones.
inline constexpr double kLongestFinish_1 = 1e-2;
inline constexpr std::size_t kMostFinished = 200000;
void FinishByNewton(const AdjustmentProblem& problem,
                    int threads,
                    double settled_1,
                    ceres::Problem* ceres_problem,
                    BlockState* state);

}  // namespace sarblock
