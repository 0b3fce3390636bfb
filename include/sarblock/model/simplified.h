// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/path.h"

#include <Eigen/Core>

namespace sarblock {

/// Parts of the look equations that are left out because they move no point by an amount that
/// counts (simplifications.h; docs/theory/selection.md). Nothing is by default.
struct Simplified {
  bool flat_frame = false;        ///< delays see the tangent plane at `middle_m`, not the ellipsoid
  bool fixed_track_axes = false;  ///< the axes of a pass are those at the middle of its strip
  bool linear_velocity = false;   ///< a pass flies one straight line at constant velocity
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();  ///< of the points, frame axes
  [[nodiscard]] bool any() const { return flat_frame || fixed_track_axes || linear_velocity; }
};

/// The straight line of least squares through a pass's nominal path within its strip, continued
/// over the whole path. A path that is straight already, or hardly gets anywhere, is left as it is.
[[nodiscard]] FlightPath StraightenedPath(const Pass& pass);

/// Track axes of a nominal path at the middle of a pass's strip; NaN where it has none.
[[nodiscard]] Eigen::Matrix3d AxesInTheMiddle(const Frame& frame,
                                              const FlightPath& path,
                                              const Pass& pass);

}  // namespace sarblock
