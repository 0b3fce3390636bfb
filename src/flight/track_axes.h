// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/flight/path.h"
#include "sarblock/geodesy/frame.h"

#include <array>

#include <Eigen/Core>

namespace sarblock {

enum class TrackAxis { kAlong = 0, kAcross = 1, kUp = 2 };
inline constexpr std::array<const char*, 3> kTrackAxisNames = {"along", "across", "up"};
inline constexpr std::array<const char*, 3> kFrameAxisNames = {"x", "y", "z"};

/// Track axes at one time and how they turn. Columns along, across, up, each a unit vector in
/// frame axes: along = v/|v|; up = the local vertical made orthogonal to along;
/// across = up x along (model.md, section 2). In Leberl's frame they are x, y and z.
struct TrackAxes {
  Eigen::Matrix3d axes_1 = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d rate = Eigen::Matrix3d::Zero();          ///< d axes / dt [1/s]
  Eigen::Matrix3d acceleration = Eigen::Matrix3d::Zero();  ///< d2 axes / dt2 [1/s2]
};

/// Axes of the path through `motion`. Domain: velocity not zero and not vertical (sine of the
/// angle to the vertical above 1e-6); outside the axes are NaN.
[[nodiscard]] TrackAxes TrackAxesOf(const Frame& frame, const Motion& motion);

/// The same with the vertical along the path given, as by VerticalTable.
[[nodiscard]] TrackAxes TrackAxesOf(const VerticalMotion& vertical, const Motion& motion);

}  // namespace sarblock
