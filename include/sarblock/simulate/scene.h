// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/path.h"
#include "sarblock/model/options.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// A group of passes flown alike.
///
/// kStrips: `count` parallel lines at constant height. In the scene plane (x east, y north;
/// `local`: the frame's x, y) the first starts at start_m, the next `spacing_m` to the left of the
/// heading, and so on; each line is flown in `segments` passes of length_m. kOrbit: circular orbits
/// about a geocentric body that rotates, each given by its inclination and, at the middle of its
/// time, either by its aim: pass k sees the scene plane's point aim_m + (k - (count-1)/2) spacing_m
/// east at aim_look_rad; or by its node: pass k is at argument_of_latitude_rad from the ascending
/// node, whose body-fixed longitude then is node_lon_rad + k node_spacing_rad. With w the body's
/// rotation and n the mean motion the pass crosses that node at the longitude node_lon_rad + w
/// argument_of_latitude_rad / n.
struct SceneFlight {
  enum class Pattern { kStrips, kOrbit };
  std::string id;  ///< of the pass if count is 1, else the stem of "id1", "id2", ...
  Pattern pattern = Pattern::kStrips;
  LookSide side = LookSide::kLeft;
  double squint_rad = 0.0;  ///< > 0 looks forward (v.d > 0); |squint| <= 60 deg
  Swath swath;              ///< axes of the nominal path
  std::size_t count = 1;
  double spacing_m = kNotGiven;  ///< needed where count > 1 and no overlap is given
  std::size_t segments = 1;      ///< strips: passes that a line is cut into, one behind the other
  double segment_spacing_m = kNotGiven;  ///< from start to start; needed where segments > 1
  double overlap = kNotGiven;    ///< strips: part of the swath shared with the next, 0 <= . < 1
  double height_m = kNotGiven;   ///< > 0, above the datum (orbit: above the equatorial radius)
  double length_m = kNotGiven;   ///< > 0, imaged length on the ground
  double speed_mps = kNotGiven;  ///< > 0; orbit: inertial, not given = circular orbit's speed
  double start_s = 0.0;          ///< time at which the strip starts
  double state_spacing_s = 1.0;  ///< of the state vectors, at most
  Eigen::Vector2d start_m{0.0, 0.0};   ///< strips
  double heading_rad = kNotGiven;      ///< strips: clockwise from +y (north); 90 deg flies along +x
  double inclination_rad = kNotGiven;  ///< orbit
  bool descending = false;             ///< orbit
  Eigen::Vector2d aim_m{0.0, 0.0};     ///< orbit
  double aim_look_rad = kNotGiven;     ///< orbit; not given: the middle of a look-angle swath
  double node_lon_rad = kNotGiven;     ///< orbit; given: by its node, and nothing of its aim
  double argument_of_latitude_rad = kNotGiven;  ///< orbit; needed with node_lon_rad
  double node_spacing_rad = kNotGiven;          ///< needed with node_lon_rad where count > 1
  double wavelength_m = kNotGiven;              ///< needed for Doppler looks
  double range_sigma_m = kNotGiven;             ///< not given: the scene's
  double azimuth_sigma_m = kNotGiven;           ///< not given: the scene's
  std::string epoch_utc;                        ///< what time 0 is; needed for tides
};

/// How far the given flight paths are from the true ones: true = nominal + A(t) c(t), A the track
/// axes of the nominal path. Every number is a standard deviation of one draw a pass; three values
/// are along, across, up. The process is a sequence of B-spline coefficients (UniformSpline on the
/// strip), so that a spline correction with the same knot spacing can represent it exactly.
struct SceneNavigation {
  enum class Process { kNone, kRandomWalk, kGaussMarkov };
  std::array<double, 3> constant_sigma_m{};   ///< Legendre degree 0
  std::array<double, 3> drift_sigma_m{};      ///< Legendre degree 1: the error gained from the
                                              ///< middle of the strip to its end
  std::array<double, 3> curvature_sigma_m{};  ///< Legendre degree 2: at the ends of the strip
  Process process = Process::kNone;
  std::array<double, 3> process_sigma_m{};  ///< Gauss-Markov: stationary; random walk: reached at
                                            ///< the end of the strip from 0 at its start
  double correlation_time_s = kNotGiven;    ///< Gauss-Markov
  double knot_spacing_s = kNotGiven;        ///< of either process
  double range_bias_sigma_m = 0.0;
  double range_scale_sigma = 0.0;
  double time_bias_sigma_s = 0.0;
  double squint_bias_sigma_rad = 0.0;
  bool shared_biases = false;  ///< one draw of the range, time and squint biases for all passes
  /// Errors with a full covariance, one draw a pass, added to those above. Position parameters of
  /// degree 0 to 2 in track or frame axes, or, along the axes of the middle of the strip, in ric
  /// and ric-inertial axes; the four biases. kCorrection means the axes that the names are of.
  std::vector<JointPrior> joint;
};

