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
inline FixedPathLook FixPath(const Eigen::Vector3d& p_m,
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
  FixedPathLook observation;
  observation.antenna_m = p_m - view.range_m * to_point;
  observation.velocity_mps = view.speed_mps * u;
  observation.range_m = (p_m - observation.antenna_m).norm();
  observation.cone.squint_rad = view.squint_rad;
  observation.side = view.side;
  return observation;
}

/// The paper's station (x, y, H) flying along +x, with a slant range given by hand.
inline FixedPathLook Station(double x_m, double y_m, double height_m, double range_m, int side) {
  FixedPathLook observation;
  observation.antenna_m = {x_m, y_m, height_m};
  observation.velocity_mps = {181.0, 0.0, 0.0};
  observation.range_m = range_m;
  observation.side = side;
  return observation;
}

}  // namespace sarblock::testing_scene
