// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// The simplifications in the order of the report.
enum SimplificationKind : std::size_t {
  kFlatFrame,
  kFixedTrackAxes,
  kLinearVelocity,
  kSimplificationKinds
};
inline constexpr std::array<const char*, kSimplificationKinds> kSimplificationNames{
    "flat-frame", "fixed-track-axes", "linear-velocity"};

/// A model without one part.
[[nodiscard]] Simplified OnlySimplified(std::size_t kind, const Eigen::Vector3d& middle_m);

/// Mean of the solved points.
[[nodiscard]] Eigen::Vector3d MiddleOfPoints(const AdjustmentProblem& problem,
                                             const BlockState& state);

/// Bounds of the effect of four simplifications of the model on the points of a block at a solution
/// (docs/theory/selection.md, eqs. 9 to 12), flight paths fixed. If the errors of the equations of
/// look i change by delta_i, in metres, no direction u of a point moves by more than
///
///     |u'dp| <= sigma_u sqrt( sum over looks |W_i delta_i|^2 ),      W_i the weights
///
/// because dp = A^+ W delta and the rows of A^+ have the length of the standard deviations
/// (Cauchy and Schwarz); standard deviations of the whole adjustment are not smaller. delta_i is
/// the difference of the model with and without the simplification, not a formula of its own.
/// `limit` is the part of a standard deviation up to which one is allowed. `problem` may be
/// simplified itself; the comparison is with the full model. Empty where no point is solved.
[[nodiscard]] std::vector<SimplificationBound> BoundSimplifications(
    const AdjustmentProblem& problem, const BlockState& state, double limit);

/// Chooses among the allowed simplifications those that are worth taking: those that save at least
/// kMinGain of the evaluation by LookModel::WorkOf (counts, so that a block has the same result on
/// every machine), the most first, while the sum of their parts stays within the limit. Fills gain,
/// `taken` and verdict of `bounds`; the gains are measured.
inline constexpr double kMinGain = 0.05;
[[nodiscard]] Simplified ChooseSimplified(const AdjustmentProblem& problem,
                                          const BlockState& state,
                                          double limit,
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
