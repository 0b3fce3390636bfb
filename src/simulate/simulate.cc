// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "block/read_recorded.h"
#include "core/threads.h"
#include "nominal_paths.h"
#include "places.h"
#include "reduction/reduction.h"
#include "scene.h"
#include "true_path.h"

namespace sarblock {
namespace {

void AppendKnown(const SceneControl& known, std::uint32_t point, Points* points) {
  KnownPosition position;
  position.point = point;
  position.fixed = known.fixed;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (known.fixed[i]) {
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
  std::vector<ImageSigma> sigmas;  // by look, of a scene with images
  SceneCoverage coverage;
};

/// The normal of the terrain at a place, frame axes.
Eigen::Vector3d NormalAt(const Scene& scene,
                         const Terrain& terrain,
                         const Eigen::Vector2d& plane_m) {
  const double step_m = 1e-3 * scene.terrain.correlation_m;
  const auto at = [&](double east_m, double north_m) {
    const Eigen::Vector2d place_m = plane_m + Eigen::Vector2d(east_m, north_m);
    return FrameFromPlane(scene, place_m, terrain.HeightAt(place_m));
  };
  return (at(step_m, 0.0) - at(-step_m, 0.0)).cross(at(0.0, step_m) - at(0.0, -step_m));
}

/// Each look is matched with the one that sees the ground most alike.
void AppendSigmas(const SceneImage& image,
                  const std::vector<ImageView>& views,
                  std::vector<ImageSigma>* sigmas) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::size_t alike = i;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < views.size(); ++k) {
      const double differs = (views[k].parallax - views[i].parallax).norm();
      if (k == i || differs >= least) continue;
      least = differs;
      alike = k;
    }
    sigmas->push_back(SigmaOfMatch(image, views[i], views[alike]));
  }
}

/// Counts one point. FillPointsAndLooks() counts by pass what is out of its reach.
void Count(PointRole role,
           bool left_out,
           const std::vector<PlannedLook>& looks,
           const std::vector<LostLook>& lost,
           SceneCoverage* coverage) {
  SceneCoverage::Points& points = coverage->points[static_cast<std::size_t>(role)];
  ++points.placed;
  points.left_out += left_out ? 1U : 0U;
  points.unseen += looks.empty() ? 1U : 0U;
  if (coverage->points_by_looks.size() <= looks.size()) {
    coverage->points_by_looks.resize(looks.size() + 1, 0);
  }
  ++coverage->points_by_looks[looks.size()];
  for (const PlannedLook& look : looks) ++coverage->passes[look.pass].shown;
  LossCounts own{};
  for (const LostLook& look : lost) {
    const auto loss = static_cast<std::size_t>(look.loss);
    ++coverage->passes[look.pass].lost[loss];
    ++own[loss];
  }
  own[static_cast<std::size_t>(LookLoss::kBeyondReach)] =
      coverage->passes.size() - looks.size() - lost.size();
  for (std::size_t i = 0; i < own.size(); ++i) {
    coverage->lost[i] += own[i];
    if (left_out) coverage->lost_of_left_out[i] += own[i];
  }
}

void Add(const SceneCoverage& part, SceneCoverage* coverage) {
  for (std::size_t i = 0; i < part.points.size(); ++i) {
    coverage->points[i].placed += part.points[i].placed;
    coverage->points[i].left_out += part.points[i].left_out;
    coverage->points[i].unseen += part.points[i].unseen;
  }
  if (coverage->points_by_looks.size() < part.points_by_looks.size()) {
    coverage->points_by_looks.resize(part.points_by_looks.size(), 0);
  }
  for (std::size_t i = 0; i < part.points_by_looks.size(); ++i) {
    coverage->points_by_looks[i] += part.points_by_looks[i];
  }
  for (std::size_t i = 0; i < part.lost.size(); ++i) {
    coverage->lost[i] += part.lost[i];
    coverage->lost_of_left_out[i] += part.lost_of_left_out[i];
  }
  for (std::size_t pass = 0; pass < part.passes.size(); ++pass) {
    PassCoverage& own = coverage->passes[pass];
    own.shown += part.passes[pass].shown;
    for (std::size_t i = 0; i < own.lost.size(); ++i) own.lost[i] += part.passes[pass].lost[i];
  }
}

