// SPDX-License-Identifier: Apache-2.0
#include "nominal_paths.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "block/swath.h"
#include "core/text.h"
#include "geometry/track_axes.h"
#include "scene.h"
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace sarblock {
namespace {

/// A planned motion by time from the middle of the strip.
using Trajectory = std::function<StateVector(double)>;

/// Circular orbit in a body-fixed frame that turns with `rotation`.
struct Orbit {
  double radius_m = 0.0;
  double inclination_rad = 0.0;
  double motion_rad_per_s = 0.0;
  double rotation_rad_per_s = 0.0;
  double latitude_argument_rad = 0.0;  // at the middle of the strip
  double node_rad = 0.0;               // longitude of the ascending node there

  [[nodiscard]] StateVector At(double since_middle_s) const {
    const double u = latitude_argument_rad + motion_rad_per_s * since_middle_s;
    const double node = node_rad - rotation_rad_per_s * since_middle_s;
    const double ci = std::cos(inclination_rad);
    const double si = std::sin(inclination_rad);
    const Eigen::Vector3d q(std::cos(u), std::sin(u) * ci, std::sin(u) * si);
    const Eigen::Vector3d q_rate(-std::sin(u), std::cos(u) * ci, std::cos(u) * si);
    Eigen::Matrix3d turn;
    turn << std::cos(node), -std::sin(node), 0, std::sin(node), std::cos(node), 0, 0, 0, 1;
    StateVector state;
    state.time_s = since_middle_s;
    state.position_m = turn * q * radius_m;
    state.velocity_mps = turn * q_rate * (radius_m * motion_rad_per_s) -
                         rotation_rad_per_s * Eigen::Vector3d::UnitZ().cross(state.position_m);
    return state;
  }
};

Motion MotionOf(const StateVector& state) {
  Motion motion;
  motion.position_m = state.position_m;
  motion.velocity_mps = state.velocity_mps;
  return motion;
}

double LookAngle(const Frame& frame, const Motion& motion, const Eigen::Vector3d& p_m, int side) {
  const Eigen::Matrix3d axes = TrackAxesOf(frame, motion).axes;
  const Eigen::Vector3d d = p_m - motion.position_m;
  return std::atan2(side * d.dot(axes.col(1)), -d.dot(axes.col(2)));
}

/// Orbits about a body that does not turn from which `aim` is at the wanted look angle and squint
/// in the middle of the strip. With d = R (sin tau, across cos tau sin theta, -cos tau cos theta)
/// along, across and up the aim has a distance from the orbit's plane, n h = -side R cos tau sin
/// theta / a, which is the same for all nodes but two.
struct OrbitsByAim {
  std::vector<Orbit> orbits;
  double least_inclination_rad = 0.0, most_inclination_rad = 0.0;  ///< NaN: none at this look angle

  OrbitsByAim(const SceneFlight& flight,
              Orbit orbit,
              const Eigen::Vector3d& aim_m,
              double look_rad) {
    const double r_m = orbit.radius_m, a_m = aim_m.norm();
    const double cosine = std::cos(flight.squint_rad) * std::cos(look_rad);
    // Nearer to the antenna of the two places where the look meets the aim's sphere.
    const double range_m =
        r_m * cosine - std::sqrt(r_m * r_m * cosine * cosine - r_m * r_m + a_m * a_m);
    const int side = static_cast<int>(flight.side);
    const double off_plane =
        side * range_m * std::cos(flight.squint_rad) * std::sin(look_rad) / a_m;
    const double ahead_rad =
        std::atan2(range_m * std::sin(flight.squint_rad), r_m - range_m * cosine);
    const Eigen::Vector3d n = aim_m / a_m;
    // The plane's normal is this far from the aim, and the inclination from the axis.
    const double from_aim_rad = std::acos(off_plane), from_axis_rad = std::acos(n.z());
    least_inclination_rad = std::abs(from_aim_rad - from_axis_rad);
    most_inclination_rad =
        std::min(from_aim_rad + from_axis_rad, 360.0 * kRadPerDeg - from_aim_rad - from_axis_rad);
    const double ci = std::cos(orbit.inclination_rad), si = std::sin(orbit.inclination_rad);
    // A body that turns may have an orbit where one that does not just has none.
    const double sine = std::clamp(
        (off_plane - n.z() * ci) / (si * std::max(1e-12, std::hypot(n.x(), n.y()))), -1.0, 1.0);
    if (std::isnan(sine)) return;
    const double longitude_rad = std::atan2(n.y(), n.x());
    for (const double of_node_rad : {std::asin(sine), 180.0 * kRadPerDeg - std::asin(sine)}) {
      orbit.node_rad = longitude_rad + of_node_rad;
      const double along_node = std::cos(of_node_rad) * std::hypot(n.x(), n.y());
      const double beside = -std::sin(of_node_rad) * std::hypot(n.x(), n.y()) * ci + n.z() * si;
      orbit.latitude_argument_rad = std::atan2(beside, along_node) - ahead_rad;
      const bool descends = std::cos(orbit.latitude_argument_rad) < 0.0;
      const bool wanted = descends == flight.descending;
      orbits.insert(wanted ? orbits.begin() : orbits.end(), orbit);
    }
  }
};

/// Finds argument of latitude and node so that `aim` is on the cone at the wanted look angle
/// at the middle of the strip: Newton with differences from the orbit straight above it, and where
/// that ends nowhere, near a pole or a turning point, from those about a body that does not turn.
Orbit AimOrbit(const Scene& scene,
               const SceneFlight& flight,
               Orbit orbit,
               const Eigen::Vector3d& aim_m,
               double look_rad) {
  const Eigen::Vector3d n = aim_m.normalized();
  const double sine = std::clamp(n.z() / std::sin(orbit.inclination_rad), -1.0, 1.0);
  double u = std::asin(sine);
  if (flight.descending) u = std::copysign(180.0 * kRadPerDeg, sine) - u;
  orbit.latitude_argument_rad = u;
  orbit.node_rad = std::atan2(n.y(), n.x()) -
                   std::atan2(std::sin(u) * std::cos(orbit.inclination_rad), std::cos(u));
  const auto miss = [&](const Orbit& trial) -> Eigen::Vector2d {
    const Motion motion = MotionOf(trial.At(0.0));
    return {EvaluateCone(motion, aim_m, Cone{.squint_rad = flight.squint_rad}).doppler_error_m /
                trial.radius_m,
            LookAngle(scene.frame, motion, aim_m, static_cast<int>(flight.side)) - look_rad};
  };
  const auto newton = [&](Orbit* found) {
    constexpr double kStep_rad = 1e-6;
    constexpr double kLongest_rad = 0.02;
    for (int iteration = 0; iteration < 60; ++iteration) {
      const Eigen::Vector2d now = miss(*found);
      if (now.cwiseAbs().maxCoeff() < 1e-11) return true;
      Eigen::Matrix2d J;
      Orbit moved = *found;
      moved.latitude_argument_rad += kStep_rad;
      J.col(0) = (miss(moved) - now) / kStep_rad;
      moved = *found;
      moved.node_rad += kStep_rad;
      J.col(1) = (miss(moved) - now) / kStep_rad;
      const Eigen::FullPivLU<Eigen::Matrix2d> lu(J);
      if (!J.allFinite() || !lu.isInvertible()) return false;
      Eigen::Vector2d step = -lu.solve(now);
      if (step.norm() > kLongest_rad) step *= kLongest_rad / step.norm();
      found->latitude_argument_rad += step.x();
      found->node_rad += step.y();
    }
    return false;
  };
  Orbit found = orbit;
  if (newton(&found)) return found;
  const OrbitsByAim by_aim(flight, orbit, aim_m, look_rad);
  for (const Orbit& start : by_aim.orbits) {
    found = start;
    if (newton(&found)) return found;
  }
  if (std::isnan(by_aim.least_inclination_rad)) {
    throw InputError("flight " + flight.id, "a look at this angle passes by the body");
  }
  const std::string least = Digits(by_aim.least_inclination_rad / kRadPerDeg, 4);
  const std::string most = Digits(by_aim.most_inclination_rad / kRadPerDeg, 4);
  throw InputError(
      "flight " + flight.id,
      "no orbit of this inclination sees the aim at this look angle: " +
          (least == most ? "one of " + least + " degrees passes nearest"
                         : "inclinations from " + least + " to " + most + " degrees do") +
          ", or another look angle");
}

/// Pass k of orbits given by their aim.
Orbit OrbitByAim(const Scene& scene, const SceneFlight& flight, std::size_t k, const Orbit& orbit) {
  const double shift = static_cast<double>(k) - 0.5 * static_cast<double>(flight.count - 1);
  const double spacing_m = flight.count == 1 ? 0.0 : flight.spacing_m;
  const Eigen::Vector2d aim_m = flight.aim_m + Eigen::Vector2d(shift * spacing_m, 0.0);
  const double look_rad = std::isnan(flight.aim_look_rad)
                              ? 0.5 * (flight.swath.limits[0] + flight.swath.limits[1])
                              : flight.aim_look_rad;
  return AimOrbit(
      scene, flight, orbit, FrameFromPlane(scene, aim_m, scene.terrain.height_m), look_rad);
}

/// Pass k of orbits given by their node.
Orbit OrbitByNode(const SceneFlight& flight, std::size_t k, Orbit orbit) {
  const double spacing_rad = flight.count == 1 ? 0.0 : flight.node_spacing_rad;
  orbit.node_rad = flight.node_lon_rad + static_cast<double>(k) * spacing_rad;
  orbit.latitude_argument_rad = flight.argument_of_latitude_rad;
  return orbit;
}

/// Largest slant range of the swath from height H over a sphere of radius a (a infinite: plane).
double ReachOf(const SceneFlight& flight, double radius_m, double relief_m) {
  const double r_m = radius_m + flight.height_m, a_m = radius_m - relief_m;
  const double range_m = FarRange(flight.swath, flight.height_m + relief_m, r_m, a_m);
  const double horizon_m = std::sqrt(r_m * r_m - a_m * a_m) + relief_m;
  return (std::isnan(range_m) ? horizon_m : range_m) / std::cos(flight.squint_rad);
}

/// Time by which six standard deviations of the trajectory error, or its table, can move a look. A
/// path that bends towards the target moves looks by more than its direction alone: three times as
/// much.
double TrajectoryErrorMargin(const SceneTrajectoryError& trajectory_error,
                             double speed_mps,
                             double range_m) {
  double shift_m = 0.0;
  double turn_mps = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (trajectory_error.rms_m[axis] > 0.0) {
      shift_m += 6.0 * trajectory_error.rms_m[axis];
      turn_mps += 6.0 * trajectory_error.rms_m[axis] /
                  (std::sqrt(3.0) * trajectory_error.time_constant_s[axis]);
    }
  }
  double table_m = 0.0;
  double table_mps = 0.0;
  for (std::size_t i = 0; i < trajectory_error.table_m.size(); ++i) {
    table_m = std::max(table_m, trajectory_error.table_m[i].norm());
    if (i == 0) continue;
    const double span_s = trajectory_error.table_time_s[i] - trajectory_error.table_time_s[i - 1];
    table_mps = std::max(
        table_mps, (trajectory_error.table_m[i] - trajectory_error.table_m[i - 1]).norm() / span_s);
  }
  return (shift_m + table_m + 3.0 * (turn_mps + table_mps) / speed_mps * range_m) / speed_mps;
}

/// Spacing of the states of the path that a recorded flight was planned on, which represents the
/// flight itself: 0.5 s are exact to 2e-8 m and 7e-8 m/s on a low orbit. The true path is written
/// at the same times, so that a cubic through them follows the trajectory error too.
double PlannedSpacing_s(const SceneTrajectoryError& trajectory_error) {
  double spacing_s = 0.5;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (trajectory_error.rms_m[axis] > 0.0) {
      spacing_s = std::min(spacing_s, trajectory_error.time_constant_s[axis] / 256.0);
    }
  }
  if (!trajectory_error.table_time_s.empty()) {
    const double span_s =
        trajectory_error.table_time_s.back() - trajectory_error.table_time_s.front();
    const auto pieces = static_cast<double>(trajectory_error.table_time_s.size() - 1);
    spacing_s = std::min(spacing_s, 0.5 * span_s / pieces);
  }
  return spacing_s;
}

