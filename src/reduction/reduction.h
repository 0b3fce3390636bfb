// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

#include "core/utc.h"
#include <Eigen/Core>

namespace sarblock {

/// What raises tides at an instant: the same for all points. Some tens of microseconds to make, a
/// displacement takes one. The tide moves by up to 2e-5 m a second.
struct TidalBodies {
  std::array<Eigen::Vector3d, 2> positions_m;  ///< of Moon and Sun, Earth-fixed
  double sidereal_rad = 0.0;                   ///< Greenwich mean sidereal time
  std::array<double, 5> delaunay_rad{};        ///< l, l', F, D, Omega
};

/// Throws InputError ("utc") before 1972 and after 2034, and for a text that is no time in UTC.
[[nodiscard]] TidalBodies TidalBodiesAt(const UtcTime& time);
[[nodiscard]] TidalBodies TidalBodiesAt(std::string_view utc);

/// Displacement of a point with that position, both in Earth-fixed axes [m].
[[nodiscard]] Eigen::Vector3d SolidEarthTide_m(const TidalBodies& bodies,
                                               const Eigen::Vector3d& position_m);

}  // namespace sarblock
