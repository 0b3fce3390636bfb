// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "block/read_recorded.h"
#include "simulate/true_path.h"
#include "stability.h"
#include <Eigen/Geometry>

namespace sarblock {
namespace {

using Eigen::Vector3d;

/// What all paths of a plan are relative to.
struct Ground {
  Frame frame;
  Vector3d middle_m;
  Eigen::Matrix3d enu;
};

Ground GroundOf(const StabilityPlan& plan) {
  if (!plan.orbit) return {Frame::Local(), plan.origin_m, Eigen::Matrix3d::Identity()};
  const Frame frame =
      Frame::Geocentric(plan.body_radius_m > 0.0 ? Ellipsoid{"sphere", plan.body_radius_m, 0.0}
                                                 : NamedEllipsoid("WGS84"));
  const Vector3d middle_m = frame.FrameFromGeodetic({0.713, 0.219, 0.0});
  return {frame, middle_m, frame.EnuFromFrame(middle_m)};
}

Vector3d Direction(double heading_rad) {
  return {std::cos(heading_rad), std::sin(heading_rad), 0.0};
}

/// Flight along a straight line past the middle, with a swing that spans the path once.
StateVector StraightState(const StabilityPlan& plan,
                          const PlannedPass& pass,
                          const Ground& ground,
                          double t_s,
                          double half_s) {
  const Vector3d u = Direction(pass.heading_rad), left(-u.y(), u.x(), 0.0);
  const double rate = 2.9 / half_s, phase = 1.3 * pass.heading_rad + 1e-4 * pass.height_m;
  const double side = static_cast<double>(pass.side);
  StateVector state;
  state.time_s = plan.time_origin_s + t_s;
  state.position_m =
      ground.middle_m + u * (plan.speed_mps * t_s) +
      left * (-side * pass.ground_range_m + plan.swing_m * std::sin(rate * t_s + phase)) +
      Vector3d::UnitZ() * (pass.height_m + 0.7 * plan.swing_m * std::cos(rate * t_s - phase));
  state.velocity_mps =
      u * plan.speed_mps + left * (plan.swing_m * rate * std::cos(rate * t_s + phase)) -
      Vector3d::UnitZ() * (0.7 * plan.swing_m * rate * std::sin(rate * t_s - phase));
  return state;
}

/// Circular orbit abeam of the middle of the area at t = 0, in inertial axes.
StateVector OrbitState(const StabilityPlan& plan,
                       const PlannedPass& pass,
                       const Ground& ground,
                       double t_s) {
  const Vector3d n = ground.middle_m.normalized();
  Vector3d u = ground.enu.transpose() * Direction(pass.heading_rad);
  u = (u - u.dot(n) * n).normalized();
  const double radius_m = ground.middle_m.norm(), r_m = radius_m + pass.height_m;
  const double angle = -static_cast<double>(pass.side) * pass.ground_range_m / radius_m;
  const Vector3d s = std::cos(angle) * n + std::sin(angle) * n.cross(u);
  const double rate = plan.speed_mps / r_m;
  StateVector state;
  state.time_s = plan.time_origin_s + t_s;
  state.position_m = r_m * (std::cos(rate * t_s) * s + std::sin(rate * t_s) * u);
  state.velocity_mps = r_m * rate * (std::cos(rate * t_s) * u - std::sin(rate * t_s) * s);
  return state;
}

/// States from before the first to after the last look, the time zero beside the middle.
FlightPath MakePath(const StabilityPlan& plan, const PlannedPass& pass, const Ground& ground) {
  const double distance_m = std::hypot(pass.ground_range_m, pass.height_m);
  // A straight path is long enough for its swing to turn it by a few degrees at most.
  const double reach_m =
      1.3 * std::hypot(plan.along_m, plan.across_m) + (plan.orbit ? 0.02 : 0.2) * distance_m;
  const double tangent = std::tan(pass.squint_rad);
  // The antenna of a squinted look is behind its point by the distance times the tangent.
  const double middle_s = -distance_m * tangent / plan.speed_mps;
  const double half_s =
      (reach_m * (1.0 + std::abs(tangent)) + 1.3 * plan.relief_m * std::abs(tangent)) /
          plan.speed_mps +
      plan.time_margin_s;
  std::vector<StateVector> states;
  const auto pieces = static_cast<double>(plan.states - 1);
  for (std::size_t k = 0; k < plan.states; ++k) {
    const double t_s = middle_s + half_s * (2.0 * static_cast<double>(k) / pieces - 1.0);
    states.push_back(plan.orbit ? OrbitState(plan, pass, ground, t_s)
                                : StraightState(plan, pass, ground, t_s, half_s));
  }
  return FlightPath(std::move(states));
}

/// Refuses flights whose states would take the memory of a large block.
void RequireFewStates(const Pass& pass, double rate_hz) {
  constexpr double kMostStates = 1e6;
  const double span_s =
      std::max(pass.path.end_s(), pass.end_s) - std::min(pass.path.start_s(), pass.start_s);
  if (!(span_s * rate_hz <= kMostStates)) {
    throw InputError("recorder", "a flight would be more than a million states");
  }
}

constexpr double kFlownSpacing_s = 0.01;

/// The flight with its trajectory error, as states so close that cubics follow it to nanometres.
FlightPath FlownPath(const Frame& frame,
                     const FlightPath& planned,
                     const TrajectoryError& trajectory_error) {
  const auto pieces =
      static_cast<std::size_t>(std::ceil((planned.end_s() - planned.start_s()) / kFlownSpacing_s));
  std::vector<StateVector> states;
  for (std::size_t k = 0; k <= pieces; ++k) {
    const double part = static_cast<double>(k) / static_cast<double>(pieces);
    const double time_s = std::lerp(planned.start_s(), planned.end_s(), part);
    const Motion motion = *FlownMotion(frame, planned, &trajectory_error, time_s);
    states.push_back({time_s, motion.position_m, motion.velocity_mps});
  }
  return FlightPath(std::move(states));
}

/// Puts what the recorder wrote in place of the flight, and reads it as the plan asks for.
void Record(const StabilityPlan& plan, Block* block) {
  for (std::size_t i = 0; i < block->passes.size(); ++i) {
    Pass& pass = block->passes[i];
    const SceneRecorder& recorder = *plan.recorder;
    RequireFewStates(pass, recorder.rate_hz);
    pass.path =
        RecordFlight(block->frame, recorder, 1.0 / recorder.rate_hz, pass, nullptr, i, plan.seed);
    pass.recorded.asked = recorder.reading;
  }
  static_cast<void>(ReadRecordedFlights(block));
}

/// Time and range at which a pass sees a point, to the rounding of the coordinates: Newton within
/// the bracket, for as long as it moves.
std::array<double, 2> Measure(const Pass& pass, const Vector3d& p_m, const Cone& cone) {
  double low_s = pass.path.start_s(), high_s = pass.path.end_s();
  const auto error_m = [&](double at_s) {
    return EvaluateCone(*pass.path.At(at_s), p_m, cone).doppler_error_m;
  };
  if (!(error_m(low_s) >= 0.0 && error_m(high_s) <= 0.0)) {
    throw InputError("pass " + pass.id, "does not see its area");
  }
  double time_s = 0.5 * (low_s + high_s);
  for (int i = 0; i < 200; ++i) {
    const ConeValue at = EvaluateCone(*pass.path.At(time_s), p_m, cone);
    (at.doppler_error_m > 0.0 ? low_s : high_s) = time_s;
    double next_s = time_s - at.doppler_error_m / at.rate_mps;
    if (!(next_s > low_s && next_s < high_s)) next_s = 0.5 * (low_s + high_s);
    if (next_s == time_s || next_s == low_s || next_s == high_s) break;
    time_s = next_s;
  }
  return {time_s, (p_m - pass.path.At(time_s)->position_m).norm()};
}

void AddControl(const StabilityPlan& plan, Block* block, const std::vector<Vector3d>& truth_m) {
  const std::array<double, 3>& sigma_m = plan.control_sigma_m;
  for (const std::size_t point : plan.control_points) {
    block->points.role[point] = PointRole::kControl;
    block->points.given_m[point] = truth_m[point];
    KnownPosition known;
    known.point = static_cast<std::uint32_t>(point);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      known.fixed[i] = true;
      known.covariance_enu_m2(k, k) = sigma_m[i] * sigma_m[i];
    }
    known.covariance_enu_m2(0, 1) = known.covariance_enu_m2(1, 0) =
        plan.control_correlation * sigma_m[0] * sigma_m[1];
    block->points.known.push_back(known);
  }
}

void ShiftFirstPath(double shift_m, Block* block) {
  std::vector<StateVector> states = block->passes.front().path.states();
  for (StateVector& state : states) state.position_m += Vector3d::Constant(shift_m);
  block->passes.front().path = FlightPath(std::move(states));
}

}  // namespace

