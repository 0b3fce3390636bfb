// SPDX-License-Identifier: Apache-2.0
#include "look_side.h"

#include <Eigen/Geometry>

namespace sarblock {

bool LiesWhereItLooks(const Frame& frame, const Sight& sight, const Eigen::Vector3d& p_m) {
  // The signs of the track components of d (model.md, section 2) need no axes of unit length.
  const Eigen::Vector3d up_1 = frame.VerticalAt(sight.antenna_m).up_1;
  const Eigen::Vector3d& v = sight.velocity_mps;
  const Eigen::Vector3d d = p_m - sight.antenna_m;
  const double across = up_1.cross(v).dot(d) * sight.side;
  const double up = up_1.dot(d) * v.squaredNorm() - up_1.dot(v) * v.dot(d);
  return across > 0.0 && up < 0.0;
}

}  // namespace sarblock