/// Time-correlated trajectory errors: flown = planned + A(t) w(t), A the track axes of the planned
/// path, w (along, across, up) the sum of a random process and a table. The process is
/// third-order Gauss-Markov (docs/theory/trajectory_error.md): position, velocity and acceleration
/// with rms s, s/(sqrt(3) T) and s/T^2, steered back to the planned path. Attitude does not enter:
/// the model of a look takes its cone from the velocity.
struct SceneTrajectoryError {
  std::array<double, 3> rms_m{};                                           ///< s
  std::array<double, 3> time_constant_s{kNotGiven, kNotGiven, kNotGiven};  ///< T; needed if s > 0
  /// Offsets of one's own, the same in every pass: seconds from the start of the strip, [m].
  /// Between the rows a natural cubic spline, beyond the first and last its straight continuation.
  std::vector<double> table_time_s;
  std::vector<Eigen::Vector3d> table_m;
  [[nodiscard]] bool Given() const;
};

/// How flights are recorded: the states of a block are those of the flown path at the times of the
/// recorder, with its errors. Not the same as SceneNavigation, which moves the whole true path
/// against what is recorded; a scene may have both. Lists are along, across, up.
struct SceneRecorder {
  double rate_hz = kNotGiven;  ///< 0.01 to 200; not given: 1 / state_spacing_s of the flight
  double noise_m = 0.0;        ///< sigma of each coordinate of each state
  double noise_mps = 0.0;      ///< of each component of each velocity
  std::array<double, 3> drift_sigma_mps{};  ///< one draw a pass: positions move off the velocities'
                                            ///< path, by zero at the middle of the strip
  std::array<double, 3> velocity_bias_sigma_mps{};  ///< one draw a pass
  double jump_m = 0.0;                              ///< sigma of each coordinate after a jump
  double jump_interval_s = kNotGiven;               ///< mean; needed if jump_m > 0
  double time_offset_s = 0.0;                       ///< time stamp minus time, of every state
  TrajectoryOptions reading;                        ///< how the block says that its states be read
};

/// Images from whose resolution, noise and matching follow the standard deviations of looks
/// (docs/theory/measurement.md).
struct SceneImage {
  double bandwidth_hz = kNotGiven;          ///< > 0; the resolution in range is c / (2 B)
  double azimuth_resolution_m = kNotGiven;  ///< > 0
  /// Ratio of powers: ground over noise at snr_incidence_rad, without a window reflector over
  /// clutter.
  double snr_db = kNotGiven;
  double snr_incidence_rad = 0.6108652381980153;  ///< 35 deg
  double backscatter_exponent = 2.0;  ///< >= 0; backscatter is as cos^n of the local incidence
  double window_m = kNotGiven;  ///< > 0, side of a matched window on the ground; NaN: reflectors
  double correlation = 0.15;    ///< of windows seen alike, without noise; 0 < . < 1
  double slope_rms = 0.0;       ///< >= 0, slope of the relief within a window
};

/// What is measured and how well.
struct SceneLooks {
  double range_sigma_m = kNotGiven;
  LookSigma azimuth;         ///< `azimuth` and its unit; range_m is not used
  double noise_scale = 1.0;  ///< multiplies the noise, not the standard deviations; 0: exact looks
  double blunder_fraction = 0.0;  ///< of looks, 0 <= . < 1
  double blunder_size = 20.0;     ///< in sigmas, random sign
  enum class BlunderKind { kRange, kAzimuth, kBoth };
  BlunderKind blunder_kind = BlunderKind::kRange;  ///< kBoth: either one, by a coin
  bool doppler = false;                            ///< write Doppler centroids in place of squints
  std::optional<SceneImage> image;                 ///< in place of the standard deviations above
};

/// Terrain heights over the scene plane: a Gaussian random field (places.h).
struct SceneTerrain {
  enum class Kind { kFlat, kRolling, kRugged };
  Kind kind = Kind::kFlat;
  double height_m = 0.0;          ///< mean
  double relief_m = 0.0;          ///< standard deviation of the heights
  double correlation_m = 5000.0;  ///< correlation exp(-(r/L)^2); rugged: that of its longest octave
  bool hides = false;             ///< looks in shadow or layover are left out
};