SeenPoints SeePoints(const Scene& scene,
                     const Terrain& terrain,
                     const std::vector<NominalPass>& planned,
                     const Visibility& visibility,
                     const PointPlan& plan,
                     std::size_t begin,
                     std::size_t end) {
  SeenPoints seen;
  seen.coverage.passes.resize(planned.size());
  std::vector<PlannedLook> looks;
  std::vector<ImageView> views;
  std::vector<LostLook> lost;
  for (std::size_t i = begin; i < end; ++i) {
    PlacedPoint point = plan.At(i);
    const Eigen::Vector3d p_m =
        FrameFromPlane(scene, point.plane_m, terrain.HeightAt(point.plane_m));
    visibility.LooksAt(p_m, &looks, &lost);
    // Nobody measures a tie point in one image; control is listed even where no image shows it.
    const bool left_out =
        point.role != PointRole::kControl && looks.size() < scene.points.min_looks;
    Count(point.role, left_out, looks, lost, &seen.coverage);
    if (left_out) continue;
    if (scene.looks.image) {
      const Eigen::Vector3d normal = NormalAt(scene, terrain, point.plane_m);
      views.clear();
      for (const PlannedLook& look : looks) {
        const std::optional<Motion> motion = planned[look.pass].pass.path.At(look.time_s);
        views.push_back(ViewOf(scene.frame, p_m, normal, motion.value().position_m));
      }
      AppendSigmas(*scene.looks.image, views, &seen.sigmas);
    }
    seen.points.push_back(std::move(point));
    seen.position_m.push_back(p_m);
    seen.look_count.push_back(looks.size());
    seen.looks.insert(seen.looks.end(), looks.begin(), looks.end());
  }
  return seen;
}

void Append(const Scene& scene, const SeenPoints& seen, SimulatedBlock* out) {
  Add(seen.coverage, &out->coverage);
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
      if (seen.sigmas.empty()) continue;
      block.looks.range_sigma_m.push_back(seen.sigmas[look].range_m);
      block.looks.azimuth_sigma.push_back(seen.sigmas[look].azimuth_m);
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
  std::optional<TerrainSight> sight;
  if (scene.terrain.hides && !terrain.IsFlat()) sight.emplace(scene, terrain.AsGround());
  const Visibility visibility(out->block.frame, planned, sight ? &*sight : nullptr);
  out->coverage.passes.resize(planned.size());
  const PointPlan plan(scene);
  for (std::size_t first = 0; first < plan.size(); first += kPointsPerRange * kRangesPerStep) {
    Step(progress, "simulate", first, plan.size(), "points");
    const std::size_t count = std::min(plan.size() - first, kPointsPerRange * kRangesPerStep);
    std::vector<SeenPoints> ranges((count + kPointsPerRange - 1) / kPointsPerRange);
    ParallelForChunks(
        count, kPointsPerRange, [&](std::size_t range, std::size_t begin, std::size_t end) {
          ranges[range] =
              SeePoints(scene, terrain, planned, visibility, plan, first + begin, first + end);
        });
    for (const SeenPoints& seen : ranges) Append(scene, seen, out);
  }
  for (PassCoverage& pass : out->coverage.passes) {
    const std::size_t known = std::accumulate(pass.lost.begin(), pass.lost.end(), pass.shown);
    pass.lost[static_cast<std::size_t>(LookLoss::kBeyondReach)] = plan.size() - known;
  }
}

std::string NoLooksProblem(const SceneCoverage& coverage) {
  const std::size_t shadow = coverage.lost[static_cast<std::size_t>(LookLoss::kShadow)];
  const std::size_t layover = coverage.lost[static_cast<std::size_t>(LookLoss::kLayover)];
  if (shadow + layover == 0) {
    return "no point lies in any swath; check area, swath and look side";
  }
  return "no point is seen by enough passes; terrain.visibility takes " + std::to_string(shadow) +
         " looks in shadow and " + std::to_string(layover) + " in layover";
}

}  // namespace

const TrajectoryError* SimulatedBlock::TrajectoryErrorOf(std::size_t pass) const {
  return trajectory_error == nullptr ? nullptr : &(*trajectory_error)[pass];
}

