// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <memory>
#include <vector>

#include "model/problem.h"
#include "normals/point.h"
#include "reduced_engine.h"
#include <ceres/evaluation_callback.h>
#include <ceres/problem.h>

namespace sarblock {

/// Memory of the unknowns of a Ceres problem. ceres::Covariance orders them, and so its sums, by
/// address: with two separate arrays the order would be arbitrary, and with it the last digits.
struct CeresUnknowns {
  double* displacements_m = nullptr;  ///< three per point, of all points
  double* corrections = nullptr;
  /// Called by Ceres before it evaluates; null: none. Must outlive the problem.
  ceres::EvaluationCallback* before_evaluation = nullptr;
};

/// The whole adjustment as a Ceres problem over `unknowns`: one block per solved point (its
/// displacement) and one per parameter block. `state` gives the start positions alone.
[[nodiscard]] std::unique_ptr<ceres::Problem> MakeCeresProblem(const AdjustmentProblem& problem,
                                                               const Weighting& weighting,
                                                               const BlockState& state,
                                                               const CeresUnknowns& unknowns);

/// The same over the memory of `state`. Used by SolveWithCeres and by the tests that compare
/// covariances with ceres::Covariance.
[[nodiscard]] std::unique_ptr<ceres::Problem> MakeCeresProblem(const AdjustmentProblem& problem,
                                                               const Weighting& weighting,
                                                               BlockState* state);

/// Levenberg-Marquardt by Ceres, points eliminated first; points follow each trial step of the
/// corrections (SettlePoint), which moves their starts. Ends after a step well below
/// options.settle_below; rounding of the cost hides the last digits (NewtonFinish). Under a robust
/// loss, whose last steps shrink slowly, it ends where the cost changes by less than 1e-9 of
/// itself. Without corrections there is nothing to reduce: sparse normal equations, for any
/// options.ceres_solver. Updates `state`. Throws Interrupted if the sink was cancelled.
[[nodiscard]] SolveReport SolveWithCeres(const AdjustmentProblem& problem,
                                         const Weighting& weighting,
                                         const SolveOptions& options,
                                         BlockState* state,
                                         ProgressSink* progress);

}  // namespace sarblock
