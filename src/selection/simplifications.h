// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// Bounds of what four simplifications of the model would do to the points of a block at a solution
/// (docs/theory/selection.md, eqs. 9 to 12), flight paths held. With the errors of the equations of
/// look i changed by delta_i, in metres, no direction u of a point moves by more than
///
///     |u'dp| <= sigma_u sqrt( sum over looks |W_i delta_i|^2 ),      W_i the weights
///
/// because dp = A^+ W delta and the rows of A^+ have the length of the standard deviations
/// (Cauchy and Schwarz); standard deviations of the whole adjustment are not smaller. delta_i is
/// the difference of the model with and without the simplification, not a formula of its own.
/// `limit_1` is the part of a standard deviation up to which one is allowed. `problem` may be
/// simplified itself; the comparison is with the full model. Empty where no point is solved.
[[nodiscard]] std::vector<SimplificationBound> BoundSimplifications(
    const AdjustmentProblem& problem, const BlockState& state, double limit_1);

}  // namespace sarblock