SimulatedBlock Simulate(const Scene& scene, ProgressSink* progress) {
  const CancellationScope scope(progress);
  Validate(scene);
  SimulatedBlock out;
  out.block.name = scene.name;
  out.block.frame = scene.frame;
  const std::vector<NominalPass> planned = PlanPasses(scene);
  FillPointsAndLooks(scene, planned, progress, &out);
  bool squinted = scene.looks.doppler;
  for (const NominalPass& pass : planned) {
    out.block.passes.push_back(pass.pass);
    squinted = squinted || pass.pass.squint_rad != 0.0;
  }
  if (IsRecorded(scene)) out.planned = out.block.passes;
  const std::size_t count = out.block.looks.size();
  if (count == 0) {
    throw InputError("points", NoLooksProblem(out.coverage));
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
  simulated->trajectory_error = nullptr;
  if (scene.trajectory_error.Given()) {
    std::vector<TrajectoryError> trajectory_error;
    for (std::size_t i = 0; i < block.passes.size(); ++i) {
      trajectory_error.emplace_back(scene.trajectory_error, simulated->Planned(i), i, seed);
    }
    simulated->trajectory_error =
        std::make_shared<const std::vector<TrajectoryError>>(std::move(trajectory_error));
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
          block.frame, recorder, spacings_s[i], planned, simulated->TrajectoryErrorOf(i), i, seed);
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
      block.passes[pass].squint_rad + simulated->errors[pass].squint_bias_rad;
  // From the nominal time, never from an earlier draw: the last bits must not depend on history.
  const std::optional<double> time_s = SolveConeTime(
      paths[pass], p_m, Cone{.squint_rad = true_squint_rad}, exact.nominal_time_s[look]);
  const std::optional<Motion> motion = time_s ? paths[pass].At(*time_s) : std::nullopt;
  if (!motion) {
    throw InputError("navigation",
                     "the errors drawn move point " + std::string(block.points.ids[point]) +
                         " out of the path of pass " + block.passes[pass].id +
                         "; allowed are errors small against the strip" +
                         (simulated->trajectory_error == nullptr
                              ? ""
                              : " and trajectory errors that bend the path less than 1/range"));
  }
  exact.time_s[look] = *time_s;
  exact.range_m[look] = (p_m - motion->position_m).norm();
  Cone cone;
  cone.squint_rad = true_squint_rad;
  if (scene.looks.doppler) {
    const double closing_mps =
        motion->velocity_mps.norm() * std::sin(block.passes[pass].squint_rad);
    exact.doppler_hz[look] = 2.0 * closing_mps / block.passes[pass].wavelength_m;
    cone.kind = Cone::Kind::kDoppler;
    cone.closing_mps = closing_mps;
  } else if (!block.looks.cone.empty()) {
    block.looks.cone[look] = block.passes[pass].squint_rad;
  }
  exact.azimuth_rate_mps[look] =
      LookTimeRates(p_m, motion->position_m, motion->velocity_mps, motion->acceleration_mps2, cone)
          .along_mps;
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

/// Adds biases, delays, noise and blunders to the exact looks of points [first, last).
void Measure(const SceneLooks& scene,
             const ReductionOfLooks& delays,
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
      // Every look takes the same five numbers from its stream, for any scene.
      RandomStream random(simulated->measurement_seed, MixStream(point_stream, pass));
      double azimuth = scene.noise_scale * random.Normal();  // in sigmas, as is `range`
      double range = scene.noise_scale * random.Normal();
      const bool blunder = random.Uniform() < scene.blunder_fraction;
      const double size = random.Uniform() < 0.5 ? -scene.blunder_size : scene.blunder_size;
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
      block.looks.range_m[look] = (1.0 + error.range_scale) * exact.range_m[look] +
                                  error.range_bias_m + sigma.range_m * range;
      if (!delays.any()) continue;
      const LookReduction delay = delays.Of(pass,
                                            exact.time_s[look],
                                            block.ConeOf(look),
                                            simulated->truth.points_m[point],
                                            Eigen::Vector3d::Zero());
      block.looks.time_s[look] += delay.Time_s();
      block.looks.range_m[look] += delay.Range_m();
    }
  }
}

/// The models of truth.delay by pass; throws InputError for those that the scene cannot have.
std::vector<ReductionModels> DelaysOf(const Scene& scene, const Block& block) {
  const auto require = [&](const char* table, const std::vector<ReductionModels>& models) {
    const auto problem = FindProblem(block, models);
    if (!problem) return;
    constexpr std::string_view kOfPass = "reduction.";
    const bool of_table = problem->key.starts_with(kOfPass);
    throw InputError(
        of_table ? table + problem->key.substr(kOfPass.size()) : "flight." + problem->key,
        problem->problem);
  };
  std::vector<ReductionModels> delays(block.passes.size(), scene.delay);
  require("truth.delay.", delays);
  require("reduction.", ModelsOf(block));
  return delays;
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
          (known.fixed[i] ? given.noise_scale * given.sigma_m[i] : given.approximate_sigma_m) *
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
    const ReductionOfLooks delays(simulated->block, DelaysOf(scene, simulated->block));
    ParallelForChunks(
        points, kPointsPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
          Measure(scene.looks, delays, begin, end, simulated);
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
