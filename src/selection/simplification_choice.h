// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/result.h"

#include <vector>

#include "model/problem.h"

namespace sarblock {

/// Which of the allowed ones a model is worth taking: those that save at least kLeastGain_1 of the
/// evaluation by LookModel::WorkOf (counts, so that a block has the same result on every machine),
/// the most first, while the sum of their parts stays within the limit. Fills gain, `taken` and
/// verdict of `bounds`; the gains are measured.
inline constexpr double kLeastGain_1 = 0.05;
[[nodiscard]] Simplified ChooseSimplified(const AdjustmentProblem& problem,
                                          const BlockState& state,
                                          double limit_1,
                                          std::vector<SimplificationBound>* bounds);

/// CPU time of evaluating looks with the full model over that with a simplified one: a sample of up
/// to some ten thousand looks, the least of several repetitions. Measured, so not repeatable.
[[nodiscard]] double MeasureGain(const AdjustmentProblem& problem,
                                 const BlockState& state,
                                 const Simplified& simplified);

/// By how much the full model would move a point of a simplified solution, the largest of all
/// points and directions in standard deviations: its Gauss-Newton step there, corrections and all,
/// less that of the simplified model (which a robust loss leaves). Exact to first order.
/// `covariance_m2` is that of the points; where it is empty, the length of the step over all
/// unknowns together, which is not smaller. Infinite where the full model has no step.
[[nodiscard]] double ShiftToFullModel(const AdjustmentProblem& problem,
                                      const BlockState& state,
                                      const std::vector<SymmetricEnu>& covariance_m2,
                                      ProgressSink* progress = nullptr);

}  // namespace sarblock
