// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/flight/path.h"
#include "sarblock/geodesy/frame.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// The vertical along a flight path as a function of time, tabulated: a look of an orbit needs it
/// at its time, and the conversion of its position to geodetic coordinates costs more than the rest
/// of its equations.
///
/// Cubic Hermite interpolation of the unit vector and its rate between knots so near that the
/// vertical turns by at most kMostTurn_rad; every piece of the path has knots of its own, so that a
/// recorded path is followed as it is. Error at most kMostTurn_rad^4 / 384 = 2.1e-13 rad in
/// direction (docs/theory/flight_path.md, eq. (13a)). Beyond the ends of the path the first or last
/// polynomial is continued. In a `local` frame the vertical is constant and nothing is stored;
/// otherwise 96 bytes a knot.
class VerticalTable {
 public:
  static constexpr double kMostTurn_rad = 3e-3;

  VerticalTable() = default;
  VerticalTable(const Frame& frame, const FlightPath& path);

  /// Vertical, rate and acceleration at a time; `piece` is that of FlightPath::Read.
  [[nodiscard]] VerticalMotion At(std::size_t piece, double time_s) const;

 private:
  /// Between two knots, by the time since the first.
  struct Polynomial {
    Eigen::Vector3d up_1, rate, second, third;
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