/// Time by which six standard deviations of everything random can move a look.
double TimeMargin(const Scene& scene, double speed_mps, double duration_s, double range_m) {
  const SceneNavigation& navigation = scene.navigation;
  double shift_m = 0.0;
  double turn_mps = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    shift_m += navigation.constant_sigma_m[axis] + navigation.drift_sigma_m[axis] +
               navigation.curvature_sigma_m[axis];
    turn_mps += (navigation.drift_sigma_m[axis] + 3.0 * navigation.curvature_sigma_m[axis]) * 2.0 /
                duration_s;
    if (navigation.process != SceneNavigation::Process::kNone) {
      shift_m += navigation.process_sigma_m[axis];
      turn_mps += navigation.process_sigma_m[axis] / navigation.knot_spacing_s;
    }
  }
  const JointSigmas joint = SumJointSigmas(navigation.joint);
  shift_m += joint.shift_m;
  turn_mps += joint.end_slope_m * 2.0 / duration_s;
  const double angle_rad =
      navigation.squint_bias_sigma_rad + joint.squint_bias_rad + turn_mps / speed_mps;
  const double measured = scene.looks.blunder_fraction > 0.0 ? scene.looks.blunder_size : 1.0;
  const LookSigma sigma = SigmaOfPass(scene.looks);
  const double azimuth_s = sigma.azimuth_unit == AzimuthUnit::kSeconds  ? sigma.azimuth
                           : sigma.azimuth_unit == AzimuthUnit::kMetres ? sigma.azimuth / speed_mps
                                                                        : 0.0;
  return 6.0 * ((shift_m + angle_rad * range_m) / speed_mps + navigation.time_bias_sigma_s +
                joint.time_bias_s + azimuth_s * scene.looks.noise_scale * std::max(1.0, measured)) +
         TrajectoryErrorMargin(scene.trajectory_error, speed_mps, range_m) +
         std::abs(scene.delay.time_s);
}

