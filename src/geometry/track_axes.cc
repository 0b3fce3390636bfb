// SPDX-License-Identifier: Apache-2.0
#include "track_axes.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
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
  return {.axes = nan, .rate = nan, .acceleration = nan};
}

}  // namespace

TrackAxes TrackAxesOf(const VerticalMotion& vertical, const Motion& motion) {
  constexpr double kSmallestSine = 1e-6;
  if (!(motion.velocity_mps.squaredNorm() > 0.0)) return Undefined();
  const Moving along =
      Normalised({motion.velocity_mps, motion.acceleration_mps2, motion.jerk_mps3});
  const Moving upright = Rejected({vertical.up, vertical.rate, vertical.acceleration}, along);
  if (!(upright.value.squaredNorm() > kSmallestSine * kSmallestSine)) return Undefined();
  const Moving up = Normalised(upright);
  const Moving across = Cross(up, along);
  TrackAxes axes;
  axes.axes << along.value, across.value, up.value;
  axes.rate << along.first, across.first, up.first;
  axes.acceleration << along.second, across.second, up.second;
  return axes;
}

TrackAxes TrackAxesOf(const Frame& frame, const Motion& motion) {
  return TrackAxesOf(
      frame.VerticalAlong(motion.position_m, motion.velocity_mps, motion.acceleration_mps2),
      motion);
}

namespace {

/// More knots than this in one piece of a path are taken for a path that is no flight.
constexpr double kMaxSteps = 1e6;

}  // namespace

VerticalTable::VerticalTable(const Frame& frame, const FlightPath& path) {
  if (frame.kind() == FrameKind::kLocal) return;
  pieces_.resize(path.piece_count());
  polynomials_.reserve(pieces_.size());
  const auto vertical_at = [&](double time_s) {
    const Motion motion = *path.At(time_s);
    return frame.VerticalAlong(motion.position_m, motion.velocity_mps, motion.acceleration_mps2);
  };
  // The vertical and its rate are continuous: the last knot of a piece is the first of the next.
  VerticalMotion a = vertical_at(path.start_s());
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    const double start_s = path.PieceStart_s(k), length_s = path.PieceEnd_s(k) - start_s;
    const VerticalMotion last = vertical_at(path.PieceEnd_s(k));
    const double turn_rad = length_s * std::max(a.rate.norm(), last.rate.norm());
    const double steps = std::max(1.0, std::ceil(turn_rad / kMaxTurn_rad));
    if (!(steps <= kMaxSteps)) {
      throw InputError("states", "the flight path turns around its body too fast to be tabulated");
    }
    const double step_s = length_s / steps, inverse_per_s = steps / length_s;
    pieces_[k] = {start_s,
                  step_s,
                  inverse_per_s,
                  static_cast<std::uint32_t>(polynomials_.size()),
                  static_cast<std::uint32_t>(steps)};
    for (std::uint32_t i = 1; i <= pieces_[k].steps; ++i) {
      const VerticalMotion b = i == pieces_[k].steps ? last : vertical_at(start_s + i * step_s);
      const Eigen::Vector3d mean = (b.up - a.up) * inverse_per_s;
      polynomials_.push_back({a.up,
                              a.rate,
                              (3.0 * mean - 2.0 * a.rate - b.rate) * inverse_per_s,
                              (a.rate + b.rate - 2.0 * mean) * (inverse_per_s * inverse_per_s)});
      a = b;
    }
  }
}

VerticalMotion VerticalTable::At(std::size_t index, double time_s) const {
  if (pieces_.empty()) return {};
  const Piece& piece = pieces_[index];
  const double after_s = time_s - piece.start_s, steps = after_s * piece.inverse_per_s;
  const std::uint32_t k =
      steps > 0.0 ? std::min(piece.steps - 1, static_cast<std::uint32_t>(steps)) : 0U;
  const Polynomial& p = polynomials_[piece.first + k];
  const double x = after_s - k * piece.step_s;
  return {.up = p.up + x * (p.rate + x * (p.second + x * p.third)),
          .rate = p.rate + x * (2.0 * p.second + (3.0 * x) * p.third),
          .acceleration = 2.0 * p.second + (6.0 * x) * p.third};
}

}  // namespace sarblock
