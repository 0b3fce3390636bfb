// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// One place of a flight path within its strip: where the antenna is, what it sees, and how the
/// adjustment corrected it there.
struct StripStation {
  std::uint32_t pass = 0;
  double time_s = 0.0;
  double strip_time_1 = 0.0;  ///< strip-normalised time, -1 to 1 (docs/theory/flight_path.md)
  Eigen::Vector3d antenna_m = Eigen::Vector3d::Zero();  ///< nominal path, frame axes
  /// Ground at the nearest and farthest range of the pass's looks, at the median height of its
  /// points; NaN without looks or where the range does not reach that height.
  Eigen::Vector3d near_m = Eigen::Vector3d::Constant(kNotGiven);
  Eigen::Vector3d far_m = Eigen::Vector3d::Constant(kNotGiven);
  /// Position correction delta(t) along, across and up and its standard deviations (not scaled);
  /// NaN where the pass has no position correction, sigmas also where they were not computed.
  Eigen::Vector3d correction_m = Eigen::Vector3d::Constant(kNotGiven);
  Eigen::Vector3d correction_sigma_m = Eigen::Vector3d::Constant(kNotGiven);
};

/// Stations at equal steps from start to end of every strip: kStripStations of them, where a spline
/// has more pieces up to four a piece, at most kMostStripStations. `groups` are the correction
/// groups that the result was made with. The standard deviation is that of the linear function of
/// the parameters, sqrt(g C g'), from the covariances in the result; the cone of the swath's edges
/// is that of the look in the middle of the strip.
inline constexpr std::size_t kStripStations = 13;
inline constexpr std::size_t kMostStripStations = 201;
[[nodiscard]] std::vector<StripStation> SampleStrips(const Block& block,
                                                     const std::vector<CorrectionGroup>& groups,
                                                     const AdjustResult& result);

}  // namespace sarblock