/// Where tie points lie: `count` of them in a rectangle of the scene plane.
struct ScenePoints {
  enum class Pattern { kRandom, kGrid };
  std::size_t count = 500;
  Pattern pattern = Pattern::kRandom;
  std::array<double, 2> east_m{};   ///< from, to; `local`: x
  std::array<double, 2> north_m{};  ///< from, to; `local`: y
  std::size_t min_looks = 2;        ///< tie and check points with fewer are left out
};

/// Known points. Coordinates of free components are written with approximate_sigma_m.
struct SceneControl {
  enum class Layout { kNone, kCorners, kPerimeter, kGrid, kChain, kRandom, kPlaces };
  Layout layout = Layout::kNone;
  std::size_t count = 4;
  std::array<double, 3> sigma_m{};  ///< e, n, u; > 0 where fixed
  std::array<bool, 3> fixed{true, true, true};
  /// Area of the layout in the scene plane, from, to; not given: that of the tie points.
  std::array<double, 2> east_m{kNotGiven, kNotGiven};
  std::array<double, 2> north_m{kNotGiven, kNotGiven};
  std::vector<Eigen::Vector2d>
      places_m;              ///< kPlaces: in the scene plane; the first `count` of them
  double inset = 0.1;        ///< from the area's edge, part of its width and height
  double noise_scale = 1.0;  ///< as in SceneLooks
  double approximate_sigma_m = 100.0;
};

/// Everything that defines a simulated block (docs/scenes.md).
struct Scene {
  std::string name;
  std::string purpose;
  std::uint64_t seed = 1;
  Frame frame = Frame::Local();
  Geodetic centre;                        ///< geocentric: origin of the scene plane; h not used
  double rotation_rad_per_s = kNotGiven;  ///< geocentric: of the body; not given: known by its name
  std::vector<SceneFlight> flights;
  SceneTrajectoryError trajectory_error;
  std::optional<SceneRecorder> recorder;
  SceneNavigation navigation;
  SceneLooks looks;
  SceneTerrain terrain;
  ScenePoints points;
  SceneControl control;
  SceneControl check;         ///< layout kRandom by default in files
  ReductionModels delay;      ///< delays contained in the measured values
  ReductionModels reduction;  ///< reductions that the block asks for
  std::string adjust_toml;    ///< the [adjust] table as TOML text with its header; may be empty
};

/// A value that no scene can have. `field` is the dotted key of the scene file
/// ("flight.0.height_m").
struct SceneProblem {
  std::string field;
  std::string problem;
};
[[nodiscard]] std::optional<SceneProblem> FindProblem(const Scene& scene);

/// Whether an orbit is given by its node and not by its aim.
[[nodiscard]] bool IsByNode(const SceneFlight& flight);

/// The states of the block are those of a recorder on the flown path, not the planned path itself.
[[nodiscard]] bool IsRecorded(const Scene& scene);

/// Time from state to state of a recorded flight: 1 / recorder.rate_hz or flight.state_spacing_s.
[[nodiscard]] double RecordedSpacing_s(const Scene& scene, const SceneFlight& flight);

/// Id of the pass of segment m of strip k, both from 0: the flight's id, then k + 1 where there are
/// several strips, then "-" and m + 1 where there are several segments ("L3-7").
[[nodiscard]] std::string PassId(const SceneFlight& flight, std::size_t strip, std::size_t segment);

/// Throws InputError for the first problem.
void Validate(const Scene& scene);

/// Scene plane to frame at height h (local: z): the tangent plane of the scene's centre, projected
/// along the ellipsoid's normal.
[[nodiscard]] Eigen::Vector3d FrameFromPlane(const Scene& scene,
                                             const Eigen::Vector2d& plane_m,
                                             double height_m);

class TrajectoryError;

