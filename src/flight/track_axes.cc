// SPDX-License-Identifier: Apache-2.0
#include "track_axes.h"

#include <limits>

#include <Eigen/Geometry>

namespace sarblock {
namespace {

using Eigen::Vector3d;

// A vector that moves, with its first two time derivatives.
struct Moving {
  Vector3d value, first, second;
};

// v/|v|. With n = |v| and u = v/n: n' = u.v', u' = (v' - u n')/n, n'' = u'.v' + u.v'' and
// u'' = (v'' - u n'' - 2 u' n')/n. One division: a look takes this many times, and a division is
// twenty products.
Moving Normalised(const Moving& v) {
  const double inverse = 1.0 / v.value.norm();
  Moving u;
  u.value = v.value * inverse;
  const double n1 = u.value.dot(v.first);
  u.first = (v.first - u.value * n1) * inverse;
  const double n2 = u.first.dot(v.first) + u.value.dot(v.second);
  u.second = (v.second - u.value * n2 - 2.0 * n1 * u.first) * inverse;
  return u;
}

// z - u (u.z), the part of z at right angles to the unit vector u.
Moving Rejected(const Moving& z, const Moving& u) {
  const double c = u.value.dot(z.value);
  const double c1 = u.first.dot(z.value) + u.value.dot(z.first);
  const double c2 = u.second.dot(z.value) + 2.0 * u.first.dot(z.first) + u.value.dot(z.second);
  return {z.value - c * u.value,
          z.first - c1 * u.value - c * u.first,
          z.second - c2 * u.value - 2.0 * c1 * u.first - c * u.second};
}

Moving Cross(const Moving& a, const Moving& b) {
  return {a.value.cross(b.value),
          a.first.cross(b.value) + a.value.cross(b.first),
          a.second.cross(b.value) + 2.0 * a.first.cross(b.first) + a.value.cross(b.second)};
}

TrackAxes Undefined() {
  const Eigen::Matrix3d nan = Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());
  return {.axes_1 = nan, .rate = nan, .acceleration = nan};
}

}  // namespace

TrackAxes TrackAxesOf(const VerticalMotion& vertical, const Motion& motion) {
  constexpr double kSmallestSine_1 = 1e-6;
  if (!(motion.velocity_mps.squaredNorm() > 0.0)) return Undefined();
  const Moving along =
      Normalised({motion.velocity_mps, motion.acceleration_mps2, motion.jerk_mps3});
  const Moving upright = Rejected({vertical.up_1, vertical.rate, vertical.acceleration}, along);
  if (!(upright.value.squaredNorm() > kSmallestSine_1 * kSmallestSine_1)) return Undefined();
  const Moving up = Normalised(upright);
  const Moving across = Cross(up, along);
  TrackAxes axes;
  axes.axes_1 << along.value, across.value, up.value;
  axes.rate << along.first, across.first, up.first;
  axes.acceleration << along.second, across.second, up.second;
  return axes;
}

TrackAxes TrackAxesOf(const Frame& frame, const Motion& motion) {
  return TrackAxesOf(
      frame.VerticalAlong(motion.position_m, motion.velocity_mps, motion.acceleration_mps2),
      motion);
}

}  // namespace sarblock