Pass MakePass(const Scene& scene,
              const SceneFlight& flight,
              const std::string& id,
              const Trajectory& trajectory,
              double duration_s,
              double look_margin_s) {
  Pass pass;
  pass.id = id;
  pass.side = flight.side;
  pass.wavelength_m = flight.wavelength_m;
  pass.epoch_utc = flight.epoch_utc;
  pass.reduction = scene.reduction;
  pass.sigma = SigmaOfPass(scene.looks);
  if (!std::isnan(flight.range_sigma_m)) pass.sigma.range_m = flight.range_sigma_m;
  if (!std::isnan(flight.azimuth_sigma_m)) {
    pass.sigma.azimuth = flight.azimuth_sigma_m;
    pass.sigma.azimuth_unit = AzimuthUnit::kMetres;
  }
  pass.start_s = flight.start_s;
  pass.end_s = flight.start_s + duration_s;
  pass.swath = flight.swath;
  pass.squint_rad = flight.squint_rad;
  double spacing_s = flight.state_spacing_s;
  double margin_s = look_margin_s + 2.0 * spacing_s;
  double shortest_s = spacing_s;
  if (IsRecorded(scene)) {
    // Interpolation of a high degree wants four recorded states beyond either end.
    const double recorded_s = RecordedSpacing_s(scene, flight);
    spacing_s = PlannedSpacing_s(scene.trajectory_error);
    shortest_s = std::min(spacing_s, recorded_s);
    margin_s = look_margin_s + 4.0 * recorded_s;
    if (scene.recorder) margin_s += std::abs(scene.recorder->time_offset_s);
  }
  const double span_s = duration_s + 2.0 * margin_s;
  const double intervals = std::ceil(span_s / spacing_s);
  if (!(span_s / shortest_s <= 1e7)) {
    throw InputError("flight " + flight.id, "more than 10 million state vectors in a pass");
  }
  std::vector<StateVector> states;
  const auto count = static_cast<std::size_t>(intervals);
  states.reserve(count + 1);
  for (std::size_t i = 0; i <= count; ++i) {
    const double since_start_s = span_s * static_cast<double>(i) / intervals - margin_s;
    StateVector state = trajectory(since_start_s - 0.5 * duration_s);
    state.time_s = flight.start_s + since_start_s;
    states.push_back(state);
  }
  pass.path = FlightPath(std::move(states));
  return pass;
}

