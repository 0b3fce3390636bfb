// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/intersection.h"

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace sarblock::testing_scene {

/// How an antenna looks at a point: everything except the point itself.
struct View {
  double heading_rad = 0.0;  ///< of the flight direction, from x (local) or east towards north
  double climb_rad = 0.0;
  double look_rad = 0.6;  ///< off nadir, in the plane normal to the flight direction
  double squint_rad = 0.0;
  double range_m = 10e3;
  double speed_mps = 173.0;
  int side = +1;
};

/// The sight that sees `p` exactly: built backwards from p by axes at p (`enu` rows east, north,
/// up), independently of the code under test.
inline Sight SightOf(const Eigen::Vector3d& p_m,
                     const View& view,
                     const Eigen::Matrix3d& enu = Eigen::Matrix3d::Identity()) {
  const Eigen::Vector3d u =
      enu.transpose() * Eigen::Vector3d(std::cos(view.climb_rad) * std::cos(view.heading_rad),
                                        std::cos(view.climb_rad) * std::sin(view.heading_rad),
                                        std::sin(view.climb_rad));
  const Eigen::Vector3d up = enu.row(2).transpose();
  const Eigen::Vector3d across = up.cross(u).normalized();
  const Eigen::Vector3d down = -u.cross(across);
  const Eigen::Vector3d to_point =
      std::sin(view.squint_rad) * u +
      std::cos(view.squint_rad) *
          (view.side * std::sin(view.look_rad) * across + std::cos(view.look_rad) * down);
  Sight sight;
  sight.antenna_m = p_m - view.range_m * to_point;
  sight.velocity_mps = view.speed_mps * u;
  sight.range_m = (p_m - sight.antenna_m).norm();
  sight.cone.squint_rad = view.squint_rad;
  sight.side = view.side;
  return sight;
}

/// The paper's station (x, y, H) flying along +x, with a slant range given by hand.
inline Sight Station(double x_m, double y_m, double height_m, double range_m, int side) {
  Sight sight;
  sight.antenna_m = {x_m, y_m, height_m};
  sight.velocity_mps = {181.0, 0.0, 0.0};
  sight.range_m = range_m;
  sight.side = side;
  return sight;
}

}  // namespace sarblock::testing_scene
