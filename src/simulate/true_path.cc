// SPDX-License-Identifier: Apache-2.0
#include "true_path.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "geometry/track_axes.h"
#include "linear/dense.h"
#include "scene.h"
#include <Eigen/Core>

namespace sarblock {

TrajectoryError::TrajectoryError(const SceneTrajectoryError& scene,
                                 const Pass& planned,
                                 std::size_t pass_index,
                                 std::uint64_t seed)
    : start_s_(planned.start_s) {
  const std::uint64_t stream = MixStream(kTrajectoryErrorStream, pass_index);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (scene.rms_m[axis] > 0.0) {
      process_[axis] = DrawGaussMarkov(scene.rms_m[axis],
                                       scene.time_constant_s[axis],
                                       planned.start_s,
                                       planned.path.start_s(),
                                       planned.path.end_s(),
                                       seed,
                                       MixStream(stream, axis));
    }
    if (scene.table_time_s.empty()) continue;
    std::vector<double> values_m;
    for (const Eigen::Vector3d& offset_m : scene.table_m) {
      values_m.push_back(offset_m[static_cast<Eigen::Index>(axis)]);
    }
    table_[axis] = SmoothCurve::Natural(scene.table_time_s, values_m);
  }
}

TrajectoryError::Offset TrajectoryError::At(double time_s) const {
  Offset offset;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const std::array<double, 4> process = process_[i].At(time_s);
    const std::array<double, 4> table = table_[i].At(time_s - start_s_);
    offset.value_m[axis] = process[0] + table[0];
    offset.first_mps[axis] = process[1] + table[1];
    offset.second_mps2[axis] = process[2] + table[2];
    offset.third_mps3[axis] = process[3] + table[3];
  }
  return offset;
}

SmoothCurve SmoothCurve::Natural(const std::vector<double>& times_s,
                                 const std::vector<double>& values) {
  const std::size_t count = times_s.size();
  std::vector<Node> nodes(count);
  for (std::size_t i = 0; i < count; ++i) nodes[i] = {times_s[i], values[i], 0.0, 0.0};
  const auto span_s = [&](std::size_t i) { return times_s[i + 1] - times_s[i]; };
  const auto slope = [&](std::size_t i) { return (values[i + 1] - values[i]) / span_s(i); };
  // Continuity of the first derivative: h_i-1 m_i-1 + 2 (h_i-1 + h_i) m_i + h_i m_i+1 =
  // 6 (d_i - d_i-1), m the second derivatives, zero at the ends. Elimination without pivoting.
  std::vector<double> above(count, 0.0);
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const double pivot = 2.0 * (span_s(i - 1) + span_s(i)) - span_s(i - 1) * above[i - 1];
    above[i] = span_s(i) / pivot;
    nodes[i].second =
        (6.0 * (slope(i) - slope(i - 1)) - span_s(i - 1) * nodes[i - 1].second) / pivot;
  }
  for (std::size_t i = count - 1; i-- > 1;) nodes[i].second -= above[i] * nodes[i + 1].second;
  for (std::size_t i = 0; i + 1 < count; ++i) {
    nodes[i].first = slope(i) - span_s(i) / 6.0 * (2.0 * nodes[i].second + nodes[i + 1].second);
  }
  const std::size_t last = count - 1;
  nodes[last].first = slope(last - 1) + span_s(last - 1) / 6.0 * nodes[last - 1].second;
  return SmoothCurve(std::move(nodes));
}

std::array<double, 4> SmoothCurve::At(double time_s) const {
  if (nodes_.empty()) return {};
  const auto next =
      std::upper_bound(nodes_.begin(), nodes_.end(), time_s, [](double time, const Node& node) {
        return time < node.time_s;
      });
  if (next == nodes_.begin() || next == nodes_.end()) {
    const Node& end = next == nodes_.begin() ? nodes_.front() : nodes_.back();
    return {end.value + end.first * (time_s - end.time_s), end.first, 0.0, 0.0};
  }
  const Node& a = *(next - 1);
  const Node& b = *next;
  const double h = b.time_s - a.time_s;
  const double u = (time_s - a.time_s) / h;
  const double c1 = a.first * h, c2 = 0.5 * a.second * h * h;
  const double value = b.value - a.value - c1 - c2;  // what the three others must add up to
  const double first = b.first * h - c1 - 2.0 * c2;
  const double second = b.second * h * h - 2.0 * c2;
  const double c3 = 10.0 * value - 4.0 * first + 0.5 * second;
  const double c4 = -15.0 * value + 7.0 * first - second;
  const double c5 = 6.0 * value - 3.0 * first + 0.5 * second;
  return {a.value + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5)))),
          (c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h,
          (2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (h * h),
          (6.0 * c3 + u * (24.0 * c4 + u * 60.0 * c5)) / (h * h * h)};
}

