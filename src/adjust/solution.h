// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/adjust.h"
#include "sarblock/adjust/problem.h"
#include "sarblock/adjust/reduced_system.h"

#include <optional>
#include <string>

namespace sarblock {

/// Steps that adjustment, prediction and intersection share: from a problem at its final state to
/// the result.

/// True where p lies on the side the antenna looks to and below it: a mirror solution does not.
[[nodiscard]] bool LiesWhereItLooks(const Frame& frame,
                                    const Sight& sight,
                                    const Eigen::Vector3d& p_m);

/// Throws UndeterminedError unless something can be solved at all.
void RequireSolvable(const AdjustmentProblem& problem);
/// Forms the reduced system at a state, leaving out the points whose own equations turn out rank
/// deficient, with their reason.
void FormDetermined(const BlockState& state,
                    const Weighting& weighting,
                    AdjustmentProblem* problem,
                    std::optional<ReducedSystem>* system,
                    ProgressSink* progress);
/// Refuses options that this build does not offer, by name.
void RequireOffered(const AdjustOptions& options);
/// Refuses a block too large for the method asked for (ceres_covariance.h).
void RequireCovarianceMethod(const AdjustmentProblem& problem, const AdjustOptions& options);

void Warn(AdjustResult* result, const std::string& text);

/// The last step of all three: counts, global test, points, residuals (unless there already), check
/// points, rejected looks, warnings of points left out. `square_sum_1` is v'Pv,
/// NaN for a prediction, which has no residuals.
void FinishResult(const AdjustmentProblem& problem,
                  const BlockState& state,
                  const AdjustOptions& options,
                  double square_sum_1,
                  AdjustResult* result);
/// Positions, status, counts of looks and angles.
void FillPoints(const AdjustmentProblem& problem, const BlockState& state, AdjustResult* result);
/// e_r and e_d of every look of a solved point.
void FillResiduals(const AdjustmentProblem& problem,
                   const BlockState& state,
                   const Weighting& weighting,
                   AdjustResult* result);
/// Values, sigmas, covariance of points, corrections and pairs at options.covariance.
void FillCovariance(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const ReducedSystem& system,
                    const AdjustOptions& options,
                    const PointPairs& pairs,
                    ProgressSink* progress,
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
/// Errors of check points against their known positions.
void FillChecks(const Block& block, AdjustResult* result);

}  // namespace sarblock
