// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "charts.h"
#include "headline.h"

namespace sarblock {

/// A box of the map plane.
struct MapBox {
  std::array<double, 2> low_m{kAbsent, kAbsent}, high_m{kAbsent, kAbsent};
  void Add(const std::array<double, 2>& place_m);
  /// With a margin on all sides.
  [[nodiscard]] MapBox Widened(double margin_m) const;
};

/// Meridians and parallels of round degrees across the box `drawn`, so close that three to eight of
/// each cross the box `seen` in it (meridians 30 degrees apart where they meet in it), named
/// "45.5° N"; places in metres. Drawn at the height of the plane's origin. None in a local frame.
[[nodiscard]] std::vector<MapChart::Line> GraticuleOf(const Frame& frame,
                                                      const MapPlane& plane,
                                                      const MapBox& seen,
                                                      const MapBox& drawn);

/// The map of a result and its caption. Points are coloured from the 2nd to the
/// 98th percentile of the points that are not control; ellipses belong to these points too, since
/// those of points fixed at their control coordinates say nothing about the block.
struct BlockMap {
  MapChart chart;
  std::size_t placed = 0;   ///< points with a position; 0: there is no map
  std::size_t sampled = 0;  ///< of these, in the chart
  std::size_t passes = 0;   ///< of the chart
};
[[nodiscard]] BlockMap MapOf(const ResultFolder& result, const AccuracyFigures& accuracy);

}  // namespace sarblock