/// The errors of one pass as drawn, signs as the corrections of model.md, section 3: adding them to
/// the nominal path and measurements gives the truth.
struct PassError {
  std::array<double, 3> constant_m{};           ///< along, across, up
  std::array<double, 3> drift_m{};              ///< times strip-normalised time x
  std::array<double, 3> curvature_m{};          ///< times (3 x^2 - 1) / 2
  std::array<std::vector<double>, 3> spline_m;  ///< B-spline coefficients; empty: no process
  /// Legendre degrees 0 to 2 along the axes of the frame.
  std::array<Eigen::Vector3d, 3> frame_m{
      Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  double range_bias_m = 0.0;
  double range_scale = 0.0;
  double time_bias_s = 0.0;
  double squint_bias_rad = 0.0;
};

/// What the looks would read without noise, by look index of the block.
struct ExactLooks {
  std::vector<double> nominal_time_s;  ///< cone time on the nominal path: the planned look
  std::vector<double> time_s;   ///< cone time on the true path (model time, bias not removed)
  std::vector<double> range_m;  ///< |p - s| there
  std::vector<double> azimuth_rate_mps;  ///< metres along track at the target a second
  std::vector<double> doppler_hz;  ///< Doppler written for it; empty where squints are written
};

/// Why a pass takes no look at a placed point: the first of these that applies. kBeyondReach: the
/// point is farther from the middle of the path than any point of the strip, and is not examined
/// further.
enum class LookLoss {
  kBeyondReach,
  kBeyondStrip,   ///< before the strip's start or after its end
  kWrongSide,     ///< or beneath the path
  kBelowHorizon,  ///< the antenna is not above the horizontal plane at the point
  kOutsideSwath,
  kShadow,  ///< SceneTerrain::hides
  kLayover  ///< SceneTerrain::hides
};
/// Pairs of a point and a pass, by LookLoss.
using LossCounts = std::array<std::size_t, 7>;

/// Numbers of placed points that a pass shows and loses: `shown` and all `lost` add up to all of
/// them.
struct PassCoverage {
  std::size_t shown = 0;
  LossCounts lost{};
};

/// How the passes cover the points that a scene places, including those that are then left out.
struct SceneCoverage {
  struct Points {
    std::size_t placed = 0;
    std::size_t left_out = 0;  ///< fewer looks than min_looks; control is never left out
    std::size_t unseen = 0;    ///< no look
  };
  std::array<Points, 3> points;              ///< by PointRole
  std::vector<std::size_t> points_by_looks;  ///< points with k looks
  LossCounts lost{};
  LossCounts lost_of_left_out{};  ///< of the points left out
  std::vector<PassCoverage> passes;

  [[nodiscard]] const Points& of(PointRole role) const {
    return points[static_cast<std::size_t>(role)];
  }
};

/// A block whose truth is known, as reading its files gives it: recorded flights are read in the
/// way that the scene's recorder states. Passes carry explicit start and end times.
struct SimulatedBlock {
  Block block;
  Truth truth;
  /// The passes with their planned paths where the states of the block are recorded on a flight
  /// (IsRecorded); else empty: the block holds the planned paths themselves.
  std::vector<Pass> planned;
  std::shared_ptr<const std::vector<TrajectoryError>>
      trajectory_error;           ///< by pass, as drawn; null: no errors
  std::vector<PassError> errors;  ///< by pass, as drawn
  ExactLooks exact;
  std::vector<std::uint8_t> blunder;  ///< by look, 1 where a blunder was added
  SceneCoverage coverage;
  std::uint64_t measurement_seed = 0;
  std::uint64_t navigation_seed = 0;
  std::uint64_t control_seed = 0;

  [[nodiscard]] const Pass& Planned(std::size_t pass) const {
    return planned.empty() ? block.passes[pass] : planned[pass];
  }
  /// Null where the pass flies as planned.
  [[nodiscard]] const TrajectoryError* TrajectoryErrorOf(std::size_t pass) const;
};

/// Simulates a scene: nominal paths, terrain, points, visibility, then Redraw() of everything with
/// the scene's seed. The same scene gives the same bytes.
///
/// A point is seen by a pass when the cone equation on the nominal path has its solution inside the
/// strip's time and the point then lies inside the swath on the look side (docs/scenes.md), and,
/// with SceneTerrain::hides, neither in shadow nor in layover. SimulatedBlock::coverage counts what
/// is lost. Times and ranges come from the true path (model.md, section 4):
///
///     e_d(t) = 0 with squint tau + b_tau  ->  t;      t_measured = t - b_t + sigma_t n
///     R_measured = (1 + kappa) |p - s(t)| + b_r + sigma_R n_2
///
/// A look whose Doppler is measured has the time t - b_t exactly and sigma_f n on its Doppler.
///
/// Order of points: control (C...), check (K...), tie (T...). Throws InputError (Validate) and
/// Interrupted.
[[nodiscard]] SimulatedBlock Simulate(const Scene& scene, ProgressSink* progress = nullptr);

/// What Redraw() draws anew; the rest stays as it is.
struct RedrawChoice {
  bool measurements = true;  ///< noise and blunders of the looks
  bool navigation = true;  ///< true paths, their recording and biases about the same planned paths
  bool control = true;     ///< errors of control and check coordinates
};

/// Draws random errors anew from `seed`, for seeded statistics: points, nominal paths and the list
/// of looks stay, so that a draw costs one cone solution a look (navigation) or two random numbers.
/// The result depends on scene, seeds and choice alone, not on earlier draws. `scene` must be the
/// one `simulated` was made from. Throws InputError if a true look leaves its nominal path's span.
void Redraw(const Scene& scene,
            std::uint64_t seed,
            const RedrawChoice& choice,
            SimulatedBlock* simulated);

}  // namespace sarblock
