// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "accuracy.h"
#include "charts.h"

namespace sarblock {

/// The map of a result and what its caption says of it. Points are coloured from the 2nd to the
/// 98th percentile of the points that are not control; ellipses belong to these points too, since
/// those of points held at their control coordinates say nothing of the block.
struct BlockMap {
  MapChart chart;
  std::size_t placed = 0;   ///< points with a position; 0: there is no map
  std::size_t sampled = 0;  ///< of these, in the chart
  std::size_t passes = 0;   ///< of the chart
};
[[nodiscard]] BlockMap MapOf(const ResultFolder& result, const AccuracyFigures& accuracy);

}  // namespace sarblock
