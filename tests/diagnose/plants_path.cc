// SPDX-License-Identifier: Apache-2.0
#include "plants_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "block/read_recorded.h"
#include "plants_draw.h"
#include <Eigen/Geometry>

namespace sarblock::test {
namespace {

template <typename Edit>
void EditStates(Block* block, std::optional<std::uint32_t> pass, const Edit& edit) {
  for (std::uint32_t p = 0; p < block->passes.size(); ++p) {
    if (pass && p != *pass) continue;
    std::vector<StateVector> states = block->passes[p].RecordedStates();
    for (StateVector& state : states) edit(&state);
    ReplaceStates(std::move(states), p, block);
  }
}

double RotationOf(const Block& block) {
  const double a_m = block.frame.ellipsoid().a_m;
  if (a_m > 6.2e6) return 7.2921159e-5;
  if (a_m > 5e6) return -2.0 * std::numbers::pi / (243.0185 * 86400.0);
  if (a_m > 3e6) return 7.0882181e-5;
  return 2.0 * std::numbers::pi / (27.321661 * 86400.0);
}

Planted PathKilometres(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  EditStates(block, pass, [](StateVector* state) {
    state->position_m *= 1e-3;
    state->velocity_mps *= 1e-3;
  });
  return PlantInPass(*block, pass, "path.unit");
}

Planted VelocityKilometres(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  EditStates(block, pass, [](StateVector* state) { state->velocity_mps *= 1e-3; });
  return PlantInPass(*block, pass, "path.unit");
}

Planted VelocitySign(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  EditStates(block, pass, [](StateVector* state) { state->velocity_mps *= -1.0; });
  return PlantInPass(*block, pass, "path.velocity_sign");
}

/// Axes that do not turn and are the body's at `aligned_s`.
void MakeInertial(std::optional<std::uint32_t> pass, double aligned_s, Block* block) {
  const double rate = RotationOf(*block);
  EditStates(block, pass, [&](StateVector* state) {
    const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
    const Eigen::AngleAxisd turn(rate * (state->time_s - aligned_s), axis);
    state->velocity_mps = turn * (state->velocity_mps + rate * axis.cross(state->position_m));
    state->position_m = turn * state->position_m;
  });
}

Planted Inertial(Block* block, RandomStream*) {
  if (block->frame.kind() != FrameKind::kGeocentric) return {};
  MakeInertial({}, 0.0, block);
  return PlantEverywhere("path.inertial");
}

/// At any sidereal time.
Planted InertialAtAnyAngle(Block* block, RandomStream* random) {
  if (block->frame.kind() != FrameKind::kGeocentric) return {};
  const double turn_s = 2.0 * std::numbers::pi / std::abs(RotationOf(*block));
  MakeInertial({}, (random->Uniform() - 0.5) * turn_s, block);
  return PlantEverywhere("path.inertial");
}

Planted OneInertial(Block* block, RandomStream* random) {
  if (block->frame.kind() != FrameKind::kGeocentric) return {};
  const std::uint32_t pass = DrawPass(*block, random);
  MakeInertial(pass, DrawSign(random) * DrawSize(1.0, 1e4, random), block);
  return PlantInPass(*block, pass, "path.inertial");
}

/// Straight axes, read off a map: of UTM's scale, the ground curved.
Planted MapProjection(Block* block, RandomStream* random) {
  if (block->frame.kind() != FrameKind::kLocal || block->points.known.empty()) return {};
  constexpr double kEarth_m = 6371000.0;
  const double scale = 0.9996 + 4e-4 * random->Uniform();
  const Eigen::Vector2d origin_m(437000.0, 5312000.0);  // as in a zone of UTM
  const Eigen::Vector3d middle_m = block->points.given_m[block->points.known.front().point];
  const auto on_map = [&](const Eigen::Vector3d& p_m) -> Eigen::Vector3d {
    const Eigen::Vector2d plan_m = p_m.head<2>() - middle_m.head<2>();
    const double below_m = kEarth_m + p_m.z();  // from the centre of the ground
    const double angle_rad = std::atan2(plan_m.norm(), below_m);
    Eigen::Vector3d out;
    out << middle_m.head<2>() + origin_m + scale * kEarth_m * angle_rad * plan_m.normalized(),
        std::hypot(plan_m.norm(), below_m) - kEarth_m;
    if (plan_m.norm() == 0.0) out << p_m.head<2>() + origin_m, p_m.z();
    return out;
  };
  EditStates(block, {}, [&](StateVector* state) {
    const Eigen::Vector3d before_m = on_map(state->position_m - state->velocity_mps);
    const Eigen::Vector3d after_m = on_map(state->position_m + state->velocity_mps);
    state->velocity_mps = 0.5 * (after_m - before_m);
    state->position_m = on_map(state->position_m);
  });
  for (const KnownPosition& known : block->points.known) {
    Eigen::Vector3d& p_m = block->points.given_m[known.point];
    p_m = on_map(p_m);
  }
  return PlantEverywhere("frame.projection");
}

Planted InertialVelocities(Block* block, RandomStream*) {
  if (block->frame.kind() != FrameKind::kGeocentric) return {};
  const double rate = RotationOf(*block);
  EditStates(block, {}, [&](StateVector* state) {
    state->velocity_mps += rate * Eigen::Vector3d::UnitZ().cross(state->position_m);
  });
  return PlantEverywhere("path.inertial_velocity");
}

Planted ExchangedPasses(Block* block, RandomStream* random) {
  const std::uint32_t a = DrawPass(*block, random), b = DrawPass(*block, random);
  if (a == b) return {};
  std::swap(block->passes[a].path, block->passes[b].path);
  std::swap(block->passes[a].recorded, block->passes[b].recorded);
  const auto [low, high] = std::minmax(a, b);
  return {true, {"path.exchanged"}, {block->passes[low].id, block->passes[high].id}, {}, ""};
}

/// States that contradict each other by noise.
Planted NoisyStates(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  const double speed_mps = block->passes[pass].path.states().front().velocity_mps.norm();
  const double part = DrawSize(3e-5, 3e-4, random);
  EditStates(block, pass, [&](StateVector* state) {
    for (int i = 0; i < 3; ++i) state->velocity_mps[i] += part * speed_mps * random->Normal();
  });
  static_cast<void>(ReadRecordedFlights(block));
  return PlantInPass(*block, pass, "path.rough");
}

/// Every n-th state alone.
Planted SparseStates(Block* block, RandomStream*) {
  if (block->frame.kind() != FrameKind::kGeocentric) return {};
  for (std::uint32_t p = 0; p < block->passes.size(); ++p) {
    const std::vector<StateVector> states = block->passes[p].RecordedStates();
    const std::size_t count = states.size();
    if (count < 9) return {};
    std::vector<StateVector> kept;
    for (std::size_t i = 0; i < 9; ++i) kept.push_back(states[i * (count - 1) / 8]);
    if (block->passes[p].path.end_s() - block->passes[p].path.start_s() < 400.0) return {};
    ReplaceStates(std::move(kept), p, block);
  }
  static_cast<void>(ReadRecordedFlights(block));
  return PlantEverywhere("path.sparse");
}

}  // namespace

std::vector<Plant> PathPlants() {
  return {{"path in km", PathKilometres},
          {"velocities in km/s", VelocityKilometres},
          {"velocities of the wrong sign", VelocitySign},
          {"inertial path", Inertial},
          {"inertial path at any sidereal time", InertialAtAnyAngle},
          {"one pass inertial", OneInertial},
          {"coordinates of a map projection", MapProjection},
          {"inertial velocities", InertialVelocities},
          {"paths of two passes exchanged", ExchangedPasses},
          {"states rough", NoisyStates},
          {"states far apart", SparseStates}};
}

}  // namespace sarblock::test
