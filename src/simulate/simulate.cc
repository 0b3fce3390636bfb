// SPDX-License-Identifier: Apache-2.0
#include "sarblock/simulate/simulate.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/threads.h"
#include "nominal_paths.h"
#include "place_points.h"
#include "terrain.h"
#include "visibility.h"
#include "wander.h"

namespace sarblock {
namespace {

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

/// What a range of the planned points adds to the block.
struct SeenPoints {
  std::vector<PlacedPoint> points;
  std::vector<Eigen::Vector3d> position_m;
  std::vector<std::size_t> look_count;
  std::vector<PlannedLook> looks;
};

SeenPoints SeePoints(const Scene& scene,
                     const Terrain& terrain,
                     const Visibility& visibility,
                     const PointPlan& plan,
                     std::size_t begin,
                     std::size_t end) {
  SeenPoints seen;
  std::vector<PlannedLook> looks;
  for (std::size_t i = begin; i < end; ++i) {
    PlacedPoint point = plan.At(i);
    const Eigen::Vector3d p_m =
        FrameFromPlane(scene, point.plane_m, terrain.HeightAt(point.plane_m));
    visibility.LooksAt(p_m, &looks);
    // Nobody measures a tie point in one image; control is listed even where no image shows it.
    if (point.role != PointRole::kControl && looks.size() < scene.points.min_looks) continue;
    seen.points.push_back(std::move(point));
    seen.position_m.push_back(p_m);
    seen.look_count.push_back(looks.size());
    seen.looks.insert(seen.looks.end(), looks.begin(), looks.end());
  }
  return seen;
}

void Append(const Scene& scene, const SeenPoints& seen, SimulatedBlock* out) {
  Block& block = out->block;
  std::size_t look = 0;
  for (std::size_t i = 0; i < seen.points.size(); ++i) {
    const PlacedPoint& point = seen.points[i];
    const std::uint32_t index = block.points.ids.Append(point.id);
    block.points.role.push_back(point.role);
    block.points.given_m.push_back(Eigen::Vector3d::Constant(kNotGiven));
    if (point.role != PointRole::kTie) {
      AppendKnown(
          point.role == PointRole::kControl ? scene.control : scene.check, index, &block.points);
    }
    out->truth.points_m.push_back(seen.position_m[i]);
    for (std::size_t k = 0; k < seen.look_count[i]; ++k, ++look) {
      block.looks.pass.push_back(seen.looks[look].pass);
      out->exact.nominal_time_s.push_back(seen.looks[look].time_s);
    }
    block.looks.offsets.push_back(block.looks.pass.size());
  }
}

/// Places points on the terrain and lists their looks at the nominal times. A few ranges of points
/// at a time, on all threads, appended in their order.
void FillPointsAndLooks(const Scene& scene,
                        const std::vector<NominalPass>& planned,
                        ProgressSink* progress,
                        SimulatedBlock* out) {
  constexpr std::size_t kPointsPerRange = 4096;
  constexpr std::size_t kRangesPerStep = 32;
  const Terrain terrain(scene.terrain, scene.seed);
  const Visibility visibility(out->block.frame, planned);
  const PointPlan plan(scene);
  for (std::size_t first = 0; first < plan.size(); first += kPointsPerRange * kRangesPerStep) {
    Step(progress, "simulate", first, plan.size(), "points");
    const std::size_t count = std::min(plan.size() - first, kPointsPerRange * kRangesPerStep);
    std::vector<SeenPoints> ranges((count + kPointsPerRange - 1) / kPointsPerRange);
    ParallelForChunks(
        count, kPointsPerRange, [&](std::size_t range, std::size_t begin, std::size_t end) {
          ranges[range] = SeePoints(scene, terrain, visibility, plan, first + begin, first + end);
        });
    for (const SeenPoints& seen : ranges) Append(scene, seen, out);
  }
}

}  // namespace

const Wander* SimulatedBlock::WanderOf(std::size_t pass) const {
  return wander == nullptr ? nullptr : &(*wander)[pass];
}

SimulatedBlock Simulate(const Scene& scene, ProgressSink* progress) {
  Validate(scene);
  SimulatedBlock out;
  out.block.name = scene.name;
  out.block.frame = scene.frame;
  const std::vector<NominalPass> planned = PlanPasses(scene);
  FillPointsAndLooks(scene, planned, progress, &out);
  bool squinted = scene.looks.doppler;
  for (const NominalPass& pass : planned) {
    out.block.passes.push_back(pass.pass);
    out.squint_rad.push_back(pass.squint_rad);
    squinted = squinted || pass.squint_rad != 0.0;
  }
  if (IsRecorded(scene)) out.planned = out.block.passes;
  const std::size_t count = out.block.looks.size();
  if (count == 0) {
    throw InputError("points", "no point lies in any swath; check area, swath and look side");
  }
  Looks& looks = out.block.looks;
  looks.flags.assign(count, scene.looks.doppler ? Looks::kDoppler : 0);
  looks.time_s.resize(count);
  looks.range_m.resize(count);
  if (squinted) looks.cone.resize(count);
  if (scene.looks.doppler) out.exact.doppler_hz.resize(count);
  out.exact.time_s.resize(count);
  out.exact.range_m.resize(count);
  out.exact.azimuth_rate_mps.resize(count);
  out.blunder.resize(count);
  Step(progress, "simulate", 1, 1, "looks");
  Redraw(scene, scene.seed, RedrawChoice{}, &out);
  return out;
}

}  // namespace sarblock
