// SPDX-License-Identifier: Apache-2.0
#include "true_path.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>

#include "geometry/track_axes.h"
#include "joint_errors.h"
#include "recording.h"
#include "streams.h"

namespace sarblock {
namespace {

std::vector<double> DrawProcess(const SceneNavigation& navigation,
                                double sigma_m,
                                const UniformSpline& spline,
                                RandomStream* random) {
  using Process = SceneNavigation::Process;
  std::vector<double> values_m(spline.count());
  if (navigation.process == Process::kGaussMarkov) {
    // First-order Gauss-Markov sequence at the knots, started in its stationary state.
    const double phi = std::exp(-spline.spacing_s() / navigation.correlation_time_s);
    double value_m = sigma_m * random->Normal();
    for (double& v : values_m) {
      v = value_m;
      value_m = phi * value_m + sigma_m * std::sqrt(1.0 - phi * phi) * random->Normal();
    }
  } else {
    const double step_m = sigma_m / std::sqrt(static_cast<double>(spline.count() - 1));
    double value_m = 0.0;
    for (double& v : values_m) {
      v = value_m;
      value_m += step_m * random->Normal();
    }
  }
  return values_m;
}

}  // namespace

PassError DrawPassError(const SceneNavigation& navigation,
                        const Frame& frame,
                        const Pass& pass,
                        std::size_t pass_index,
                        std::uint64_t seed) {
  PassError error;
  RandomStream random(seed, MixStream(kPassStream, pass_index));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    error.constant_m[axis] = navigation.constant_sigma_m[axis] * random.Normal();
    error.drift_m[axis] = navigation.drift_sigma_m[axis] * random.Normal();
  }
  if (navigation.process != SceneNavigation::Process::kNone) {
    const UniformSpline spline(pass.start_s, pass.end_s, navigation.knot_spacing_s);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      error.spline_m[axis] =
          DrawProcess(navigation, navigation.process_sigma_m[axis], spline, &random);
    }
  }
  // Last of the pass's stream: scenes without curvature draw as they did.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    error.curvature_m[axis] = navigation.curvature_sigma_m[axis] * random.Normal();
  }
  RandomStream bias(seed, MixStream(kBiasStream, navigation.shared_biases ? 0 : pass_index));
  error.range_bias_m = navigation.range_bias_sigma_m * bias.Normal();
  error.range_scale_1 = navigation.range_scale_sigma_1 * bias.Normal();
  error.time_bias_s = navigation.time_bias_sigma_s * bias.Normal();
  error.squint_bias_rad = navigation.squint_bias_sigma_rad * bias.Normal();
  AddJointErrors(navigation.joint, frame, pass, pass_index, seed, &error);
  return error;
}

TruePath::TruePath(const Frame& frame,
                   const Pass& pass,
                   const PassError& error,
                   double knot_spacing_s,
                   const Wander* wander)
    : frame_(&frame), pass_(&pass), error_(&error), wander_(wander) {
  const auto zero = [](const std::array<double, 3>& c) {
    return c[0] == 0.0 && c[1] == 0.0 && c[2] == 0.0;
  };
  if (!error.spline_m[0].empty()) spline_.emplace(pass.start_s, pass.end_s, knot_spacing_s);
  turning_ = !zero(error.constant_m) || !zero(error.drift_m) || !zero(error.curvature_m) || spline_;
  for (const Eigen::Vector3d& coefficient_m : error.frame_m) fixed_ |= !coefficient_m.isZero(0.0);
}

std::optional<Motion> TruePath::At(double time_s) const {
  std::optional<Motion> motion = FlownMotion(*frame_, pass_->path, wander_, time_s);
  if (!motion || (!turning_ && !fixed_)) return motion;
  Eigen::Vector3d c, c_rate, c_acceleration = Eigen::Vector3d::Zero();
  const double rate = 2.0 / (pass_->end_s - pass_->start_s);  // of strip-normalised time
  const double x = (time_s - pass_->start_s) * rate - 1.0;
  const Motion flown = *motion;
  motion->jerk_mps3.setZero();
  if (fixed_) {
    const std::array<Eigen::Vector3d, 3>& f_m = error_->frame_m;
    motion->position_m += f_m[0] + f_m[1] * x + f_m[2] * (1.5 * x * x - 0.5);
    motion->velocity_mps += (f_m[1] + f_m[2] * 3.0 * x) * rate;
    motion->acceleration_mps2 += f_m[2] * 3.0 * rate * rate;
  }
  if (!turning_) return motion;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    c[axis] = error_->constant_m[i] + error_->drift_m[i] * x +
              error_->curvature_m[i] * (1.5 * x * x - 0.5);
    c_rate[axis] = (error_->drift_m[i] + error_->curvature_m[i] * 3.0 * x) * rate;
    c_acceleration[axis] = error_->curvature_m[i] * 3.0 * rate * rate;
  }
  if (spline_) {
    std::array<double, 4> value{}, first{}, second{};
    const std::size_t start = spline_->Evaluate(time_s, {value, first, second});
    for (int axis = 0; axis < 3; ++axis) {
      const std::vector<double>& coefficients_m = error_->spline_m[static_cast<std::size_t>(axis)];
      for (std::size_t k = 0; k < 4; ++k) {
        c[axis] += value[k] * coefficients_m[start + k];
        c_rate[axis] += first[k] * coefficients_m[start + k];
        c_acceleration[axis] += second[k] * coefficients_m[start + k];
      }
    }
  }
  const TrackAxes track = TrackAxesOf(*frame_, flown);
  motion->position_m += track.axes_1 * c;
  motion->velocity_mps += track.rate * c + track.axes_1 * c_rate;
  motion->acceleration_mps2 +=
      track.acceleration * c + 2.0 * (track.rate * c_rate) + track.axes_1 * c_acceleration;
  return motion;
}

FlightPath TruePath::AtNominalTimes() const {
  std::vector<StateVector> states = pass_->path.states();
  for (StateVector& state : states) {
    const std::optional<Motion> motion = At(state.time_s);
    if (!motion) throw InputError(pass_->id, "a state lies outside its own path");
    state.position_m = motion->position_m;
    state.velocity_mps = motion->velocity_mps;
  }
  return FlightPath(std::move(states));
}

TruePath TruePathOf(const Scene& scene, const SimulatedBlock& simulated, std::size_t pass) {
  return {simulated.block.frame,
          simulated.Planned(pass),
          simulated.errors[pass],
          scene.navigation.knot_spacing_s,
          simulated.WanderOf(pass)};
}

}  // namespace sarblock
