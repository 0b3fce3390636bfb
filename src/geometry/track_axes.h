// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/path.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

enum class TrackAxis { kAlong = 0, kAcross = 1, kUp = 2 };
inline constexpr std::array<const char*, 3> kTrackAxisNames = {"along", "across", "up"};
inline constexpr std::array<const char*, 3> kFrameAxisNames = {"x", "y", "z"};

/// Track axes at one time and how they turn. Columns along, across, up, each a unit vector in
/// frame axes: along = v/|v|; up = the local vertical made orthogonal to along;
/// across = up x along (model.md, section 2). In Leberl's frame they are x, y and z.
struct TrackAxes {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d rate = Eigen::Matrix3d::Zero();          ///< d axes / dt [1/s]
  Eigen::Matrix3d acceleration = Eigen::Matrix3d::Zero();  ///< d2 axes / dt2 [1/s2]

  /// The axes a time later, to second order.
  [[nodiscard]] TrackAxes After(double time_s) const {
    return {axes + time_s * (rate + (0.5 * time_s) * acceleration),
            rate + time_s * acceleration,
            acceleration};
  }
};

/// Axes of the path through `motion`. Domain: velocity not zero and not vertical (sine of the
/// angle to the vertical above 1e-6); outside the axes are NaN.
[[nodiscard]] TrackAxes TrackAxesOf(const Frame& frame, const Motion& motion);

/// The same with the vertical along the path given, as by VerticalTable.
[[nodiscard]] TrackAxes TrackAxesOf(const VerticalMotion& vertical, const Motion& motion);

/// The vertical along a flight path as a function of time, tabulated: a look of an orbit needs it
/// at its time, and the conversion of its position to geodetic coordinates costs more than the rest
/// of its equations.
///
/// Cubic Hermite interpolation of the unit vector and its rate between knots so near that the
/// vertical turns by at most kMaxTurn_rad; every piece of the path has knots of its own, so that a
/// recorded path is followed as it is. Error at most kMaxTurn_rad^4 / 384 = 2.1e-13 rad in
/// direction (docs/theory/flight_path.md, eq. (13a)). Beyond the ends of the path the first or last
/// polynomial is continued. In a `local` frame the vertical is constant and nothing is stored;
/// otherwise 96 bytes a knot.
class VerticalTable {
 public:
  static constexpr double kMaxTurn_rad = 3e-3;

  VerticalTable() = default;
  VerticalTable(const Frame& frame, const FlightPath& path);

  /// Vertical, rate and acceleration at a time; `piece` is that of FlightPath::Read.
  [[nodiscard]] VerticalMotion At(std::size_t piece, double time_s) const;

 private:
  /// Between two knots, by the time since the first.
  struct Polynomial {
    Eigen::Vector3d up, rate, second, third;
  };
  /// Those of one piece of the path: `first` to `first + steps`, equally long.
  struct Piece {
    double start_s = 0.0, step_s = 0.0, inverse_per_s = 0.0;
    std::uint32_t first = 0, steps = 0;
  };
  std::vector<Piece> pieces_;  // empty: constant
  std::vector<Polynomial> polynomials_;
};

}  // namespace sarblock
