// SPDX-License-Identifier: Apache-2.0
#include "recording.h"

#include "sarblock/core/statistics.h"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "geometry/track_axes.h"
#include "streams.h"

namespace sarblock {
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
                                  const Wander* wander,
                                  double time_s) {
  std::optional<Motion> motion = planned.At(time_s);
  if (!motion || wander == nullptr) return motion;
  const TrackAxes track = TrackAxesOf(frame, *motion);
  const Wander::Offset w = wander->At(time_s);
  motion->position_m += track.axes_1 * w.value_m;
  motion->velocity_mps += track.rate * w.value_m + track.axes_1 * w.first_mps;
  motion->acceleration_mps2 += track.acceleration * w.value_m + 2.0 * (track.rate * w.first_mps) +
                               track.axes_1 * w.second_mps2;
  motion->jerk_mps3 += 3.0 * (track.acceleration * w.first_mps + track.rate * w.second_mps2) +
                       track.axes_1 * w.third_mps3;
  return motion;
}

FlightPath RecordFlight(const Frame& frame,
                        const SceneRecorder& recorder,
                        double spacing_s,
                        const Pass& planned,
                        const Wander* wander,
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
    const std::optional<Motion> motion = FlownMotion(frame, planned.path, wander, true_s);
    if (!motion) {
      if (true_s > planned.path.end_s()) break;
      continue;  // the first, by the rounding of its time
    }
    // One stream a state: what a state reads does not depend on how many stand before it.
    RandomStream noise(
        seed, MixStream(noise_stream, static_cast<std::uint64_t>(static_cast<std::int64_t>(k))));
    const Eigen::Matrix3d axes = TrackAxesOf(frame, *motion).axes_1;
    state.position_m = motion->position_m + axes * drift_mps * (true_s - middle_s) +
                       jumps.At(true_s) + Drawn(recorder.noise_m, &noise);
    state.velocity_mps =
        motion->velocity_mps + axes * velocity_bias_mps + Drawn(recorder.noise_mps, &noise);
    states.push_back(state);
  }
  return FlightPath(std::move(states));
}

}  // namespace sarblock
