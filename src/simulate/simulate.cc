// SPDX-License-Identifier: Apache-2.0
#include "sarblock/simulate/simulate.h"

#include "sarblock/core/error.h"
#include "sarblock/flight/track_axes.h"
#include "sarblock/geometry/cone_time.h"
#include "sarblock/simulate/terrain.h"

#include <cmath>
#include <optional>

#include "nominal_paths.h"
#include "place_points.h"

namespace sarblock {
namespace {

/// A planned pass and the sphere about the middle of its path that holds its strip.
struct Reach {
  const PlannedPass* planned;
  Eigen::Vector3d middle_m;
};

bool InSwath(const Frame& frame,
             const PlannedPass& planned,
             const Motion& motion,
             const Eigen::Vector3d& p_m) {
  const Eigen::Matrix3d axes = TrackAxesOf(frame, motion).axes_1;
  const Eigen::Vector3d d = p_m - motion.position_m;
  const double across_m = d.dot(axes.col(1)) * static_cast<double>(planned.pass.side);
  if (!(across_m > 0.0)) return false;
  double value = across_m;
  if (planned.swath.kind == SwathKind::kSlantRange) value = d.norm();
  if (planned.swath.kind == SwathKind::kLookAngle) {
    value = std::atan2(across_m, -d.dot(axes.col(2)));
  }
  return planned.swath.limits[0] <= value && value <= planned.swath.limits[1];
}

/// Time of the planned look at p, or nothing where the strip does not show it.
std::optional<double> PlannedTime(const Frame& frame,
                                  const Reach& reach,
                                  const Eigen::Vector3d& p_m) {
  const PlannedPass& planned = *reach.planned;
  if ((p_m - reach.middle_m).squaredNorm() > planned.reach_m * planned.reach_m) {
    return std::nullopt;
  }
  const Pass& pass = planned.pass;
  const std::optional<double> time_s = FindConeTime(
      pass.path, p_m, Cone{.squint_rad = planned.squint_rad}, pass.start_s, pass.end_s);
  if (!time_s) return std::nullopt;
  const std::optional<Motion> motion = pass.path.At(*time_s);
  if (!motion || !InSwath(frame, planned, *motion, p_m)) return std::nullopt;
  return time_s;
}

void AppendKnown(const SceneControl& known, std::uint32_t point, Points* points) {
  KnownPosition position;
  position.point = point;
  position.held = known.held;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (known.held[i]) {
      position.covariance_enu_m2(axis, axis) = known.sigma_m[i] * known.sigma_m[i];
    }
  }
  points->known.push_back(position);
}

/// Places points on the terrain and lists their looks at the nominal times.
void FillPointsAndLooks(const Scene& scene,
                        const std::vector<PlannedPass>& planned,
                        ProgressSink* progress,
                        SimulatedBlock* out) {
  const Terrain terrain(scene.terrain, scene.seed);
  std::vector<Reach> reaches;
  for (const PlannedPass& pass : planned) {
    const auto middle = pass.pass.path.At(0.5 * (pass.pass.start_s + pass.pass.end_s));
    if (!middle) throw InputError(pass.pass.id, "the strip lies outside its path");
    reaches.push_back({&pass, middle->position_m});
  }
  Block& block = out->block;
  const std::vector<PlacedPoint> placed = PlacePoints(scene);
  std::vector<std::uint32_t> seen_by;
  std::vector<double> times_s;
  constexpr std::size_t kPointsPerStep = 16384;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    if (i % kPointsPerStep == 0) Step(progress, "simulate", i, placed.size(), "points");
    const PlacedPoint& point = placed[i];
    const Eigen::Vector3d p_m =
        FrameFromPlane(scene, point.plane_m, terrain.HeightAt(point.plane_m));
    seen_by.clear();
    times_s.clear();
    for (std::size_t pass = 0; pass < reaches.size(); ++pass) {
      if (const auto time_s = PlannedTime(block.frame, reaches[pass], p_m)) {
        seen_by.push_back(static_cast<std::uint32_t>(pass));
        times_s.push_back(*time_s);
      }
    }
    // Nobody measures a tie point in one image; control is listed even where no image shows it.
    if (point.role != PointRole::kControl && seen_by.size() < scene.points.min_looks) continue;
    const std::uint32_t index = block.points.ids.Append(point.id);
    block.points.role.push_back(point.role);
    block.points.given_m.push_back(Eigen::Vector3d::Constant(kNotGiven));
    if (point.role != PointRole::kTie) {
      AppendKnown(
          point.role == PointRole::kControl ? scene.control : scene.check, index, &block.points);
    }
    out->truth.points_m.push_back(p_m);
    block.looks.pass.insert(block.looks.pass.end(), seen_by.begin(), seen_by.end());
    block.looks.offsets.push_back(block.looks.pass.size());
    out->exact.nominal_time_s.insert(
        out->exact.nominal_time_s.end(), times_s.begin(), times_s.end());
  }
}

}  // namespace

SimulatedBlock Simulate(const Scene& scene, ProgressSink* progress) {
  Validate(scene);
  SimulatedBlock out;
  out.block.name = scene.name;
  out.block.frame = scene.frame;
  const std::vector<PlannedPass> planned = PlanPasses(scene);
  FillPointsAndLooks(scene, planned, progress, &out);
  bool squinted = scene.looks.doppler;
  for (const PlannedPass& pass : planned) {
    out.block.passes.push_back(pass.pass);
    out.squint_rad.push_back(pass.squint_rad);
    squinted = squinted || pass.squint_rad != 0.0;
  }
  const std::size_t count = out.block.looks.size();
  if (count == 0) {
    throw InputError("points", "no point lies in any swath; check area, swath and look side");
  }
  Looks& looks = out.block.looks;
  looks.flags.assign(count, scene.looks.doppler ? Looks::kDoppler : 0);
  looks.time_s.resize(count);
  looks.range_m.resize(count);
  if (squinted) looks.cone.resize(count);
  out.exact.time_s.resize(count);
  out.exact.range_m.resize(count);
  out.exact.azimuth_rate_mps.resize(count);
  out.blunder.resize(count);
  Step(progress, "simulate", 1, 1, "looks");
  Redraw(scene, scene.seed, RedrawChoice{}, &out);
  return out;
}

}  // namespace sarblock
