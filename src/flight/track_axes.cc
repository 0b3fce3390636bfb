// SPDX-License-Identifier: Apache-2.0
#include "track_axes.h"

#include <limits>

#include <Eigen/Geometry>

namespace sarblock {
namespace {

using Eigen::Vector3d;

// A track that turns by less in a second counts as straight: a correction of 10 m then moves the
// cone at a range of 20 km by some nanometres. Rounded states of a straight line leave 1e-15.
constexpr double kStraight_1ps = 1e-12;

// A vector that moves, with as many of its first two time derivatives as are wanted.
template <int kDerivatives>
struct Moving {
  Vector3d value;
  Vector3d first;
  Vector3d second;
};

// v/|v|. With n = |v| and u = v/n: n' = u.v', u' = (v' - u n')/n, n'' = u'.v' + u.v'' and
// u'' = (v'' - u n'' - 2 u' n')/n. One division: a look takes this many times, and a division is
// twenty products.
template <int kDerivatives>
Moving<kDerivatives> Normalised(const Moving<kDerivatives>& v) {
  const double inverse = 1.0 / v.value.norm();
  Moving<kDerivatives> u;
  u.value = v.value * inverse;
  if constexpr (kDerivatives == 0) return u;
  const double n1 = u.value.dot(v.first);
  u.first = (v.first - u.value * n1) * inverse;
  if constexpr (kDerivatives > 1) {
    const double n2 = u.first.dot(v.first) + u.value.dot(v.second);
    u.second = (v.second - u.value * n2 - 2.0 * n1 * u.first) * inverse;
  }
  return u;
}

// z - u (u.z), the part of z at right angles to the unit vector u.
template <int kDerivatives>
Moving<kDerivatives> Rejected(const Moving<kDerivatives>& z, const Moving<kDerivatives>& u) {
  const double c = u.value.dot(z.value);
  Moving<kDerivatives> out;
  out.value = z.value - c * u.value;
  if constexpr (kDerivatives == 0) return out;
  const double c1 = u.first.dot(z.value) + u.value.dot(z.first);
  out.first = z.first - c1 * u.value - c * u.first;
  if constexpr (kDerivatives > 1) {
    const double c2 = u.second.dot(z.value) + 2.0 * u.first.dot(z.first) + u.value.dot(z.second);
    out.second = z.second - c2 * u.value - 2.0 * c1 * u.first - c * u.second;
  }
  return out;
}

template <int kDerivatives>
Moving<kDerivatives> Cross(const Moving<kDerivatives>& a, const Moving<kDerivatives>& b) {
  Moving<kDerivatives> out;
  out.value = a.value.cross(b.value);
  if constexpr (kDerivatives == 0) return out;
  out.first = a.first.cross(b.value) + a.value.cross(b.first);
  if constexpr (kDerivatives > 1) {
    out.second = a.second.cross(b.value) + 2.0 * a.first.cross(b.first) + a.value.cross(b.second);
  }
  return out;
}

TrackAxes Undefined() {
  const Eigen::Matrix3d nan = Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());
  return {.axes_1 = nan, .rate = nan, .acceleration = nan};
}

template <int kDerivatives>
TrackAxes Axes(const VerticalMotion& vertical, const Motion& motion) {
  constexpr double kSmallestSine_1 = 1e-6;
  if (!(motion.velocity_mps.squaredNorm() > 0.0)) return Undefined();
  using Vector = Moving<kDerivatives>;
  const Vector along =
      Normalised(Vector{motion.velocity_mps, motion.acceleration_mps2, motion.jerk_mps3});
  const Vector upright =
      Rejected(Vector{vertical.up_1, vertical.rate, vertical.acceleration}, along);
  if (!(upright.value.squaredNorm() > kSmallestSine_1 * kSmallestSine_1)) return Undefined();
  const Vector up = Normalised(upright);
  const Vector across = Cross(up, along);
  TrackAxes axes;
  axes.axes_1 << along.value, across.value, up.value;
  if constexpr (kDerivatives > 0) axes.rate << along.first, across.first, up.first;
  if constexpr (kDerivatives > 1) axes.acceleration << along.second, across.second, up.second;
  return axes;
}

}  // namespace

TrackAxes TrackAxesOf(const VerticalMotion& vertical, const Motion& motion) {
  return Axes<2>(vertical, motion);
}

TrackAxes TrackAxesOf(const Frame& frame, const Motion& motion) {
  return Axes<2>(
      frame.VerticalAlong(motion.position_m, motion.velocity_mps, motion.acceleration_mps2),
      motion);
}

TrackAxes TrackAxesWithRate(const Frame& frame, const Motion& motion) {
  const VerticalMotion vertical =
      frame.VerticalAlong(motion.position_m, motion.velocity_mps, motion.acceleration_mps2);
  // In the local frame a straight piece has axes that do not turn.
  if (frame.kind() == FrameKind::kLocal &&
      motion.acceleration_mps2.squaredNorm() <=
          kStraight_1ps * kStraight_1ps * motion.velocity_mps.squaredNorm()) {
    return Axes<0>(vertical, motion);
  }
  return Axes<1>(vertical, motion);
}

}  // namespace sarblock
