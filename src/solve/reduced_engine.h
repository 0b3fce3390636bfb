// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include "model/problem.h"
#include "normals/point.h"
#include "normals/reduced_system.h"
#include "solve_report.h"

namespace sarblock {

/// Levenberg-Marquardt on the reduced normal equations (ReducedSystem), without Ceres' objects: per
/// iteration one pass over the points that forms S and one that substitutes back. Jacobians are
/// recomputed, not stored; memory beyond the block is 24 bytes a point and S.
///
/// Damping (Marquardt 1963): lambda times the diagonal of J'J on every unknown, a tenth after a
/// step that lowers the cost, tenfold after one that does not. Ends when the step that is left is
/// below options.settled_1 sigmas over all unknowns together, or below what the rounding of the
/// cost can tell. The solution is that of SolveWithCeres to a small part of a sigma. Updates
/// `state`. Throws Interrupted if the sink was cancelled.
[[nodiscard]] SolveReport SolveReduced(const AdjustmentProblem& problem,
                                       const Weighting& weighting,
                                       const SolveOptions& options,
                                       BlockState* state,
                                       ProgressSink* progress);

/// The same on a system of the problem that the caller keeps: its pattern is found once.
[[nodiscard]] SolveReport SolveReduced(const AdjustmentProblem& problem,
                                       const Weighting& weighting,
                                       const SolveOptions& options,
                                       ReducedSystem* system,
                                       BlockState* state,
                                       ProgressSink* progress);

/// The state after the whole Gauss-Newton step that belongs to the corrections' step `dx`, nothing
/// damped: every point follows with what its own equations leave of it. Looks without loss.
[[nodiscard]] BlockState AfterNewtonStep(const AdjustmentProblem& problem,
                                         const BlockState& state,
                                         const Eigen::VectorXd& dx);

}  // namespace sarblock