double GroundWidth(const SceneFlight& flight) {
  const auto ground = [&](double limit) {
    switch (flight.swath.kind) {
      case SwathKind::kLookAngle:
        return flight.height_m * std::tan(limit);
      case SwathKind::kSlantRange:
        return std::sqrt(std::max(0.0, limit * limit - flight.height_m * flight.height_m));
      case SwathKind::kGroundRange:
        break;
    }
    return limit;
  };
  return ground(flight.swath.limits[1]) - ground(flight.swath.limits[0]);
}

/// Trajectory of segment m of strip k. Geocentric: the plane's straight line lifted to constant
/// height; the velocity is a central difference over 2 s (error below 1e-6 m/s for aircraft).
Trajectory StripTrajectory(const Scene& scene,
                           const SceneFlight& flight,
                           std::size_t k,
                           std::size_t m) {
  const Eigen::Vector2d ahead(std::sin(flight.heading_rad), std::cos(flight.heading_rad));
  const Eigen::Vector2d left(-ahead.y(), ahead.x());
  const double spacing_m = flight.count == 1 ? 0.0
                           : std::isnan(flight.overlap)
                               ? flight.spacing_m
                               : (1.0 - flight.overlap) * GroundWidth(flight);
  const double segment_m = flight.segments == 1 ? 0.0 : flight.segment_spacing_m;
  const Eigen::Vector2d middle_m =
      flight.start_m + static_cast<double>(k) * spacing_m * left +
      (static_cast<double>(m) * segment_m + 0.5 * flight.length_m) * ahead;
  const Scene* s = &scene;  // outlives the trajectory, as does the flight
  const SceneFlight* f = &flight;
  return [s, f, ahead, middle_m](double since_middle_s) {
    const auto position = [&](double t) {
      const Eigen::Vector2d plane_m = middle_m + f->speed_mps * t * ahead;
      return FrameFromPlane(*s, plane_m, f->height_m);
    };
    StateVector state;
    state.position_m = position(since_middle_s);
    if (s->frame.kind() == FrameKind::kLocal) {
      state.velocity_mps << f->speed_mps * ahead, 0.0;
    } else {
      state.velocity_mps = 0.5 * (position(since_middle_s + 1.0) - position(since_middle_s - 1.0));
    }
    return state;
  };
}

}  // namespace