bool StabilityPlan::IsControl(std::size_t point) const {
  return std::find(control_points.begin(), control_points.end(), point) != control_points.end();
}

std::string StabilityPassId(std::size_t pass) { return "A" + std::to_string(pass + 1); }

Block MakeStabilityBlock(const StabilityPlan& plan) {
  Block block;
  block.name = "stability";
  const Ground ground = GroundOf(plan);
  block.frame = ground.frame;
  for (std::size_t i = 0; i < plan.passes.size(); ++i) {
    Pass pass;
    pass.id = StabilityPassId(i);
    pass.side = plan.passes[i].side;
    if (plan.doppler_wavelength_m > 0.0) pass.wavelength_m = plan.doppler_wavelength_m;
    pass.path = MakePath(plan, plan.passes[i], ground);
    if (plan.trajectory_error.Given()) {
      pass.start_s = pass.path.start_s();
      pass.end_s = pass.path.end_s();
      RequireFewStates(pass, 1.0 / kFlownSpacing_s);
      pass.path = FlownPath(
          block.frame, pass.path, TrajectoryError(plan.trajectory_error, pass, i, plan.seed));
    }
    pass.sigma = plan.sigma;
    pass.sigma.range_m *= plan.passes[i].range_sigma_factor;
    block.passes.push_back(std::move(pass));
  }
  std::vector<Vector3d> truth_m;
  Looks& looks = block.looks;
  for (std::size_t j = 0; j < plan.points; ++j) {
    RandomStream random(plan.seed, j);
    Vector3d place((2.0 * random.Uniform() - 1.0) * plan.along_m,
                   (2.0 * random.Uniform() - 1.0) * plan.across_m,
                   0.0);
    double height_m = random.Uniform() * plan.relief_m;
    if (plan.control_spread < 1.0 && plan.IsControl(j)) {
      place *= plan.control_spread;
      height_m *= plan.control_spread;
    }
    const Vector3d p_m =
        plan.orbit
            ? ground.frame.AtHeight(ground.middle_m + ground.enu.transpose() * place, height_m)
            : Vector3d(ground.middle_m + place + height_m * Vector3d::UnitZ());
    truth_m.push_back(p_m);
    block.points.ids.Append("P" + std::to_string(j + 1));
    block.points.role.push_back(PointRole::kTie);
    Vector3d given_m = Vector3d::Constant(kNotGiven);
    if (plan.start_error_m > 0.0) {
      given_m = p_m + plan.start_error_m * Vector3d(0.61, -0.53, 0.59);
    }
    block.points.given_m.push_back(given_m);
    for (std::size_t i = 0; i < plan.passes.size(); ++i) {
      const Pass& pass = block.passes[i];
      Cone cone;
      cone.squint_rad = plan.passes[i].squint_rad;
      double given = cone.squint_rad;
      if (plan.doppler_wavelength_m > 0.0) {
        given = 2.0 * plan.speed_mps * std::sin(cone.squint_rad) / plan.doppler_wavelength_m;
        cone = {Cone::Kind::kDoppler, 0.0, 0.5 * plan.doppler_wavelength_m * given};
      }
      auto [time_s, range_m] = Measure(pass, p_m, cone);
      RandomStream noise(plan.seed + 1, MixStream(j, i));
      double azimuth_sigma = plan.sigma.azimuth;
      if (plan.sigma.azimuth_unit == AzimuthUnit::kMetres) {
        const Motion at = *pass.path.At(time_s);
        azimuth_sigma /=
            LookTimeRates(p_m, at.position_m, at.velocity_mps, at.acceleration_mps2, cone)
                .along_mps;
      }
      range_m += plan.noise * pass.sigma.range_m * noise.Normal();
      const bool exact_time = plan.sigma.azimuth_unit == AzimuthUnit::kHertz;
      (exact_time ? given : time_s) += plan.noise * azimuth_sigma * noise.Normal();
      if (i == 0 && j == 1) range_m += plan.blunder * pass.sigma.range_m;
      looks.pass.push_back(static_cast<std::uint32_t>(i));
      looks.flags.push_back(plan.doppler_wavelength_m > 0.0 ? std::uint8_t{Looks::kDoppler}
                                                            : std::uint8_t{0});
      looks.time_s.push_back(time_s);
      looks.range_m.push_back(range_m);
      looks.cone.push_back(given);
    }
    looks.offsets.push_back(looks.pass.size());
  }
  AddControl(plan, &block, truth_m);
  std::vector<std::optional<std::array<double, 2>>> spans(block.passes.size());
  SetStripSpans(spans, &block);
  if (plan.strip_factor > 0.0) {
    for (Pass& pass : block.passes) {
      const double middle_s = 0.5 * (pass.start_s + pass.end_s);
      const double half_s = 0.5 * plan.strip_factor * (pass.end_s - pass.start_s);
      pass.start_s = middle_s - half_s;
      pass.end_s = middle_s + half_s;
    }
  }
  if (plan.recorder) Record(plan, &block);
  if (plan.path_error_m != 0.0) ShiftFirstPath(plan.path_error_m, &block);
  return block;
}

std::vector<double> Ratios(double from, double to, int count) {
  std::vector<double> out;
  for (int i = 0; i < count; ++i) {
    const double power = std::log10(from) + std::log10(to / from) * i / (count - 1);
    out.push_back(std::pow(10.0, power));
  }
  return out;
}

}  // namespace sarblock
