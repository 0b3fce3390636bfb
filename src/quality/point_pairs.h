// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <vector>

#include "model/problem.h"
#include <Eigen/Core>

namespace sarblock {

/// Each solved point with its nearest solved neighbour, each pair once, ascending.
[[nodiscard]] PointPairs NeighbourPairs(const AdjustmentProblem& problem, const BlockState& state);

/// All pairs of solved points; throws InputError above `most` pairs.
[[nodiscard]] PointPairs AllPairs(const AdjustmentProblem& problem, std::size_t most = 2000000);

/// Pairs along and across the track of the first pass at its middle, eight distances each: 0.7 of
/// the extent of the solved points and halves of it, down to where none are found. At most 32 of a
/// distance, their second point within a quarter of the distance of where it should be; a sample
/// that depends on the block alone.
[[nodiscard]] PointPairs DistancePairs(const AdjustmentProblem& problem, const BlockState& state);

/// Variances along, across and up [m^2] of a covariance, by a level unit direction (east, north).
[[nodiscard]] std::array<double, 3> AlongAcrossUp(const SymmetricEnu& covariance_m2,
                                                  const Eigen::Vector2d& along);

/// The pairs of a result by direction and distance. A pair within 20 degrees of a direction is one
/// of it; of a distance are those within a factor of sqrt(2) of the longest pair's over a power of
/// two; distances of fewer than four pairs are left out. Without covariances empty.
[[nodiscard]] std::vector<DifferenceClass> SummariseDifferences(const Block& block,
                                                                const AdjustResult& result);

}  // namespace sarblock