std::vector<NominalPass> PlanPasses(const Scene& scene) {
  std::vector<NominalPass> planned;
  const bool geocentric = scene.frame.kind() == FrameKind::kGeocentric;
  const double radius_m =
      geocentric ? scene.frame.ellipsoid().a_m : std::numeric_limits<double>::infinity();
  const Body* body = geocentric ? FindBody(scene.frame.ellipsoid().name) : nullptr;
  // Six relief sigmas bound every height in practice; one kilometre covers the ellipsoid's sag
  // below the sphere of its equatorial radius near the strip, 22 km for the Earth's pole.
  const double relief_m = std::abs(scene.terrain.height_m) + 6.0 * scene.terrain.relief_m +
                          (geocentric ? radius_m * scene.frame.ellipsoid().flattening : 0.0);
  for (const SceneFlight& flight : scene.flights) {
    const double range_m = ReachOf(flight, radius_m, relief_m);
    for (std::size_t p = 0; p < flight.count * flight.segments; ++p) {
      const std::size_t k = p / flight.segments, m = p % flight.segments;
      Trajectory trajectory;
      double duration_s = 0.0;
      double speed_mps = flight.speed_mps;
      if (flight.pattern == SceneFlight::Pattern::kStrips) {
        trajectory = StripTrajectory(scene, flight, k, m);
        duration_s = flight.length_m / speed_mps;
      } else {
        if (body == nullptr && (std::isnan(speed_mps) || std::isnan(scene.rotation_rad_per_s))) {
          throw InputError("flight " + flight.id,
                           "an orbit about an ellipsoid given by numbers needs speed_mps and "
                           "frame.rotation_rad_per_s");
        }
        Orbit orbit;
        orbit.radius_m = radius_m + flight.height_m;
        orbit.inclination_rad = flight.inclination_rad;
        if (std::isnan(speed_mps)) speed_mps = std::sqrt(body->gm / orbit.radius_m);
        orbit.motion_rad_per_s = speed_mps / orbit.radius_m;
        orbit.rotation_rad_per_s =
            std::isnan(scene.rotation_rad_per_s) ? body->rotation : scene.rotation_rad_per_s;
        orbit =
            IsByNode(flight) ? OrbitByNode(flight, k, orbit) : OrbitByAim(scene, flight, k, orbit);
        trajectory = [orbit](double since_middle_s) { return orbit.At(since_middle_s); };
        duration_s = flight.length_m / (orbit.motion_rad_per_s * radius_m);
      }
      const double margin_s = TimeMargin(scene, speed_mps, duration_s, range_m);
      NominalPass pass;
      pass.pass = MakePass(scene, flight, PassId(flight, k, m), trajectory, duration_s, margin_s);
      pass.reach_m = range_m + 0.55 * speed_mps * duration_s;
      planned.push_back(std::move(pass));
    }
  }
  return planned;
}

