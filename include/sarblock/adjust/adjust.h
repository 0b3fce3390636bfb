// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/options.h"
#include "sarblock/adjust/problem.h"
#include "sarblock/adjust/result.h"
#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace sarblock {

/// Pairs of point indices, for coordinate differences.
using PointPairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Largest Newton step left, in sigmas over all unknowns together, that is still a solution.
inline constexpr double kRemainingStepAccepted_1 = 1e-3;
/// The same under a robust loss, whose kinks (Huber) or flat places (two looks that contradict each
/// other) let the last steps shrink slowly: far below what the loss itself costs in efficiency.
inline constexpr double kRemainingRobustStepAccepted_1 = 0.1;

/// The adjustment of a block (model.md, sections 5 to 7): start values, Levenberg-Marquardt,
/// acceptance, covariance, residuals, check points, global test.
///
/// Whitening depends (weakly) on the unknowns where azimuth is given in seconds or a look is
/// squinted; it is formed at the start, formed again at the solution and the solution repeated
/// until it no longer changes.
/// Under a robust loss the looks whose whitened length exceeds the 99.9 percent point of chi-square
/// with 2 degrees of freedom are dropped after the solution; v'Pv, redundancy and covariance are
/// those of the looks kept, without the loss.
/// Accepted means: every look has a value at the solution, the reduced matrix is regular, and the
/// Newton step that is left is below kRemainingStepAccepted_1 (kRemainingRobustStepAccepted_1 under
/// a loss).
///
/// `pairs` is used with options.pairs == kList. Throws UndeterminedError where the block as a whole
/// or its corrections are not determined, InputError for options that do not fit the block,
/// Interrupted. A point that is not determined is reported with its reason and left out.
[[nodiscard]] AdjustResult Adjust(const Block& block,
                                  const AdjustOptions& options,
                                  const PointPairs& pairs = {},
                                  ProgressSink* progress = nullptr);

/// Rigorous intersection of every point, flight paths held (corrections none): position,
/// covariance R^-1 R^-T and residuals of each point alone, control not used.
[[nodiscard]] AdjustResult IntersectBlock(const Block& block,
                                          const AdjustOptions& options,
                                          ProgressSink* progress = nullptr);

/// The covariance that an adjustment of this block would have, from geometry and weights alone.
/// `positions_m` are the points' positions (truth or approximate); a point without one is
/// intersected from its measurements if it has some. Looks without measured time or range get
/// those of the geometry; with `looks` empty every pass that sees a point on its look side within
/// its path takes a look.
[[nodiscard]] AdjustResult Predict(const Block& block,
                                   const AdjustOptions& options,
                                   const std::vector<Eigen::Vector3d>& positions_m,
                                   const PointPairs& pairs = {},
                                   ProgressSink* progress = nullptr);

/// Fills time and range of looks that have none from the geometry of known positions on the nominal
/// paths; adds all visible looks where the block has none at all. Looks and points that cannot be
/// filled are left out of the result's looks.
[[nodiscard]] Block FillMeasurements(const Block& block,
                                     const std::vector<Eigen::Vector3d>& positions_m);

}  // namespace sarblock
