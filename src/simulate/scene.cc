// SPDX-License-Identifier: Apache-2.0
#include "scene.h"

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

namespace sarblock {
namespace {

using Problem = std::optional<SceneProblem>;

bool Positive(double x) { return std::isfinite(x) && x > 0.0; }
bool NotNegative(double x) { return std::isfinite(x) && x >= 0.0; }
bool Given(double x) { return !std::isnan(x); }

bool AllNotNegative(const std::array<double, 3>& values) {
  return NotNegative(values[0]) && NotNegative(values[1]) && NotNegative(values[2]);
}

constexpr double kLargestSquint_rad = 60.0 * kRadPerDeg;
constexpr std::size_t kMaxPasses = 100000;
constexpr std::size_t kMaxPoints = 100000000;

Problem FindStripsProblem(const SceneFlight& flight, const std::string& field) {
  if (IsByNode(flight)) return {{field + "node_lon_deg", "is for orbits only"}};
  if (!Positive(flight.speed_mps)) return {{field + "speed_mps", "must be given and positive"}};
  if (!std::isfinite(flight.heading_rad)) {
    return {{field + "heading_deg", "must be given, clockwise from north (+y); 90 flies along +x"}};
  }
  if (!flight.start_m.allFinite()) return {{field + "start_m", "must be finite"}};
  if (Given(flight.overlap) && !(flight.overlap >= 0.0 && flight.overlap < 1.0)) {
    return {{field + "overlap", "must be at least 0 and below 1"}};
  }
  if (Given(flight.overlap) && Given(flight.spacing_m)) {
    return {{field + "overlap", "excludes spacing_m; give one of them"}};
  }
  if (flight.segments < 1 || flight.segments > kMaxPasses / flight.count) {
    return {
        {field + "segments",
         "must be 1 at least, and not make more than " + std::to_string(kMaxPasses) + " passes"}};
  }
  if (flight.segments > 1 && !Positive(flight.segment_spacing_m)) {
    return {{field + "segment_spacing_m", "must be given and positive where segments is above 1"}};
  }
  if (flight.count > 1 && !Given(flight.overlap) && !std::isfinite(flight.spacing_m)) {
    return {{field + "spacing_m", "must be given (or overlap) where count is above 1"}};
  }
  return std::nullopt;
}

Problem FindNodeProblem(const SceneFlight& flight, const std::string& field) {
  if (!std::isfinite(flight.node_lon_rad)) {
    return {{field + "node_lon_deg", "must be given and finite for an orbit by its node"}};
  }
  if (!std::isfinite(flight.argument_of_latitude_rad)) {
    return {{field + "argument_of_latitude_deg",
             "must be given and finite for an orbit by its node, from the ascending node to the "
             "middle of the strip; 90 is farthest north"}};
  }
  if (Given(flight.node_spacing_rad) ? !std::isfinite(flight.node_spacing_rad) : flight.count > 1) {
    return {{field + "node_spacing_deg", "must be given and finite where count is above 1"}};
  }
  if (!(flight.inclination_rad >= 0.0 && flight.inclination_rad <= 180.0 * kRadPerDeg)) {
    return {{field + "inclination_deg", "must be given, from 0 to 180"}};
  }
  return std::nullopt;
}

Problem FindAimProblem(const SceneFlight& flight, const std::string& field) {
  if (!(flight.inclination_rad > 0.0 && flight.inclination_rad < 180.0 * kRadPerDeg)) {
    return {{field + "inclination_deg", "must be given, above 0 and below 180"}};
  }
  if (flight.count > 1 && !std::isfinite(flight.spacing_m)) {
    return {{field + "spacing_m", "must be given where count is above 1"}};
  }
  if (!flight.aim_m.allFinite()) return {{field + "aim_m", "must be finite"}};
  const bool by_swath = flight.swath.kind == SwathKind::kLookAngle && !Given(flight.aim_look_rad);
  if (!by_swath && !(flight.aim_look_rad >= 0.0 && flight.aim_look_rad < 80.0 * kRadPerDeg)) {
    return {{field + "aim_look_deg", "must be given for this swath, at least 0 and below 80"}};
  }
  return std::nullopt;
}

Problem FindOrbitProblem(const Scene& scene, const SceneFlight& flight, const std::string& field) {
  if (scene.frame.kind() != FrameKind::kGeocentric) {
    return {{field + "pattern", "an orbit needs a geocentric frame; allowed here: strips"}};
  }
  if (Given(flight.speed_mps) && !Positive(flight.speed_mps)) {
    return {{field + "speed_mps", "must be positive"}};
  }
  if (Given(flight.overlap)) {
    return {{field + "overlap", "is for strips only; give spacing_m"}};
  }
  if (flight.segments != 1) return {{field + "segments", "is for strips only"}};
  return IsByNode(flight) ? FindNodeProblem(flight, field) : FindAimProblem(flight, field);
}

Problem FindFlightProblem(const Scene& scene, const SceneFlight& flight, const std::string& field) {
  if (flight.id.empty()) return {{field + "id", "must not be empty"}};
  if (flight.count < 1 || flight.count > kMaxPasses) {
    return {{field + "count", "must be from 1 to " + std::to_string(kMaxPasses)}};
  }
  if (!Positive(flight.height_m)) return {{field + "height_m", "must be given and positive"}};
  if (!Positive(flight.length_m)) return {{field + "length_m", "must be given and positive"}};
  if (!Positive(flight.state_spacing_s)) return {{field + "state_spacing_s", "must be positive"}};
  if (!std::isfinite(flight.start_s)) return {{field + "start_s", "must be finite"}};
  if (!(std::abs(flight.squint_rad) <= kLargestSquint_rad)) {
    return {{field + "squint_deg", "must be from -60 to 60"}};
  }
  if (const auto problem = ProblemOf(flight.swath)) {
    return {{field + "swath", *problem + ", as swath_look_deg, swath_ground_m or swath_range_m"}};
  }
  if (scene.looks.doppler && !Positive(flight.wavelength_m)) {
    return {{field + "wavelength_m", "must be given and positive for Doppler looks"}};
  }
  if (Given(flight.range_sigma_m) && !Positive(flight.range_sigma_m)) {
    return {{field + "range_sigma_m", "must be positive"}};
  }
  if (Given(flight.azimuth_sigma_m) && !Positive(flight.azimuth_sigma_m)) {
    return {{field + "azimuth_sigma_m", "must be positive"}};
  }
  if (scene.looks.image && (Given(flight.range_sigma_m) || Given(flight.azimuth_sigma_m))) {
    return {{field + "range_sigma_m", "is excluded, as azimuth_sigma_m is, by [looks.image]"}};
  }
  return flight.pattern == SceneFlight::Pattern::kStrips ? FindStripsProblem(flight, field)
                                                         : FindOrbitProblem(scene, flight, field);
}

Problem FindFlightsProblem(const Scene& scene) {
  if (scene.flights.empty()) return {{"flight", "needs one [[flight]] at least"}};
  std::set<std::string> ids;
  for (std::size_t i = 0; i < scene.flights.size(); ++i) {
    const SceneFlight& flight = scene.flights[i];
    const std::string field = "flight." + std::to_string(i) + ".";
    if (Problem problem = FindFlightProblem(scene, flight, field)) return problem;
    for (std::size_t k = 0; k < flight.count * flight.segments; ++k) {
      const std::string id = PassId(flight, k / flight.segments, k % flight.segments);
      if (!ids.insert(id).second) return {{field + "id", "makes the pass id " + id + " twice"}};
    }
  }
  return std::nullopt;
}

Problem FindTrajectoryErrorProblem(const SceneTrajectoryError& trajectory_error) {
  if (!AllNotNegative(trajectory_error.rms_m))
    return {{"wander.rms_m", "must be zero or positive"}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (trajectory_error.rms_m[axis] > 0.0 && !Positive(trajectory_error.time_constant_s[axis])) {
      return {{"wander.time_constant_s", "must be given and positive where rms_m is above 0"}};
    }
  }
  if (trajectory_error.table_time_s.empty()) return std::nullopt;
  bool grows = trajectory_error.table_time_s.size() >= 2 &&
               std::isfinite(trajectory_error.table_time_s.front()) &&
               trajectory_error.table_time_s.size() == trajectory_error.table_m.size();
  for (std::size_t i = 0; grows && i < trajectory_error.table_m.size(); ++i) {
    grows = trajectory_error.table_m[i].allFinite() &&
            std::isfinite(trajectory_error.table_time_s[i]) &&
            (i == 0 || trajectory_error.table_time_s[i] > trajectory_error.table_time_s[i - 1]);
  }
  if (!grows) return {{"wander.table", "needs two rows at least, finite and of increasing times"}};
  return std::nullopt;
}

Problem FindRecorderProblem(const SceneRecorder& recorder) {
  const std::string field = "recorder.";
  const std::string bound = "must be zero or positive";
  if (Given(recorder.rate_hz) && !(recorder.rate_hz >= 0.01 && recorder.rate_hz <= 200.0)) {
    return {{field + "rate_hz", "must be from 0.01 to 200"}};
  }
  if (!NotNegative(recorder.noise_m)) return {{field + "noise_m", bound}};
  if (!NotNegative(recorder.noise_mps)) return {{field + "noise_mps", bound}};
  if (!AllNotNegative(recorder.drift_sigma_mps)) return {{field + "drift_sigma_mps", bound}};
  if (!AllNotNegative(recorder.velocity_bias_sigma_mps)) {
    return {{field + "velocity_bias_sigma_mps", bound}};
  }
  if (!NotNegative(recorder.jump_m)) return {{field + "jump_m", bound}};
  if (recorder.jump_m > 0.0 && !Positive(recorder.jump_interval_s)) {
    return {{field + "jump_interval_s", "must be given and positive where jump_m is above 0"}};
  }
  if (!std::isfinite(recorder.time_offset_s)) return {{field + "time_offset_s", "must be finite"}};
  const StateNoise& sigma = recorder.reading.sigma;
  if (Given(sigma.position_m) && !Positive(sigma.position_m)) {
    return {{field + "sigma_m", "must be positive"}};
  }
  if (Given(sigma.velocity_mps) && !Positive(sigma.velocity_mps)) {
    return {{field + "sigma_mps", "must be positive"}};
  }
  return std::nullopt;
}

Problem FindNavigationProblem(const SceneNavigation& navigation) {
  using Process = SceneNavigation::Process;
  const std::string field = "navigation.";
  const std::string bound = "must be zero or positive";
  if (!AllNotNegative(navigation.constant_sigma_m)) return {{field + "constant_sigma_m", bound}};
  if (!AllNotNegative(navigation.drift_sigma_m)) return {{field + "drift_sigma_m", bound}};
  if (!AllNotNegative(navigation.curvature_sigma_m)) return {{field + "curvature_sigma_m", bound}};
  if (!AllNotNegative(navigation.process_sigma_m)) return {{field + "process_sigma_m", bound}};
  if (navigation.process != Process::kNone && !Positive(navigation.knot_spacing_s)) {
    return {{field + "knot_spacing_s", "must be given and positive for a process"}};
  }
  if (navigation.process == Process::kGaussMarkov && !Positive(navigation.correlation_time_s)) {
    return {{field + "correlation_time_s", "must be given and positive for gauss-markov"}};
  }
  if (!NotNegative(navigation.range_bias_sigma_m)) return {{field + "range_bias_sigma_m", bound}};
  if (!NotNegative(navigation.range_scale_sigma)) {
    return {{field + "range_scale_sigma_ppm", bound}};
  }
  if (!NotNegative(navigation.time_bias_sigma_s)) return {{field + "time_bias_sigma_s", bound}};
  if (!NotNegative(navigation.squint_bias_sigma_rad)) {
    return {{field + "squint_bias_sigma_deg", bound}};
  }
  return std::nullopt;
}

Problem FindLooksProblem(const SceneLooks& looks) {
  if (looks.image) {
    if (Problem problem = FindImageProblem(*looks.image)) {
      return {{"looks.image." + problem->field, problem->problem}};
    }
    if (Given(looks.range_sigma_m) || looks.azimuth.azimuth_unit != AzimuthUnit::kMetres ||
        Given(looks.azimuth.azimuth)) {
      return {{"looks.image", "stands in place of range_sigma_m and the sigma of the azimuth"}};
    }
  } else if (!Positive(looks.range_sigma_m)) {
    return {{"looks.range_sigma_m", "must be given and positive"}};
  } else if (!Positive(looks.azimuth.azimuth)) {
    return {{"looks.azimuth_sigma_m",
             "must be given and positive (or azimuth_sigma_s, or doppler_sigma_hz)"}};
  }
  if (looks.azimuth.azimuth_unit == AzimuthUnit::kHertz && !looks.doppler) {
    return {{"looks.doppler_sigma_hz", "needs cone = \"doppler\": squints are not measured"}};
  }
  if (!NotNegative(looks.noise_scale)) return {{"looks.noise_scale", "must be zero or positive"}};
  if (!(looks.blunder_fraction >= 0.0 && looks.blunder_fraction < 1.0)) {
    return {{"looks.blunder_fraction", "must be at least 0 and below 1"}};
  }
  if (!NotNegative(looks.blunder_size)) {
    return {{"looks.blunder_size", "must be zero or positive, in sigmas"}};
  }
  return std::nullopt;
}

bool Grows(const std::array<double, 2>& interval_m) {
  return std::isfinite(interval_m[0]) && std::isfinite(interval_m[1]) &&
         interval_m[0] < interval_m[1];
}

Problem FindPointsProblem(const Scene& scene) {
  const ScenePoints& points = scene.points;
  if (points.count > kMaxPoints) return {{"points.count", "must not exceed 100 million"}};
  if (!Grows(points.east_m)) return {{"points.east_m", "must be given as [from, to], from < to"}};
  if (!Grows(points.north_m)) return {{"points.north_m", "must be given as [from, to], from < to"}};
  if (!std::isfinite(scene.terrain.height_m)) return {{"terrain.height_m", "must be finite"}};
  if (!NotNegative(scene.terrain.relief_m)) {
    return {{"terrain.relief_m", "must be zero or positive"}};
  }
  if (!Positive(scene.terrain.correlation_m)) {
    return {{"terrain.correlation_m", "must be positive"}};
  }
  return std::nullopt;
}

Problem FindKnownProblem(const SceneControl& known, const std::string& field) {
  using Layout = SceneControl::Layout;
  if (known.layout == Layout::kNone) return std::nullopt;
  if (known.count < 1 || known.count > kMaxPoints) {
    return {{field + "count", "must be 1 at least"}};
  }
  if (known.layout == Layout::kCorners && known.count > 4) {
    return {{field + "count", "must not exceed 4 for corners; allowed: perimeter, grid, ..."}};
  }
  if (known.layout == Layout::kPlaces && known.count > known.places_m.size()) {
    return {{field + "count", "must not exceed the number of places_m"}};
  }
  for (const Eigen::Vector2d& place_m : known.places_m) {
    if (!place_m.allFinite()) return {{field + "places_m", "must be finite"}};
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (known.fixed[axis] && !Positive(known.sigma_m[axis])) {
      return {{field + "sigma_m", "must be given and positive for every fixed component"}};
    }
  }
  if (!known.fixed[0] && !known.fixed[1] && !known.fixed[2]) {
    return {{field + "components", "must name one of e, n, u at least"}};
  }
  const auto given = [](const std::array<double, 2>& interval_m) {
    return !std::isnan(interval_m[0]) || !std::isnan(interval_m[1]);
  };
  if (given(known.east_m) && !Grows(known.east_m)) {
    return {{field + "east_m", "must be [from, to], from < to"}};
  }
  if (given(known.north_m) && !Grows(known.north_m)) {
    return {{field + "north_m", "must be [from, to], from < to"}};
  }
  if (!(known.inset >= 0.0 && known.inset < 0.5)) {
    return {{field + "inset", "must be at least 0 and below 0.5"}};
  }
  if (!NotNegative(known.noise_scale)) {
    return {{field + "noise_scale", "must be zero or positive"}};
  }
  if (!NotNegative(known.approximate_sigma_m)) {
    return {{field + "approximate_sigma_m", "must be zero or positive"}};
  }
  return std::nullopt;
}

std::vector<std::string> PassIds(const Scene& scene) {
  std::vector<std::string> ids;
  for (const SceneFlight& flight : scene.flights) {
    for (std::size_t p = 0; p < flight.count * flight.segments; ++p) {
      ids.push_back(PassId(flight, p / flight.segments, p % flight.segments));
    }
  }
  return ids;
}

}  // namespace

std::optional<SceneProblem> FindImageProblem(const SceneImage& image) {
  if (!Positive(image.bandwidth_hz)) return {{"bandwidth_mhz", "must be given and positive"}};
  if (!Positive(image.azimuth_resolution_m)) {
    return {{"azimuth_resolution_m", "must be given and positive"}};
  }
  if (!(std::abs(image.snr_db) <= 100.0)) {
    return {{"snr_db", "must be given, from -100 to 100"}};
  }
  if (!(image.snr_incidence_rad > 0.0 && image.snr_incidence_rad < 90.0 * kRadPerDeg)) {
    return {{"snr_incidence_deg", "must be above 0 and below 90"}};
  }
  if (!(image.backscatter_exponent >= 0.0 && image.backscatter_exponent <= 100.0)) {
    return {{"backscatter_exponent", "must be from 0 to 100"}};
  }
  if (!std::isnan(image.window_m) && !Positive(image.window_m)) {
    return {{"window_m", "must be positive; left out for reflectors"}};
  }
  if (!(image.correlation > 0.0 && image.correlation < 1.0)) {
    return {{"correlation", "must be above 0 and below 1"}};
  }
  if (!(image.slope_rms >= 0.0 && std::isfinite(image.slope_rms))) {
    return {{"slope_rms", "must be zero or positive"}};
  }
  return std::nullopt;
}

std::optional<SceneProblem> FindProblem(const Scene& scene) {
  if (scene.name.empty()) return {{"name", "must not be empty"}};
  if (scene.frame.kind() == FrameKind::kGeocentric &&
      !(std::abs(scene.centre.lat_rad) <= 90.0 * kRadPerDeg &&
        std::isfinite(scene.centre.lon_rad))) {
    return {{"frame.centre_lat_deg", "must be between -90 and 90, with a finite longitude"}};
  }
  if (Given(scene.rotation_rad_per_s) && !std::isfinite(scene.rotation_rad_per_s)) {
    return {{"frame.rotation_rad_per_s", "must be finite"}};
  }
  if (Problem problem = FindFlightsProblem(scene)) return problem;
  if (Problem problem = FindTrajectoryErrorProblem(scene.trajectory_error)) return problem;
  if (scene.recorder) {
    if (Problem problem = FindRecorderProblem(*scene.recorder)) return problem;
  }
  if (Problem problem = FindNavigationProblem(scene.navigation)) return problem;
  if (!scene.navigation.joint.empty()) {
    const auto problem = FindJointProblem(scene.navigation.joint, PassIds(scene));
    if (problem) return {{problem->key, problem->problem}};
  }
  if (Problem problem = FindLooksProblem(scene.looks)) return problem;
  if (Problem problem = FindPointsProblem(scene)) return problem;
  if (Problem problem = FindKnownProblem(scene.control, "control.")) return problem;
  return FindKnownProblem(scene.check, "check.");
}

bool SceneTrajectoryError::Given() const {
  return rms_m[0] > 0.0 || rms_m[1] > 0.0 || rms_m[2] > 0.0 || !table_time_s.empty();
}

bool IsByNode(const SceneFlight& flight) {
  return Given(flight.node_lon_rad) || Given(flight.argument_of_latitude_rad) ||
         Given(flight.node_spacing_rad);
}

bool IsRecorded(const Scene& scene) { return scene.recorder || scene.trajectory_error.Given(); }

double RecordedSpacing_s(const Scene& scene, const SceneFlight& flight) {
  const bool by_rate = scene.recorder && Given(scene.recorder->rate_hz);
  return by_rate ? 1.0 / scene.recorder->rate_hz : flight.state_spacing_s;
}

std::string PassId(const SceneFlight& flight, std::size_t strip, std::size_t segment) {
  std::string id = flight.id;
  if (flight.count > 1) id += std::to_string(strip + 1);
  if (flight.segments > 1) id += "-" + std::to_string(segment + 1);
  return id;
}

void Validate(const Scene& scene) {
  if (const Problem problem = FindProblem(scene)) {
    throw InputError(problem->field, problem->problem);
  }
}

Eigen::Vector3d FrameFromPlane(const Scene& scene,
                               const Eigen::Vector2d& plane_m,
                               double height_m) {
  if (scene.frame.kind() == FrameKind::kLocal) return {plane_m.x(), plane_m.y(), height_m};
  const Eigen::Vector3d origin_m =
      scene.frame.FrameFromGeodetic({scene.centre.lat_rad, scene.centre.lon_rad, 0.0});
  const Eigen::Matrix3d enu_from_frame = scene.frame.EnuFromFrame(origin_m);
  const Eigen::Vector3d tangent_m(plane_m.x(), plane_m.y(), 0.0);
  return scene.frame.AtHeight(origin_m + enu_from_frame.transpose() * tangent_m, height_m);
}

namespace {

constexpr int kMaxDrawnDegree = 2;
constexpr std::array<const char*, 4> kDrawnBiases = {
    "range.bias", "range.scale", "time.bias", "squint.bias"};

}  // namespace

std::optional<DrawnParameter> ParseDrawn(const JointPrior& prior, const std::string& name) {
  const auto* const bias = std::find(kDrawnBiases.begin(), kDrawnBiases.end(), name);
  if (bias != kDrawnBiases.end()) {
    return DrawnParameter{{}, {}, static_cast<DrawnBias>(bias - kDrawnBiases.begin())};
  }
  std::vector<JointPrior::Axes> tried{prior.axes};
  if (prior.axes == JointPrior::Axes::kCorrection) {
    tried = {JointPrior::Axes::kTrack, JointPrior::Axes::kFrame};
  }
  for (const JointPrior::Axes axes : tried) {
    const auto position = ParsePositionName(name, axes);
    if (position && position->degree <= kMaxDrawnDegree) return DrawnParameter{position, axes, {}};
  }
  return std::nullopt;
}

std::optional<JointErrorProblem> FindJointProblem(const std::vector<JointPrior>& joint,
                                                  const std::vector<std::string>& passes) {
  for (const JointPrior& prior : joint) {
    const std::string key = "navigation." + KeyOf(prior);
    if (const auto problem = FindOwnProblem(prior)) {
      return JointErrorProblem{key + "." + problem->field, problem->problem};
    }
    for (const std::string& pass : prior.passes) {
      if (std::find(passes.begin(), passes.end(), pass) != passes.end()) continue;
      return JointErrorProblem{
          key + ".passes",
          "no pass '" + pass + "' in the scene" + DidYouMean(NearestName(pass, passes))};
    }
    for (const std::string& name : prior.parameters) {
      if (ParseDrawn(prior, name)) continue;
      return JointErrorProblem{
          key + ".parameters",
          "'" + name +
              "' cannot be drawn, position parameters of degree 0 to 2 in the axes given, "
              "range.bias, range.scale, time.bias and squint.bias can"};
    }
  }
  return std::nullopt;
}

JointSigmas SumJointSigmas(const std::vector<JointPrior>& joint) {
  constexpr std::array<double, 3> kEndSlopes = {0.0, 1.0, 3.0};  // of Legendre polynomials
  JointSigmas out;
  for (const JointPrior& prior : joint) {
    const Eigen::VectorXd sigma = prior.Covariance().matrix().diagonal().cwiseSqrt();
    for (std::size_t i = 0; i < prior.parameters.size(); ++i) {
      const double own = sigma[static_cast<Eigen::Index>(i)];
      const auto drawn = ParseDrawn(prior, prior.parameters[i]);
      if (!drawn) continue;
      if (drawn->position) {
        out.shift_m += own;
        out.end_slope_m += own * kEndSlopes[static_cast<std::size_t>(drawn->position->degree)];
      } else if (drawn->bias == DrawnBias::kTime) {
        out.time_bias_s += own;
      } else if (drawn->bias == DrawnBias::kSquint) {
        out.squint_bias_rad += own;
      }
    }
  }
  return out;
}

namespace {

constexpr double kLightSpeed_mps = 299792458.0;
constexpr double kEdge_rad = std::numbers::pi / 180.0;
/// Full width at half maximum of a Gaussian curve over its standard deviation, sqrt(8 ln 2).
constexpr double kFullWidth = 2.3548200450309493;

double Bounded(double local_incidence_rad) {
  return std::clamp(local_incidence_rad, kEdge_rad, 0.5 * std::numbers::pi - kEdge_rad);
}

/// Signal over noise of ground at a local incidence.
double SignalToNoise(const SceneImage& image, double local_incidence_rad) {
  const double falls = std::cos(Bounded(local_incidence_rad)) / std::cos(image.snr_incidence_rad);
  return std::pow(10.0, 0.1 * image.snr_db) * std::pow(falls, image.backscatter_exponent);
}

}  // namespace

ImageView ViewOf(const Frame& frame,
                 const Eigen::Vector3d& point_m,
                 const Eigen::Vector3d& normal,
                 const Eigen::Vector3d& antenna_m) {
  const Eigen::Vector3d sight = (antenna_m - point_m).normalized();
  const Eigen::Vector3d enu = frame.EnuFromFrame(point_m) * sight;
  ImageView view;
  view.local_incidence_rad =
      std::atan2(normal.cross(sight).norm(), std::max(0.0, normal.dot(sight)));
  const double level = enu.head<2>().norm();
  if (level > 0.0) view.parallax = -enu.head<2>() * (enu[2] / (level * level));
  return view;
}

ImageSigma SigmaOfMatch(const SceneImage& image, const ImageView& view, const ImageView& other) {
  const double range_m = 0.5 * kLightSpeed_mps / image.bandwidth_hz;
  if (std::isnan(image.window_m)) {
    const double part = std::sqrt(1.5 * std::pow(10.0, -0.1 * image.snr_db)) / std::numbers::pi;
    return {part * range_m, part * image.azimuth_resolution_m};
  }
  const double sine = std::sin(Bounded(view.local_incidence_rad));
  const double sine_of_other = std::sin(Bounded(other.local_incidence_rad));
  const double cells = std::max(
      1.0, image.window_m * image.window_m * sine / (range_m * image.azimuth_resolution_m));
  double correlation =
      image.correlation / std::sqrt((1.0 + 1.0 / SignalToNoise(image, view.local_incidence_rad)) *
                                    (1.0 + 1.0 / SignalToNoise(image, other.local_incidence_rad)));
  const double smear_m =
      image.slope_rms * image.window_m / std::sqrt(12.0) * (view.parallax - other.parallax).norm();
  const double texture_m = 0.5 * (range_m / sine + range_m / sine_of_other) / kFullWidth;
  correlation /= std::hypot(1.0, smear_m / texture_m);
  // 1/sqrt(2) of the sigma of the shift between both images, which share its variance.
  const double part = std::sqrt(1.5 / cells) * std::sqrt(1.0 - correlation * correlation) /
                      (std::numbers::pi * correlation * std::numbers::sqrt2);
  return {part * range_m, part * image.azimuth_resolution_m};
}

LookSigma SigmaOfPass(const SceneLooks& looks) {
  LookSigma out = looks.azimuth;
  out.range_m = looks.range_sigma_m;
  if (looks.image) {
    const ImageView level{looks.image->snr_incidence_rad, Eigen::Vector2d::Zero()};
    const ImageSigma sigma = SigmaOfMatch(*looks.image, level, level);
    out.range_m = sigma.range_m;
    out.azimuth = sigma.azimuth_m;
    out.azimuth_unit = AzimuthUnit::kMetres;
  }
  return out;
}

}  // namespace sarblock