namespace {

/// The quick test of the ends leaves this much to the exact one.
constexpr double kMargin_m = 1.0;

Motion MotionAt(const Pass& pass, double time_s) {
  const std::optional<Motion> motion = pass.path.At(time_s);
  if (!motion) throw InputError(pass.id, "the strip lies outside its path");
  return *motion;
}

LookLoss LossOf(Unseen why) {
  switch (why) {
    case Unseen::kBeyondStrip:
      return LookLoss::kBeyondStrip;
    case Unseen::kWrongSide:
      return LookLoss::kWrongSide;
    case Unseen::kBelowHorizon:
      return LookLoss::kBelowHorizon;
    case Unseen::kOutsideSwath:
      break;
  }
  return LookLoss::kOutsideSwath;
}

}  // namespace

std::size_t Visibility::HashCell::operator()(const Cell& cell) const {
  const auto u = [](std::int64_t value) { return static_cast<std::uint64_t>(value); };
  return MixStream(MixStream(u(cell[0]), u(cell[1])), u(cell[2]));
}

Visibility::Visibility(const Frame& frame,
                       const std::vector<NominalPass>& planned,
                       const TerrainSight* terrain)
    : frame_(frame), planned_(planned), terrain_(terrain) {
  double farthest_m = 0.0;
  for (const NominalPass& pass : planned) {
    const Pass& p = pass.pass;
    Reach reach;
    reach.middle_m = MotionAt(p, 0.5 * (p.start_s + p.end_s)).position_m;
    reach.square_m2 = pass.reach_m * pass.reach_m;
    reach.sine_of_squint = std::sin(p.squint_rad);
    const std::array<double, 2> times_s = {p.start_s, p.end_s};
    for (std::size_t end = 0; end < 2; ++end) {
      const Motion motion = MotionAt(p, times_s[end]);
      reach.ends[end] = {motion.position_m, motion.velocity_mps.normalized()};
    }
    reaches_.push_back(reach);
    farthest_m = std::max(farthest_m, pass.reach_m);
  }
  cell_m_ = std::max(1.0, 0.5 * farthest_m);
  for (std::size_t pass = 0; pass < planned.size(); ++pass) {
    const Eigen::Vector3d reach_m = Eigen::Vector3d::Constant(planned[pass].reach_m);
    const Cell low = CellOf(reaches_[pass].middle_m - reach_m);
    const Cell high = CellOf(reaches_[pass].middle_m + reach_m);
    for (Cell cell = low; cell[0] <= high[0]; ++cell[0]) {
      for (cell[1] = low[1]; cell[1] <= high[1]; ++cell[1]) {
        for (cell[2] = low[2]; cell[2] <= high[2]; ++cell[2]) {
          passes_of_[cell].push_back(static_cast<std::uint32_t>(pass));
        }
      }
    }
  }
}

