// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <string>
#include <vector>

namespace sarblock::cli {

/// The result in about twenty lines for people: verdict, counts, global test, sigmas, check points,
/// largest corrections, warnings.
[[nodiscard]] std::string DescribeResult(const Block& block,
                                         const AdjustOptions& options,
                                         const AdjustResult& result);

/// "looks per point: 16 with none, 67 with 2", from the number of points with k looks.
[[nodiscard]] std::string DescribeLooksPerPoint(const std::vector<std::size_t>& points_by_looks);

/// Contents of a block: passes, points by role, looks, looks per point, what will not work.
[[nodiscard]] std::string DescribeBlock(const Block& block);

/// Variance components and Monte Carlo runs of a result for people, where it has some.
[[nodiscard]] std::string DescribeVarianceComponents(const AdjustResult& result);
[[nodiscard]] std::string DescribeMonteCarlo(const AdjustResult& result);

}  // namespace sarblock::cli
