// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/simulate/simulate.h"

#include <cmath>
#include <optional>
#include <string>

#include "block/read_recorded.h"
#include "core/threads.h"
#include "recording.h"
#include "streams.h"
#include "true_path.h"
#include "wander.h"

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 4096;

/// State spacing of each pass of a recorded scene, in their order.
std::vector<double> RecordedSpacings_s(const Scene& scene) {
  std::vector<double> spacings_s;
  for (const SceneFlight& flight : scene.flights) {
    spacings_s.insert(
        spacings_s.end(), flight.count * flight.segments, RecordedSpacing_s(scene, flight));
  }
  return spacings_s;
}

void DrawPaths(const Scene& scene, SimulatedBlock* simulated) {
  Block& block = simulated->block;
  const std::uint64_t seed = simulated->navigation_seed;
  const bool recorded = IsRecorded(scene);
  const std::vector<double> spacings_s =
      recorded ? RecordedSpacings_s(scene) : std::vector<double>();
  simulated->errors.clear();
  simulated->wander = nullptr;
  if (scene.wander.Given()) {
    std::vector<Wander> wander;
    for (std::size_t i = 0; i < block.passes.size(); ++i) {
      wander.emplace_back(scene.wander, simulated->Planned(i), i, seed);
    }
    simulated->wander = std::make_shared<const std::vector<Wander>>(std::move(wander));
  }
  simulated->truth.paths.clear();
  for (std::size_t i = 0; i < block.passes.size(); ++i) {
    const Pass& planned = simulated->Planned(i);
    simulated->errors.push_back(DrawPassError(scene.navigation, block.frame, planned, i, seed));
    if (recorded) {
      const SceneRecorder recorder = scene.recorder.value_or(SceneRecorder{});
      block.passes[i].recorded = {};
      block.passes[i].recorded.asked = recorder.reading;
      block.passes[i].path = RecordFlight(
          block.frame, recorder, spacings_s[i], planned, simulated->WanderOf(i), i, seed);
    }
    simulated->truth.paths.push_back(TruePathOf(scene, *simulated, i).AtNominalTimes());
  }
}

/// Noise-free reading of one look on the true path, and the cone it was taken with.
void SolveLook(const Scene& scene,
               std::size_t point,
               std::size_t look,
               const std::vector<TruePath>& paths,
               SimulatedBlock* simulated) {
  Block& block = simulated->block;
  ExactLooks& exact = simulated->exact;
  const std::uint32_t pass = block.looks.pass[look];
  const Eigen::Vector3d& p_m = simulated->truth.points_m[point];
  const double true_squint_rad =
      simulated->squint_rad[pass] + simulated->errors[pass].squint_bias_rad;
  // From the nominal time, never from an earlier draw: the last bits must not depend on history.
  const std::optional<double> time_s = SolveConeTime(
      paths[pass], p_m, Cone{.squint_rad = true_squint_rad}, exact.nominal_time_s[look]);
  const std::optional<Motion> motion = time_s ? paths[pass].At(*time_s) : std::nullopt;
  if (!motion) {
    throw InputError(
        "navigation",
        "the errors drawn move point " + std::string(block.points.ids[point]) +
            " out of the path of pass " + block.passes[pass].id +
            "; allowed are errors small against the strip" +
            (simulated->wander == nullptr ? ""
                                          : " and a wander that bends the path less than 1/range"));
  }
  exact.time_s[look] = *time_s;
  exact.range_m[look] = (p_m - motion->position_m).norm();
  Cone cone;
  cone.squint_rad = true_squint_rad;
  if (scene.looks.doppler) {
    const double closing_mps = motion->velocity_mps.norm() * std::sin(simulated->squint_rad[pass]);
    exact.doppler_hz[look] = 2.0 * closing_mps / block.passes[pass].wavelength_m;
    cone.kind = Cone::Kind::kDoppler;
    cone.closing_mps = closing_mps;
  } else if (!block.looks.cone.empty()) {
    block.looks.cone[look] = simulated->squint_rad[pass];
  }
  exact.azimuth_rate_mps[look] = std::abs(
      LookTimeRates(p_m, motion->position_m, motion->velocity_mps, motion->acceleration_mps2, cone)
          .doppler_mps);
}

void SolveLooks(const Scene& scene, SimulatedBlock* simulated) {
  std::vector<TruePath> paths;
  for (std::size_t i = 0; i < simulated->block.passes.size(); ++i) {
    paths.push_back(TruePathOf(scene, *simulated, i));
  }
  const std::vector<std::uint64_t>& offsets = simulated->block.looks.offsets;
  const auto solve = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t point = begin; point < end; ++point) {
      for (std::uint64_t look = offsets[point]; look < offsets[point + 1]; ++look) {
        SolveLook(scene, point, look, paths, simulated);
      }
    }
  };
  ParallelForChunks(offsets.size() - 1, kPointsPerChunk, solve);
}