Visibility::Cell Visibility::CellOf(const Eigen::Vector3d& p_m) const {
  Cell cell;
  for (int axis = 0; axis < 3; ++axis) {
    cell[static_cast<std::size_t>(axis)] =
        static_cast<std::int64_t>(std::floor(p_m[axis] / cell_m_));
  }
  return cell;
}

std::optional<LookLoss> Visibility::FindPlainLoss(const Reach& reach,
                                                  const Eigen::Vector3d& p_m) const {
  if ((p_m - reach.middle_m).squaredNorm() > reach.square_m2) return LookLoss::kBeyondReach;
  // The cone error falls along the path: it is not negative at the start, nor positive at the end.
  const Eigen::Vector3d from_start_m = p_m - reach.ends[0].position_m;
  const Eigen::Vector3d from_end_m = p_m - reach.ends[1].position_m;
  const double sine = reach.sine_of_squint;
  const double lean_start_m = sine == 0.0 ? 0.0 : from_start_m.norm() * sine;
  const double lean_end_m = sine == 0.0 ? 0.0 : from_end_m.norm() * sine;
  const bool within = from_start_m.dot(reach.ends[0].ahead) - lean_start_m >= -kMargin_m &&
                      from_end_m.dot(reach.ends[1].ahead) - lean_end_m <= kMargin_m;
  return within ? std::nullopt : std::optional(LookLoss::kBeyondStrip);
}

void Visibility::LooksAt(const Eigen::Vector3d& p_m,
                         std::vector<PlannedLook>* looks,
                         std::vector<LostLook>* lost) const {
  looks->clear();
  lost->clear();
  const auto found = passes_of_.find(CellOf(p_m));
  if (found == passes_of_.end()) return;
  for (const std::uint32_t index : found->second) {
    const Pass& pass = planned_[index].pass;
    std::optional<LookLoss> loss = FindPlainLoss(reaches_[index], p_m);
    if (loss == LookLoss::kBeyondReach) continue;
    if (!loss) {
      Unseen why{};
      const std::optional<double> time_s = TimeSeen(frame_, pass, p_m, &why);
      if (!time_s) {
        loss = LossOf(why);
      } else if (terrain_ != nullptr) {
        loss = terrain_->Hides(MotionAt(pass, *time_s), pass.side, p_m);
      }
      if (!loss) looks->push_back({index, *time_s});
    }
    if (loss) lost->push_back({index, *loss});
  }
}

}  // namespace sarblock