namespace {

/// Nodes in a time constant.
constexpr double kNodes = 64.0;

/// Steps of the process of unit rms and time constant, state (value, first, second derivative).
class UnitProcess {
 public:
  UnitProcess() {
    stationary_ << 1.0, 0.0, -1.0 / 3.0, 0.0, 1.0 / 3.0, 0.0, -1.0 / 3.0, 0.0, 1.0;
    constexpr double kStep = 1.0 / kNodes;
    Eigen::Matrix3d nilpotent;
    nilpotent << 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, -1.0, -3.0, -2.0;
    transition_ = std::exp(-kStep) * (Eigen::Matrix3d::Identity() + kStep * nilpotent +
                                      0.5 * kStep * kStep * nilpotent * nilpotent);
    step_factor_ = FactorOf(stationary_ - transition_ * stationary_ * transition_.transpose());
    stationary_factor_ = FactorOf(stationary_);
  }
  [[nodiscard]] Eigen::Vector3d First(RandomStream* random) const {
    return stationary_factor_ * Normals(random);
  }
  [[nodiscard]] Eigen::Vector3d Next(const Eigen::Vector3d& state, RandomStream* random) const {
    return transition_ * state + step_factor_ * Normals(random);
  }

 private:
  [[nodiscard]] static Eigen::Vector3d Normals(RandomStream* random) {
    Eigen::Vector3d normals;
    for (int i = 0; i < 3; ++i) normals[i] = random->Normal();
    return normals;
  }
  /// Taken from the acceleration down: the variances of a step fall by its square each.
  [[nodiscard]] static Eigen::Matrix3d FactorOf(const Eigen::Matrix3d& covariance) {
    return dense::LowerFactor(covariance.reverse())->reverse();
  }
  Eigen::Matrix3d stationary_, transition_, step_factor_, stationary_factor_;
};

}  // namespace

SmoothCurve DrawGaussMarkov(double rms,
                            double time_constant_s,
                            double start_s,
                            double from_s,
                            double to_s,
                            std::uint64_t seed,
                            std::uint64_t stream) {
  static const UnitProcess process;
  const double step_s = time_constant_s / kNodes;
  const Eigen::Vector3d unit(rms, rms / time_constant_s, rms / (time_constant_s * time_constant_s));
  RandomStream after(seed, MixStream(stream, 0));
  const Eigen::Vector3d middle = process.First(&after);
  // Backwards in time the process is itself with the other sign of the first derivative.
  const Eigen::Vector3d turned(1.0, -1.0, 1.0);
  std::vector<SmoothCurve::Node> nodes;
  const auto append = [&](double time_s, const Eigen::Vector3d& state) {
    const Eigen::Vector3d value = unit.cwiseProduct(state);
    nodes.push_back({time_s, value[0], value[1], value[2]});
  };
  RandomStream before(seed, MixStream(stream, 1));
  Eigen::Vector3d state = turned.cwiseProduct(middle);
  for (double k = 1.0; start_s - (k - 1.0) * step_s > from_s; k += 1.0) {
    state = process.Next(state, &before);
    append(start_s - k * step_s, turned.cwiseProduct(state));
  }
  std::reverse(nodes.begin(), nodes.end());
  append(start_s, middle);
  state = middle;
  for (double k = 1.0; start_s + (k - 1.0) * step_s < to_s; k += 1.0) {
    state = process.Next(state, &after);
    append(start_s + k * step_s, state);
  }
  return SmoothCurve(std::move(nodes));
}