/// Adds biases, noise and blunders to the exact looks of points [first, last).
void Measure(const SceneLooks& scene,
             std::size_t first,
             std::size_t last,
             SimulatedBlock* simulated) {
  Block& block = simulated->block;
  const ExactLooks& exact = simulated->exact;
  const std::vector<std::uint64_t>& offsets = block.looks.offsets;
  for (std::size_t point = first; point < last; ++point) {
    const std::uint64_t point_stream = MixStream(kLookStream, point);
    for (std::uint64_t look = offsets[point]; look < offsets[point + 1]; ++look) {
      const std::uint32_t pass = block.looks.pass[look];
      const PassError& error = simulated->errors[pass];
      const LookSigma sigma = block.SigmaOf(look);
      // Every look takes the same five numbers from its stream, whatever the scene asks for.
      RandomStream random(simulated->measurement_seed, MixStream(point_stream, pass));
      double azimuth = scene.noise_scale_1 * random.Normal();  // in sigmas, as is `range`
      double range = scene.noise_scale_1 * random.Normal();
      const bool blunder = random.Uniform() < scene.blunder_fraction_1;
      const double size = random.Uniform() < 0.5 ? -scene.blunder_size_1 : scene.blunder_size_1;
      const bool coin = random.Uniform() < 0.5;
      using Kind = SceneLooks::BlunderKind;
      const bool in_azimuth =
          scene.blunder_kind == Kind::kAzimuth || (scene.blunder_kind == Kind::kBoth && coin);
      if (blunder) (in_azimuth ? azimuth : range) += size;
      simulated->blunder[look] = blunder ? 1 : 0;
      const double sigma_s = sigma.azimuth_unit == AzimuthUnit::kSeconds ? sigma.azimuth
                             : sigma.azimuth_unit == AzimuthUnit::kMetres
                                 ? sigma.azimuth / exact.azimuth_rate_mps[look]
                                 : 0.0;
      const double sigma_hz = sigma.azimuth_unit == AzimuthUnit::kHertz ? sigma.azimuth : 0.0;
      block.looks.time_s[look] = exact.time_s[look] - error.time_bias_s + sigma_s * azimuth;
      if (!exact.doppler_hz.empty()) {
        block.looks.cone[look] = exact.doppler_hz[look] + sigma_hz * azimuth;
      }
      block.looks.range_m[look] = (1.0 + error.range_scale_1) * exact.range_m[look] +
                                  error.range_bias_m + sigma.range_m * range;
    }
  }
}

void DrawKnown(const Scene& scene, SimulatedBlock* simulated) {
  Points& points = simulated->block.points;
  for (const KnownPosition& known : points.known) {
    const bool control = points.role[known.point] == PointRole::kControl;
    const SceneControl& given = control ? scene.control : scene.check;
    RandomStream random(simulated->control_seed, MixStream(kKnownStream, known.point));
    Eigen::Vector3d error_enu_m;
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      error_enu_m[axis] =
          (known.held[i] ? given.noise_scale_1 * given.sigma_m[i] : given.approximate_sigma_m) *
          random.Normal();
    }
    const Eigen::Vector3d& p_m = simulated->truth.points_m[known.point];
    points.given_m[known.point] =
        p_m + simulated->block.frame.EnuFromFrame(p_m).transpose() * error_enu_m;
  }
}

}  // namespace

void Redraw(const Scene& scene,
            std::uint64_t seed,
            const RedrawChoice& choice,
            SimulatedBlock* simulated) {
  if (choice.navigation) {
    simulated->navigation_seed = seed;
    DrawPaths(scene, simulated);
    SolveLooks(scene, simulated);
  }
  if (choice.measurements) simulated->measurement_seed = seed;
  if (choice.measurements || choice.navigation) {
    const std::size_t points = simulated->block.looks.offsets.size() - 1;
    ParallelForChunks(
        points, kPointsPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
          Measure(scene.looks, begin, end, simulated);
        });
  }
  // Warnings of the recording are for those who read the block.
  if (choice.navigation && IsRecorded(scene)) {
    static_cast<void>(ReadRecordedFlights(&simulated->block));
  }
  if (choice.control) {
    simulated->control_seed = seed;
    DrawKnown(scene, simulated);
  }
}

}  // namespace sarblock
