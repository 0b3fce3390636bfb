// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include "model/problem.h"
#include "normals/point.h"
#include "solve/point_defects.h"

namespace sarblock {

/// Steps that adjustment, prediction and intersection share: from a problem at its final state to
/// the result.

/// v'Pv of the looks in use, and what of it good looks that were left out may have taken.
struct SquareSum {
  double kept_1 = kNotGiven;
  double left_out_1 = 0.0;
};

/// The last step of all three: counts, global test, points, residuals (unless there already), check
/// points, rejected looks, warnings of points left out.
/// `square_sum` is NaN for a prediction, which has no residuals.
void FinishResult(const AdjustmentProblem& problem,
                  const BlockState& state,
                  const AdjustOptions& options,
                  const SquareSum& square_sum,
                  const PointDefects& defects,
                  AdjustResult* result);
/// Positions, status, counts of looks and angles.
void FillPoints(const AdjustmentProblem& problem, const BlockState& state, AdjustResult* result);
/// e_r and e_d of every look of a solved point; of rejected looks too, which shows how far off they
/// are.
void FillResiduals(const AdjustmentProblem& problem, const BlockState& state, AdjustResult* result);
/// The weight that a loss gives each look in use, 0 where it is not in use.
void FillLossWeights(const AdjustmentProblem& problem,
                     const BlockState& state,
                     const Weighting& weighting,
                     AdjustResult* result);
void FillParameters(const AdjustmentProblem& problem,
                    const BlockState& state,
                    AdjustResult* result);
/// Corrected paths: states at the nominal times less the time bias, so that reading them at the
/// measured times gives the path the adjustment used; more states where a spline or a polynomial of
/// a high degree needs them.
void FillCorrectedPaths(const AdjustmentProblem& problem,
                        const BlockState& state,
                        AdjustResult* result);

}  // namespace sarblock