namespace {

bool Covers(const JointPrior& prior, const std::string& pass) {
  return prior.passes.empty() ||
         std::find(prior.passes.begin(), prior.passes.end(), pass) != prior.passes.end();
}

void AddDrawn(const JointPrior& prior,
              const Frame& frame,
              const Pass& pass,
              const Eigen::VectorXd& drawn,
              PassError* error) {
  const std::array<std::array<double, 3>*, 3> track = {
      &error->constant_m, &error->drift_m, &error->curvature_m};
  const std::array<double*, 4> biases = {
      &error->range_bias_m, &error->range_scale, &error->time_bias_s, &error->squint_bias_rad};
  for (std::size_t i = 0; i < prior.parameters.size(); ++i) {
    const double value = drawn[static_cast<Eigen::Index>(i)];
    const auto parameter = ParseDrawn(prior, prior.parameters[i]);
    if (!parameter) continue;
    if (!parameter->position) {
      *biases[static_cast<std::size_t>(parameter->bias)] += value;
      continue;
    }
    const auto degree = static_cast<std::size_t>(parameter->position->degree);
    const int axis = parameter->position->axis;
    if (parameter->axes == JointPrior::Axes::kTrack) {
      (*track[degree])[static_cast<std::size_t>(axis)] += value;
    } else {
      const Eigen::Matrix3d axes =
          FrameFromAxes(frame, pass, parameter->axes, "navigation." + KeyOf(prior) + ".axes");
      error->frame_m[degree] += axes.col(axis) * value;
    }
  }
}

}  // namespace

void AddJointErrors(const std::vector<JointPrior>& joint,
                    const Frame& frame,
                    const Pass& pass,
                    std::size_t pass_index,
                    std::uint64_t seed,
                    PassError* error) {
  RandomStream random(seed, MixStream(kJointStream, pass_index));
  for (const JointPrior& prior : joint) {
    JointPriorTerm term;
    term.name = prior.name;
    term.Set(prior.Covariance().matrix());
    Eigen::VectorXd normal(term.factor.rows());
    for (double& value : normal) value = random.Normal();
    if (Covers(prior, pass.id)) AddDrawn(prior, frame, pass, term.factor * normal, error);
  }
}

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
  error.range_scale = navigation.range_scale_sigma * bias.Normal();
  error.time_bias_s = navigation.time_bias_sigma_s * bias.Normal();
  error.squint_bias_rad = navigation.squint_bias_sigma_rad * bias.Normal();
  AddJointErrors(navigation.joint, frame, pass, pass_index, seed, &error);
  return error;
}

TruePath::TruePath(const Frame& frame,
                   const Pass& pass,
                   const PassError& error,
                   double knot_spacing_s,
                   const TrajectoryError* trajectory_error)
    : frame_(&frame), pass_(&pass), error_(&error), trajectory_error_(trajectory_error) {
  const auto zero = [](const std::array<double, 3>& c) {
    return c[0] == 0.0 && c[1] == 0.0 && c[2] == 0.0;
  };
  if (!error.spline_m[0].empty()) spline_.emplace(pass.start_s, pass.end_s, knot_spacing_s);
  turning_ = !zero(error.constant_m) || !zero(error.drift_m) || !zero(error.curvature_m) || spline_;
  for (const Eigen::Vector3d& coefficient_m : error.frame_m) fixed_ |= !coefficient_m.isZero(0.0);
}

std::optional<Motion> TruePath::At(double time_s) const {
  std::optional<Motion> motion = FlownMotion(*frame_, pass_->path, trajectory_error_, time_s);
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
  motion->position_m += track.axes * c;
  motion->velocity_mps += track.rate * c + track.axes * c_rate;
  motion->acceleration_mps2 +=
      track.acceleration * c + 2.0 * (track.rate * c_rate) + track.axes * c_acceleration;
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
          simulated.TrajectoryErrorOf(pass)};
}

