// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <vector>

#include "model/problem.h"
#include "normals/point.h"
#include "quality/verdict_tests.h"
#include "solve/weak_directions.h"

namespace sarblock {

/// Steps that adjustment, prediction and intersection share: from a problem at its final state to
/// the result.

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

/// Stations at equal steps from start to end of every strip: kStripStations of them, where a spline
/// has more pieces up to four per piece, at most kMaxStripStations. `groups` are the correction
/// groups that the result was made with. The standard deviation is that of the linear function of
/// the parameters, sqrt(g C g'), from the covariances in the result; the cone of the swath's edges
/// is that of the look in the middle of the strip.
inline constexpr std::size_t kStripStations = 13;
inline constexpr std::size_t kMaxStripStations = 201;
[[nodiscard]] std::vector<StripStation> SampleStrips(const Block& block,
                                                     const std::vector<CorrectionGroup>& groups,
                                                     const AdjustResult& result);

}  // namespace sarblock
