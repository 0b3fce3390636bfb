// SPDX-License-Identifier: Apache-2.0
#include "terrain_sight.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "geometry/track_axes.h"
#include <boost/math/tools/minima.hpp>

namespace sarblock {
namespace {

constexpr double kStepsPerDetail = 8.0;
constexpr double kFirstStep = 1.0 / 1024.0;  // of the others; from there they double

/// A clearance somewhere on a line or circle, and whether all that follows is free of ground.
struct Sample {
  double clear_m = 0.0;
  bool last = false;
};

/// Whether a clearance that is zero at the start falls below zero on the way. `clearance(at_m)`
/// falls by at most `fall` per metre.
template <typename Function>
bool FallsBelowZero(const Function& clearance, double length_m, double fall, double step_m) {
  if (!(fall > 0.0)) return false;
  struct Place {
    double at_m = 0.0, clear_m = 0.0;
  };
  // Steps longer than step_m are short enough for the clearance at their start.
  const auto dips_between = [&](const Place& from, const Place& to) {
    if (from.clear_m >= fall * (to.at_m - from.at_m)) return false;
    constexpr int kBits = 11;
    std::uintmax_t iterations = 60;
    const auto least = boost::math::tools::brent_find_minima(
        [&](double since_m) { return clearance(from.at_m + since_m).clear_m; },
        0.0,
        to.at_m - from.at_m,
        kBits,
        iterations);
    return least.second < 0.0;
  };
  Place before, here;
  double at_m = kFirstStep * step_m;
  while (true) {
    at_m = std::min(at_m, length_m);
    const Sample sample = clearance(at_m);
    if (sample.clear_m < 0.0) return true;
    const Place next{at_m, sample.clear_m};
    if (here.clear_m < before.clear_m && here.clear_m <= next.clear_m &&
        (dips_between(before, here) || dips_between(here, next))) {
      return true;
    }
    if (sample.last || at_m == length_m) return dips_between(here, next);
    before = std::exchange(here, next);
    at_m += std::max(std::min(at_m, step_m), sample.clear_m / fall);
  }
}

/// How fast the clearance falls at most along a direction, over the steepest slope.
double FallAlong(const Eigen::Vector3d& direction, const Eigen::Vector3d& up, double steepest) {
  const double rise = direction.dot(up);
  return steepest * std::sqrt(std::max(0.0, 1.0 - rise * rise)) - rise;
}

}  // namespace

TerrainSight::TerrainSight(const Scene& scene, Ground ground)
    : scene_(scene), ground_(std::move(ground)) {
  if (scene.frame.kind() == FrameKind::kLocal) return;
  origin_m_ = FrameFromPlane(scene, Eigen::Vector2d::Zero(), 0.0);
  enu_from_frame_ = scene.frame.EnuFromFrame(origin_m_);
}

TerrainSight::Height TerrainSight::HeightOf(const Eigen::Vector3d& p_m) const {
  // The vertical through p meets the tangent plane at the place from which FrameFromPlane() makes
  // p.
  const Vertical vertical = scene_.frame.VerticalAt(p_m);
  const Eigen::Vector3d up = enu_from_frame_ * vertical.up;
  const Eigen::Vector3d enu_m = enu_from_frame_ * (p_m - origin_m_);
  const Eigen::Vector2d plane_m = enu_m.head<2>() - enu_m.z() / up.z() * up.head<2>();
  return {vertical.height_m, vertical.height_m - ground_.height_m(plane_m)};
}

bool TerrainSight::InShadow(const Eigen::Vector3d& antenna_m, const Eigen::Vector3d& p_m) const {
  const double range_m = (antenna_m - p_m).norm();
  const Eigen::Vector3d direction = (antenna_m - p_m) / range_m;
  const auto clearance = [&](double at_m) {
    const Height height = HeightOf(p_m + at_m * direction);
    return Sample{height.clear_m, height.own_m > ground_.highest_m};
  };
  // The line steepens on its way up: it falls fastest at its start.
  const double fall = FallAlong(direction, scene_.frame.UpAt(p_m), ground_.steepest);
  return FallsBelowZero(clearance, range_m, fall, ground_.detail_m / kStepsPerDetail);
}

bool TerrainSight::InLayover(const Motion& motion,
                             LookSide side,
                             const Eigen::Vector3d& p_m) const {
  const Eigen::Matrix3d axes = TrackAxesOf(scene_.frame, motion).axes;
  const Eigen::Vector3d across = static_cast<double>(side) * axes.col(1), up = axes.col(2);
  const Eigen::Vector3d d = p_m - motion.position_m;
  const double radius_m = std::hypot(d.dot(across), d.dot(up));
  const double look_rad = std::atan2(d.dot(across), -d.dot(up));
  const Eigen::Vector3d centre_m = motion.position_m + d.dot(axes.col(0)) * axes.col(0);
  const auto height_at = [&](double outward_m) {
    const double angle_rad = look_rad + outward_m / radius_m;
    return HeightOf(centre_m +
                    radius_m * (std::sin(angle_rad) * across - std::cos(angle_rad) * up));
  };
  const double step_m = ground_.detail_m / kStepsPerDetail;
  // Outward the circle rises out of the ground, ever more steeply.
  const Eigen::Vector3d outward = std::cos(look_rad) * across + std::sin(look_rad) * up;
  const auto above = [&](double at_m) {
    const Height height = height_at(at_m);
    return Sample{height.clear_m, height.own_m > ground_.highest_m};
  };
  const double fall = FallAlong(outward, scene_.frame.UpAt(p_m), ground_.steepest);
  if (FallsBelowZero(above, radius_m * (std::numbers::pi - look_rad), fall, step_m)) return true;
  // Inward it goes down into it, to R (1 - cos(look)) deep over R sin(look) at the nadir.
  if (ground_.steepest < std::tan(0.5 * look_rad)) return false;
  const auto below = [&](double at_m) {
    const Height height = height_at(-at_m);
    return Sample{-height.clear_m, height.own_m < ground_.lowest_m};
  };
  return FallsBelowZero(below, radius_m * look_rad, ground_.steepest, step_m);
}

std::optional<LookLoss> TerrainSight::Hides(const Motion& motion,
                                            LookSide side,
                                            const Eigen::Vector3d& p_m) const {
  if (InShadow(motion.position_m, p_m)) return LookLoss::kShadow;
  if (InLayover(motion, side, p_m)) return LookLoss::kLayover;
  return std::nullopt;
}

}  // namespace sarblock