namespace {

Eigen::Vector3d Drawn(const std::array<double, 3>& sigma, RandomStream* random) {
  Eigen::Vector3d drawn;
  for (int axis = 0; axis < 3; ++axis) {
    drawn[axis] = sigma[static_cast<std::size_t>(axis)] * random->Normal();
  }
  return drawn;
}

Eigen::Vector3d Drawn(double sigma, RandomStream* random) {
  return Drawn(std::array{sigma, sigma, sigma}, random);
}

/// Offset of positions that is drawn anew at random times, zero until the first after the start.
class Jumps {
 public:
  Jumps(const SceneRecorder& recorder, double start_s, std::uint64_t seed, std::uint64_t stream)
      : recorder_(recorder), random_(seed, stream), next_s_(start_s) {
    if (recorder.jump_m > 0.0) Wait();
  }
  /// Times must not decrease.
  const Eigen::Vector3d& At(double time_s) {
    while (recorder_.jump_m > 0.0 && time_s >= next_s_) {
      offset_m_ = Drawn(recorder_.jump_m, &random_);
      Wait();
    }
    return offset_m_;
  }

 private:
  void Wait() { next_s_ -= recorder_.jump_interval_s * std::log(random_.Uniform()); }
  const SceneRecorder& recorder_;
  RandomStream random_;
  double next_s_;
  Eigen::Vector3d offset_m_ = Eigen::Vector3d::Zero();
};

}  // namespace

std::optional<Motion> FlownMotion(const Frame& frame,
                                  const FlightPath& planned,
                                  const TrajectoryError* trajectory_error,
                                  double time_s) {
  std::optional<Motion> motion = planned.At(time_s);
  if (!motion || trajectory_error == nullptr) return motion;
  const TrackAxes track = TrackAxesOf(frame, *motion);
  const TrajectoryError::Offset w = trajectory_error->At(time_s);
  motion->position_m += track.axes * w.value_m;
  motion->velocity_mps += track.rate * w.value_m + track.axes * w.first_mps;
  motion->acceleration_mps2 += track.acceleration * w.value_m + 2.0 * (track.rate * w.first_mps) +
                               track.axes * w.second_mps2;
  motion->jerk_mps3 += 3.0 * (track.acceleration * w.first_mps + track.rate * w.second_mps2) +
                       track.axes * w.third_mps3;
  return motion;
}

FlightPath RecordFlight(const Frame& frame,
                        const SceneRecorder& recorder,
                        double spacing_s,
                        const Pass& planned,
                        const TrajectoryError* trajectory_error,
                        std::size_t pass_index,
                        std::uint64_t seed) {
  const std::uint64_t stream = MixStream(kRecorderStream, pass_index);
  RandomStream constants(seed, MixStream(stream, 0));
  const Eigen::Vector3d drift_mps = Drawn(recorder.drift_sigma_mps, &constants);
  const Eigen::Vector3d velocity_bias_mps = Drawn(recorder.velocity_bias_sigma_mps, &constants);
  Jumps jumps(recorder, planned.start_s, seed, MixStream(stream, 1));
  const std::uint64_t noise_stream = MixStream(stream, 2);
  const double middle_s = 0.5 * (planned.start_s + planned.end_s);
  const double offset_s = recorder.time_offset_s;
  const double first = std::ceil((planned.path.start_s() + offset_s - planned.start_s) / spacing_s);
  std::vector<StateVector> states;
  for (double k = first;; k += 1.0) {
    StateVector state;
    state.time_s = planned.start_s + k * spacing_s;
    const double true_s = state.time_s - offset_s;
    const std::optional<Motion> motion = FlownMotion(frame, planned.path, trajectory_error, true_s);
    if (!motion) {
      if (true_s > planned.path.end_s()) break;
      continue;  // the first, by the rounding of its time
    }
    // One stream per state: its numbers do not depend on how many states are before it.
    RandomStream noise(
        seed, MixStream(noise_stream, static_cast<std::uint64_t>(static_cast<std::int64_t>(k))));
    const Eigen::Matrix3d axes = TrackAxesOf(frame, *motion).axes;
    state.position_m = motion->position_m + axes * drift_mps * (true_s - middle_s) +
                       jumps.At(true_s) + Drawn(recorder.noise_m, &noise);
    state.velocity_mps =
        motion->velocity_mps + axes * velocity_bias_mps + Drawn(recorder.noise_mps, &noise);
    states.push_back(state);
  }
  return FlightPath(std::move(states));
}

}  // namespace sarblock
