// SPDX-License-Identifier: Apache-2.0
#include "sarblock/flight/track_axes.h"

#include <limits>

#include <Eigen/Geometry>

namespace sarblock {
namespace {

using Eigen::Vector3d;

// A vector that moves, with its first two time derivatives; kSecond: the second one is wanted.
template <bool kSecond>
struct Moving {
  Vector3d value;
  Vector3d first;
  Vector3d second;
};

// v/|v|. With n = |v| and u = v/n: n' = u.v', u' = (v' - u n')/n, n'' = u'.v' + u.v'' and
// u'' = (v'' - u n'' - 2 u' n')/n. One division: a look takes this many times, and a division is
// twenty products.
template <bool kSecond>
Moving<kSecond> Normalised(const Moving<kSecond>& v) {
  const double inverse = 1.0 / v.value.norm();
  Moving<kSecond> u;
  u.value = v.value * inverse;
  const double n1 = u.value.dot(v.first);
  u.first = (v.first - u.value * n1) * inverse;
  if constexpr (kSecond) {
    const double n2 = u.first.dot(v.first) + u.value.dot(v.second);
    u.second = (v.second - u.value * n2 - 2.0 * n1 * u.first) * inverse;
  }
  return u;
}

// z - u (u.z), the part of z at right angles to the unit vector u.
template <bool kSecond>
Moving<kSecond> Rejected(const Moving<kSecond>& z, const Moving<kSecond>& u) {
  const double c = u.value.dot(z.value);
  const double c1 = u.first.dot(z.value) + u.value.dot(z.first);
  Moving<kSecond> out;
  out.value = z.value - c * u.value;
  out.first = z.first - c1 * u.value - c * u.first;
  if constexpr (kSecond) {
    const double c2 = u.second.dot(z.value) + 2.0 * u.first.dot(z.first) + u.value.dot(z.second);
    out.second = z.second - c2 * u.value - 2.0 * c1 * u.first - c * u.second;
  }
  return out;
}

template <bool kSecond>
Moving<kSecond> Cross(const Moving<kSecond>& a, const Moving<kSecond>& b) {
  Moving<kSecond> out;
  out.value = a.value.cross(b.value);
  out.first = a.first.cross(b.value) + a.value.cross(b.first);
  if constexpr (kSecond) {
    out.second = a.second.cross(b.value) + 2.0 * a.first.cross(b.first) + a.value.cross(b.second);
  }
  return out;
}

TrackAxes Undefined() {
  const Eigen::Matrix3d nan = Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());
  return {.axes_1 = nan, .rate = nan, .acceleration = nan};
}

template <bool kSecond>
TrackAxes Axes(const Frame& frame, const Motion& motion) {
  constexpr double kSmallestSine_1 = 1e-6;
  if (!(motion.velocity_mps.squaredNorm() > 0.0)) return Undefined();
  const VerticalMotion vertical =
      frame.VerticalAlong(motion.position_m, motion.velocity_mps, motion.acceleration_mps2);
  using Vector = Moving<kSecond>;
  const Vector along =
      Normalised(Vector{motion.velocity_mps, motion.acceleration_mps2, motion.jerk_mps3});
  const Vector upright =
      Rejected(Vector{vertical.up_1, vertical.rate, vertical.acceleration}, along);
  if (!(upright.value.squaredNorm() > kSmallestSine_1 * kSmallestSine_1)) return Undefined();
  const Vector up = Normalised(upright);
  const Vector across = Cross(up, along);
  TrackAxes axes;
  axes.axes_1 << along.value, across.value, up.value;
  axes.rate << along.first, across.first, up.first;
  if constexpr (kSecond) axes.acceleration << along.second, across.second, up.second;
  return axes;
}

}  // namespace

TrackAxes TrackAxesOf(const Frame& frame, const Motion& motion) {
  return Axes<true>(frame, motion);
}

TrackAxes TrackAxesWithRate(const Frame& frame, const Motion& motion) {
  return Axes<false>(frame, motion);
}

}  // namespace sarblock
