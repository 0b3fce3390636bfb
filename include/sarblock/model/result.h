// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/path.h"
#include "sarblock/model/options.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// Parts of the look equations that are left out because they move no point by an amount that
/// counts (selection/simplify.h; docs/theory/selection.md). Nothing is by default.
struct Simplified {
  bool flat_frame = false;        ///< delays see the tangent plane at `middle_m`, not the ellipsoid
  bool fixed_track_axes = false;  ///< the axes of a pass are those at the middle of its strip
  bool linear_velocity = false;   ///< a pass flies one straight line at constant velocity
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();  ///< of the points, frame axes
  [[nodiscard]] bool any() const { return flat_frame || fixed_track_axes || linear_velocity; }
};

/// The straight line of least squares through a pass's nominal path within its strip, continued
/// over the whole path. A path that is straight already, or hardly gets anywhere, is left as it is.
[[nodiscard]] FlightPath StraightenedPath(const Pass& pass);

/// What a result is worth. Terminal, summary.json, report and exit code repeat this one judgement
/// (docs/theory/quality.md).
enum class Verdict : std::uint8_t {
  kAccepted,     ///< converged, determined, and every test is passed
  kTestsFailed,  ///< converged and determined; a test failed: see the reasons
  kNotAccepted,  ///< not converged, or contradictions so gross that sigmas mean nothing
};
/// "accepted", "converged, tests failed", "not accepted".
[[nodiscard]] const char* NameOf(Verdict verdict);

/// Below this redundancy an observation has no test: what its residual shows is rounding.
inline constexpr double kMinRedundancy = 1e-9;

/// Levels, critical values and the non-centrality of the tests of single observations
/// (docs/theory/quality.md, eq. (7)-(13)).
struct ReliabilityFigures {
  std::size_t tests = 0;      ///< observations that can be tested
  double alpha_one = 0.0;     ///< level of each test, after `family_wise`
  double alpha_all = 0.0;     ///< chance that one of all rejects without cause, were they
                              ///< independent
  double critical_w = 0.0;    ///< of |w|
  double critical_tau = 0.0;  ///< of |tau|; NaN where the redundancy is 1 or less
  double delta0 = 0.0;        ///< shift of w that is found with the power asked for
};

/// One observation whose test is among the largest.
struct TestedLook {
  std::uint64_t look = 0;
  std::uint32_t point = 0;
  bool azimuth = false;
  double w = 0.0;
  double redundancy = 0.0;
};

/// Observations of a kind by how far others check them. Below a redundancy of 0.1 the least
/// detectable blunder is 3.2 delta0 standard deviations or more: hardly checked (Förstner 1979).
struct CheckedObservations {
  static constexpr double kHardly = 0.1;
  std::size_t count = 0;
  std::size_t hardly = 0;  ///< with a redundancy below kHardly
  /// The observation whose least detectable blunder would move its point farthest: the point, its
  /// pass (for control the component: 0 east, 1 north, 2 up), its redundancy, that blunder and that
  /// shift, both infinite where no blunder can be detected.
  std::uint32_t point = 0, part = 0;
  double redundancy = kNotGiven, blunder_m = kNotGiven, shift_m = kNotGiven;
};

/// The tests of a result in short. Counts above the critical value are of |w| or, where that is the
/// test, of |tau|.
struct QualitySummary {
  ReliabilityFigures figures;
  std::array<CheckedObservations, 3> checked{};  ///< ranges, azimuths, control components
  std::array<std::size_t, 2> looks_tested{};     ///< range, azimuth
  std::array<std::size_t, 2> looks_above{};
  std::size_t control_tested = 0, control_above = 0;
  /// Tested looks whose point has one degree of freedom, so that all its tests are the same.
  std::size_t looks_not_localisable = 0;
  std::array<double, 2> median_redundancy{};  ///< NaN without looks
  std::vector<TestedLook> worst;              ///< largest |w| first, at most ten; none predicted
  std::size_t worst_control = 0;              ///< index into `control_quality`
  double worst_control_w = kNotGiven;         ///< NaN where no control is tested
  [[nodiscard]] std::size_t above() const {
    return looks_above[0] + looks_above[1] + control_above;
  }
  /// Number expected above the critical value by chance.
  [[nodiscard]] double expected_above() const {
    return figures.alpha_one * static_cast<double>(figures.tests);
  }
};

/// Check points together. The sum of their chi-squares has the expectation `components` if the
/// predicted accuracy is realistic. The interval is that of a chi-square of `freedom` degrees,
/// scaled to that expectation: errors of check points are correlated by the paths they share.
struct CheckSummary {
  std::size_t points = 0;  ///< compared: solved and, where there are covariances, with one
  /// Check points that have an error but no standard deviation (left out as contradictory): they
  /// count in no figure here.
  std::size_t points_without_sigma = 0;
  std::array<double, 3> rms_m{};  ///< east, north, up of the points compared; NaN: not known
  int components = 0;
  double freedom = 0.0;  ///< independent components they are worth
  double chi_square = 0.0;
  Interval chi_square_interval;    ///< two-sided at test_level
  std::size_t points_outside = 0;  ///< chi-square alone above the quantile at test_level
  /// sqrt(chi_square / components): errors in units of what was predicted, and its interval.
  double error_ratio = kNotGiven;
  Interval error_ratio_interval;
  [[nodiscard]] bool realistic() const { return chi_square_interval.Contains(chi_square); }
};

/// The tests of priors in short, at the level of one observation.
struct PriorSummary {
  std::size_t priors = 0;       ///< with a redundancy number
  std::size_t tested = 0;       ///< with a standardised residual
  std::size_t above = 0;        ///< beyond the critical value of |w| (|tau| where that is the test)
  double expected_above = 0.0;  ///< by chance
  std::size_t worst = 0;        ///< index of the parameter with the largest |w|
  double worst_w = kNotGiven;   ///< NaN where none is tested
  double redundancy = kNotGiven;  ///< of all priors together
};

/// One kind of observations in the whole block: its part of v'Pv and of the redundancy, and where
/// v'Pv over redundancy is expected. docs/theory/quality.md, section "Groups".
struct ObservationGroup {
  std::string name;  ///< "ranges", "azimuths", "control", "priors", "all"
  double square_sum = 0.0, redundancy = 0.0;
  Interval band;  ///< of factor()
  [[nodiscard]] double factor() const { return square_sum / redundancy; }
  /// Standard deviation of factor() if all is well but for a common factor.
  [[nodiscard]] double factor_deviation() const {
    return factor() * std::sqrt(2.0 / std::max(1.0, redundancy));
  }
  [[nodiscard]] bool agrees() const { return band.Contains(factor()); }
};

/// Share of a pass (or of a group of corrections that passes share) in v'Pv and the redundancy of
/// the block. All shares and those of the control points add up to both, except for observations
/// without redundancy.
struct PassShare {
  std::string owner;                                      ///< id of the pass, or name of the group
  std::size_t looks = 0;                                  ///< with redundancy numbers
  double square_sum = 0.0, redundancy = 0.0;              ///< of its looks
  double prior_square_sum = 0.0, prior_redundancy = 0.0;  ///< of its priors
  /// v'Pv over redundancy of both together; NaN where there is no redundancy.
  [[nodiscard]] double variance_factor() const {
    const double all = redundancy + prior_redundancy;
    return all > kMinRedundancy ? (square_sum + prior_square_sum) / all : kNotGiven;
  }
};

/// Differences of point pairs about as far apart, along or across the tracks of the first pass
/// (PairChoice::kDistances). The figures are medians over the pairs.
struct DifferenceClass {
  bool along = false;  ///< direction of the pairs
  std::size_t pairs = 0;
  double distance_m = 0.0;
  double sigma_along_m = 0.0, sigma_across_m = 0.0, sigma_up_m = 0.0;
};

/// The verdict on a result and the figures of the tests that it rests on.
struct Assessment {
  Verdict verdict = Verdict::kNotAccepted;
  /// Why it is not `accepted`, the gravest first: what failed, by how much, and what usually causes
  /// it. Empty for an accepted result.
  std::vector<std::string> reasons;
  QualitySummary tests;  ///< empty counts where no quality figures were computed
  PriorSummary priors;
  CheckSummary checks;                   ///< empty counts without check points
  std::vector<ObservationGroup> groups;  ///< in the order of their names above; without what is
                                         ///< not known
  std::vector<PassShare> shares;  ///< by pass in order, then shared groups; empty without figures
  std::vector<DifferenceClass> differences;  ///< along, then across, by distance; else empty
};

/// A standard deviation with its unit: metres, or seconds of azimuth time.
using SigmaInUnit = double;

/// One estimated variance: that of the ranges or of the azimuths of a group of passes
/// (docs/theory/variance_components.md).
struct VarianceComponent {
  std::string group;  ///< "all", or the passes: "A1", "A1+A2"
  std::vector<std::size_t> passes;
  int component = 0;  ///< 0 range, 1 azimuth
  std::size_t looks = 0;
  double redundancy = 0.0;  ///< sum of the redundancy numbers, under the weights reached
  double factor = 1.0;      ///< variance after over variance before
  /// Standard deviation of factor; NaN if it was fixed.
  double factor_deviation = std::numeric_limits<double>::quiet_NaN();
  /// Root mean square of the looks' standard deviations before, in `unit`; NaN where units mix.
  SigmaInUnit sigma_before = std::numeric_limits<double>::quiet_NaN();
  std::string unit;        ///< "m" or "s"
  bool estimated = false;  ///< else fixed at factor 1, `note` says why
  std::string note;

  [[nodiscard]] double sigma_after() const;
  /// Standard deviation of sigma_after(), to first order half that of the variance.
  [[nodiscard]] double sigma_deviation() const;
};

/// A global test as it was.
struct GlobalTest {
  double sigma0_squared = std::numeric_limits<double>::quiet_NaN();
  double redundancy = 0.0;
  Interval chi_square;
  bool passed = false;
};

/// What the estimation of variance components did.
struct VarianceComponentReport {
  std::vector<VarianceComponent> components;
  GlobalTest before;  ///< with the standard deviations given
  int iterations = 0;
  bool converged = false;
};

/// What estimated components multiply standard deviations by: by pass of `passes`, range and
/// azimuth; 1 for passes in no component.
[[nodiscard]] std::vector<std::array<double, 2>> SigmaFactors(
    const std::vector<VarianceComponent>& components, std::size_t passes);

/// A figure of one run, averaged over the runs: the runs are independent, the points of one are
/// not. The interval holds the expectation with 99 percent (normal).
struct RunMean {
  double expected = 0.0;
  double mean = 0.0;
  double standard_error = 0.0;
  [[nodiscard]] double lower() const;
  [[nodiscard]] double upper() const;
  /// True where the interval holds what is expected.
  [[nodiscard]] bool Agrees() const;
};

/// Errors of repeated noise against the rigorous covariance (montecarlo.h,
/// docs/theory/montecarlo.md).
struct MonteCarloReport {
  static constexpr std::array<double, 3> kLevels{0.5, 0.9, 0.99};
  int runs = 0;    ///< that were adjusted; the figures are theirs
  int failed = 0;  ///< that did not converge
  std::uint64_t seed = 0;
  std::size_t points = 0;  ///< compared: solved, with a covariance

  /// By point of the block; NaN or 0 where not compared. Mean of e e' over the runs, e the error
  /// of a run against the solution it was drawn from, in east, north, up: ee, nn, uu, en, eu, nu
  /// [m2].
  std::vector<std::array<double, 6>> sample_m2;
  std::vector<double> square;                        ///< mean of e' Q^-1 e / 3
  std::array<std::vector<std::uint32_t>, 3> inside;  ///< runs inside the ellipsoid of kLevels

  /// Mean over points of e_i^2 / Q_ii, i east, north, up; of e' Q^-1 e / 3.
  std::array<RunMean, 3> variance_ratio;
  RunMean square_ratio;
  std::array<RunMean, 3> coverage;  ///< part of the points inside the ellipsoids of kLevels
  /// Points whose sum of e' Q^-1 e lies outside the 99 percent interval of chi-square.
  std::size_t points_outside = 0;
  std::string sentence;  ///< what it says, for people
};

/// How a candidate was tested last.
enum class SelectionTest {
  kScore,    ///< Rao's score: what adding it to the final model would take off v'Pv
  kWald,     ///< what leaving it out of the final model would add to v'Pv
  kNotTried  ///< what it needs is not in the model
};

/// One candidate of the model selection with its figures at the final model. Degree d of a position
/// polynomial that is not kept represents all degrees above the kept ones up to d, together; a
/// spline replaces the polynomial of its component. docs/theory/selection.md.
struct CandidateResult {
  std::string name;    ///< "position.up.1", "position.up.spline 10 s", "range.bias"
  std::string passes;  ///< "all", pass ids, or the name of a shared group
  int parameters = 0;  ///< that it adds
  SelectionTest test = SelectionTest::kNotTried;
  double statistic = kNotGiven;        ///< score or Wald statistic: the change of v'Pv
  double f = kNotGiven;                ///< F
  double probability = kNotGiven;      ///< of a larger F without the correction
  double delta_bic = kNotGiven;        ///< with less without; below 0 it pays
  double condition = kNotGiven;        ///< largest factor by which the other unknowns, points
                                       ///< included, inflate a variance; infinite: singular
  double posterior_prior = kNotGiven;  ///< mean ratio of standard deviations; NaN: no prior
  bool kept = false;
  bool held = false;  ///< not kept, yet in the model with a prior: its own, or an estimated one
  int step = 0;       ///< in which it entered, or was dropped after it had; 0: neither
  std::string reason;
  /// "kept", "held" or "dropped".
  [[nodiscard]] const char* verdict() const { return kept ? "kept" : held ? "held" : "dropped"; }
};

/// What a simplification of the model would do to the points (selection/simplify.h).
struct SimplificationBound {
  std::string name{};           ///< "flat-frame", "fixed-track-axes", "linear-velocity"
  double bound_m = kNotGiven;   ///< no point moves by more, at the point with the largest part
  double sigma_m = kNotGiven;   ///< its standard deviation, paths fixed
  double fraction = kNotGiven;  ///< bound over sigma, the largest of all points
  bool allowed = false;         ///< the part is below the limit
  bool taken = false;           ///< the result is that of a model without it
  double gain = kNotGiven;      ///< measured: time of evaluating a look with it over without it;
                                ///< NaN where there is nothing to gain or it is not allowed
  std::string verdict{};        ///< "taken", "not allowed" or why it was not taken
};

/// The outcome of a model selection.
struct SelectionReport {
  std::vector<CandidateResult> candidates;  ///< every one, in the order of the candidate groups
  std::vector<CorrectionGroup> groups;      ///< the model chosen; may be empty
  std::vector<SimplificationBound> simplifications;  ///< all four; empty without solved points
  Simplified simplified;                             ///< what was taken
  double simplified_gain = kNotGiven;                ///< measured, of all that was taken together
  double simplified_shift = kNotGiven;  ///< largest move of a point by the full model, in its
                                        ///< sigmas, from the simplified model that was taken, or
                                        ///< given up because of it
  int rounds = 0;                       ///< linearisations
  int steps = 0;                        ///< candidates that entered or were dropped
  bool settled = true;                  ///< the last round changed nothing
  bool certain = false;                 ///< what is not kept is left out, not held by estimated
                                        ///< priors: with them the solution did not converge
  [[nodiscard]] bool empty() const { return candidates.empty(); }
};

/// What became of a point.
enum class PointStatus : std::uint8_t {
  kAdjusted,     ///< solved in the adjustment
  kIntersected,  ///< solved alone, flight paths fixed
  kPredicted,    ///< covariance only, geometry from truth or approximate coordinates
  kNotSeen,      ///< no look that counts
  kTooFewLooks,  ///< fewer equations than unknowns
  kApart,        ///< intersected alone: its circles do not meet within their noise; the position is
                 ///< a compromise without a covariance
  kUndetermined,  ///< equations enough, but a direction is not determined; see `reason`
};
[[nodiscard]] const char* NameOf(PointStatus status);  ///< "adjusted", "undetermined", ...
/// True where position and covariance may be used.
[[nodiscard]] bool IsSolved(PointStatus status);

/// Symmetric 3 x 3 in east, north, up: ee, nn, uu, en, eu, nu [m2].
using SymmetricEnu = std::array<double, 6>;

/// Points of a result in flat arrays, by point index of the block.
struct PointResults {
  std::vector<PointStatus> status;
  std::vector<std::string> reason;          ///< empty, or by point: why not solved
  std::vector<std::uint32_t> looks;         ///< looks that count (not rejected)
  std::vector<Eigen::Vector3d> position_m;  ///< frame axes; NaN where not solved
  std::vector<SymmetricEnu> covariance_m2;  ///< empty at level `none`; NaN where not solved
  /// With the corrections known exactly (quality/point_sweep.h); empty without corrections and with
  /// an inner datum.
  std::vector<SymmetricEnu> fixed_path_covariance_m2;
  std::vector<double> intersection_rad;  ///< largest intersection angle; NaN below two looks
  std::vector<double> redundancy;        ///< of the point's looks; empty where not computed
  /// Leberl (1979) for the best pair of looks of each point (leberl_prediction.h), across and up;
  /// empty at level `none`, NaN where the geometry cannot be reduced to the paper's.
  std::vector<double> sigma_leberl_across_m;       ///< by range noise, Eq. 25
  std::vector<double> sigma_leberl_up_m;           ///< by range noise, Eq. 25
  std::vector<double> sigma_leberl_path_across_m;  ///< by the priors of corrections, Eq. 14
  std::vector<double> sigma_leberl_path_up_m;      ///< by the priors of corrections, Eq. 15
  /// Direction of across, clockwise from north.
  std::vector<double> leberl_across_azimuth_rad;
};
/// Columns of PointResults that only a covariance gives, for code that treats them alike.
inline constexpr std::array kAccuracyFigures{&PointResults::redundancy,
                                             &PointResults::sigma_leberl_across_m,
                                             &PointResults::sigma_leberl_up_m,
                                             &PointResults::sigma_leberl_path_across_m,
                                             &PointResults::sigma_leberl_path_up_m,
                                             &PointResults::leberl_across_azimuth_rad};

/// One estimated correction parameter.
struct ParameterResult {
  std::string owner;  ///< pass id, or the shared group's name
  std::string name;   ///< "position.along.0", "range.bias", ...
  std::string unit;   ///< "m", "s", "rad", "1"
  double value = 0.0;
  double sigma = std::numeric_limits<double>::quiet_NaN();        ///< NaN where not computed
  double prior_sigma = std::numeric_limits<double>::quiet_NaN();  ///< NaN: no prior; of a joint
                                                                  ///< prior the diagonal's
  std::string kept{};  ///< why, in model selection; else empty
  /// A coefficient of a process (PositionCorrection::Process) other than the first follows from
  /// parameter `before`: its prior is that value - carried * value_before has the standard
  /// deviation step_sigma. Others have -1.
  int before = -1;
  double carried = 0.0;
  double step_sigma = std::numeric_limits<double>::quiet_NaN();
  /// |value| over sigma; NaN without a sigma above 0.
  [[nodiscard]] double significance() const {
    return sigma > 0.0 ? std::abs(value) / sigma : std::numeric_limits<double>::quiet_NaN();
  }
};

/// How far the standard deviation of a correction k is valid. If it is moved by t standard
/// deviations and all others follow,
///
///     v'Pv - its minimum = (t + curvature t^2)^2
///
/// except for residuals times second derivatives and terms of third order; the curvature is 0 where
/// the equations are linear (docs/theory/quality.md, eq. (17a)).
struct CorrectionCurvature {
  std::uint32_t parameter = 0;  ///< index into AdjustResult::parameters
  double curvature = 0.0;       ///< [1]
};

/// A joint prior of one pass as it took part, in the axes of its corrections.
struct JointPriorResult {
  std::string name;
  std::vector<std::uint32_t> parameters;  ///< indices into `parameters`
  DenseMatrix covariance;                 ///< in their units
};

/// Covariance of two parameters (indices into `parameters`, a <= b).
struct ParameterCovariance {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  double covariance = 0.0;
};

/// Difference of two points, b - a, in east-north-up axes at a, with its covariance.
struct PairResult {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  Eigen::Vector3d difference_enu_m = Eigen::Vector3d::Zero();
  SymmetricEnu covariance_m2{};
  /// Leberl (1979) for the same difference, as in PointResults; NaN where not meaningful.
  double sigma_leberl_across_m = std::numeric_limits<double>::quiet_NaN();
  double sigma_leberl_up_m = std::numeric_limits<double>::quiet_NaN();
  double sigma_leberl_path_across_m = std::numeric_limits<double>::quiet_NaN();
  double sigma_leberl_path_up_m = std::numeric_limits<double>::quiet_NaN();
};

/// Why a look was left out.
enum class RejectReason : std::uint8_t {
  kNone,
  kGiven,    ///< by the block's file or a list of rejections
  kNoValue,  ///< the model has no value for it
  kRobust,   ///< far off in a robust solution
  kBlunder,  ///< the search for blunders located it
  kSuspect,  ///< one of the looks that the search found to contradict each other
};
[[nodiscard]] const char* NameOf(RejectReason reason);  ///< "", "given", "no-value", ...

/// Residuals by look index of the block; NaN where the look or its point took no part.
struct LookResults {
  std::vector<double> range_residual_m;    ///< e_r at the solution (model.md, section 4)
  std::vector<double> azimuth_residual_m;  ///< e_d at the solution
  std::vector<float> weight;               ///< in the robust solution; empty: no loss, all 1
  std::vector<std::uint8_t> rejected;      ///< by the file or by the robust loss; empty: the file's
  std::vector<RejectReason> reason;        ///< empty: not known
};

/// One contradiction that the search for blunders found: a look, or several (or a known position)
/// of one point among which the residuals cannot choose.
struct BlunderFinding {
  enum class Action : std::uint8_t {
    kRejected,         ///< its looks were left out
    kPointLeftOut,     ///< the point, too little was left of it
    kControlReleased,  ///< the point's known position was left out
    kKept,             ///< reported only, see `note`
    kReadmitted,       ///< found innocent once the others were out
  };
  std::uint32_t point = 0;
  int round = 0;                     ///< of the search, from 1
  double w = 0.0;                    ///< the largest standardised residual
  bool azimuth = false;              ///< ... of which component of looks[0]
  std::vector<std::uint64_t> looks;  ///< by look index, the most probable first
  bool control = false;              ///< the point's known position is among the suspects
  Action action = Action::kKept;
  std::string note;  ///< why it was kept
  /// One observation alone is named.
  [[nodiscard]] bool located() const { return looks.size() + (control ? 1U : 0U) == 1U; }
};

/// What the search for blunders did (blunder_search.h).
struct SnoopingReport {
  int rounds = 0;                        ///< solutions that were tested
  std::vector<BlunderFinding> findings;  ///< in the order found
  std::vector<std::uint64_t> robust;     ///< looks left out after the robust start for good
};

/// Reliability of looks, by look index of the block, component 0 the range and 1 the azimuth (along
/// track, or time where it was given in seconds); NaN where the look took no part. Figures that
/// also depend on alpha and power of a test (minimal detectable blunder delta0 sigma / sqrt(r), its
/// influence delta0 / sqrt(r) times shift) are left to the caller. docs/theory/quality.md.
struct LookQuality {
  /// r = 1 - a C a' of the component in units of its sigma: the part of an error that shows in its
  /// residual.
  std::array<std::vector<float>, 2> redundancy;
  /// Standardised residual v / (sigma sqrt(r)); NaN where r vanishes.
  std::array<std::vector<float>, 2> w;
  /// Length of the shift of the point by an error of one sigma in the component.
  std::array<std::vector<float>, 2> shift_m;
  [[nodiscard]] bool empty() const { return redundancy[0].empty(); }
};

/// The same for one fixed component of a control point.
struct ControlQuality {
  std::uint32_t point = 0;
  int component = 0;  ///< 0 east, 1 north, 2 up
  double residual_m = 0.0;
  double redundancy = 0.0;
  double w = 0.0;
  double shift_m = 0.0;
};

/// Error of a check point against its known position, east-north-up.
struct CheckResult {
  std::uint32_t point = 0;
  Eigen::Vector3d error_enu_m = Eigen::Vector3d::Zero();  ///< NaN in components not known
  double chi_square = 0.0;  ///< e' Q^-1 e over the known components, both covariances in Q
  int components = 0;
  /// Standard deviations of the error, from the covariance of the point (scaled where it is) and
  /// that of the known position; NaN where there is no error or no covariance.
  Eigen::Vector3d sigma_enu_m = Eigen::Vector3d::Constant(kNotGiven);
};

/// One place of a flight path within its strip: where the antenna is, what it sees, and how the
/// adjustment corrected it there (adjust/finish.h).
struct StripStation {
  std::uint32_t pass = 0;
  double time_s = 0.0;
  double strip_time = 0.0;  ///< strip-normalised time, -1 to 1 (docs/theory/flight_path.md)
  Eigen::Vector3d antenna_m = Eigen::Vector3d::Zero();  ///< nominal path, frame axes
  /// Ground at the nearest and farthest range of the pass's looks, at the median height of its
  /// points; NaN without looks or where the range does not reach that height.
  Eigen::Vector3d near_m = Eigen::Vector3d::Constant(kNotGiven);
  Eigen::Vector3d far_m = Eigen::Vector3d::Constant(kNotGiven);
  /// Position correction delta(t) along, across and up and its standard deviations; NaN where the
  /// pass has no position correction, sigmas also where they were not computed.
  Eigen::Vector3d correction_m = Eigen::Vector3d::Constant(kNotGiven);
  Eigen::Vector3d correction_sigma_m = Eigen::Vector3d::Constant(kNotGiven);
};

enum class AdjustStatus {
  kConverged,
  kNotConverged,
  kIntersected,  ///< `intersect`
  kPredicted,    ///< `predict`
};

/// Pairs of point indices, for coordinate differences.
using PointPairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Largest Newton decrement, in sigmas over all unknowns together, of a solution.
inline constexpr double kRemainingStepAccepted = 1e-3;
/// The same under a robust loss, whose kinks (Huber) or flat places (two looks that contradict each
/// other) let the last steps shrink slowly: far below what the loss itself costs in efficiency.
inline constexpr double kRemainingRobustStepAccepted = 0.1;

/// What one term subtracted from the ranges or the times of the looks of one pass.
struct ReductionTerm {
  std::uint32_t pass = 0;
  std::string term;  ///< "given", "troposphere", "ionosphere", "tide", "motion", "constant"
  std::string unit;  ///< "m" of ranges, "s" of times
  double mean = 0.0, least = 0.0, largest = 0.0;
};

/// What was subtracted from the measured values (docs/theory/reductions.md).
struct Reductions {
  std::vector<double> range_m, time_s;  ///< by look, all terms; empty: nothing was
  std::vector<ReductionTerm> terms;     ///< by pass
};

/// Everything an adjustment, an intersection or a prediction answers.
struct AdjustResult {
  AdjustStatus status = AdjustStatus::kNotConverged;
  Assessment assessment;  ///< the verdict, its reasons and the figures of the tests
  /// The verdict is `accepted`: converged, determined, and every test is passed.
  [[nodiscard]] bool accepted() const { return assessment.verdict == Verdict::kAccepted; }
  /// Converged and determined: positions and standard deviations may be used, though a test may
  /// have failed.
  [[nodiscard]] bool usable() const { return assessment.verdict != Verdict::kNotAccepted; }
  PointResults points;
  std::vector<ParameterResult> parameters;
  std::vector<JointPriorResult> joint_priors;
  std::vector<ParameterCovariance> parameter_covariance;
  std::vector<PairResult> pairs;
  LookResults looks;
  LookQuality quality;  ///< empty where not computed
  Reductions reductions;
  std::vector<ControlQuality> control_quality;
  std::optional<SnoopingReport> snooping;
  /// Empty where not asked for. It holds the global test before the estimation; the test below is
  /// the one after it.
  std::optional<VarianceComponentReport> variance_components;
  std::optional<MonteCarloReport> montecarlo;
  std::vector<CheckResult> checks;
  /// Independent components that the check points are worth (CheckFreedom); NaN: as many as known.
  double check_freedom = std::numeric_limits<double>::quiet_NaN();
  std::vector<StripStation> strips;         ///< by pass and time
  std::vector<FlightPath> corrected_paths;  ///< by pass, states at the nominal times
                                            ///< and where a correction needs more

  std::size_t observation_count = 0;  ///< two per look, control components, priors
  std::size_t parameter_count = 0;    ///< three a solved point, corrections
  std::size_t datum_defects = 0;      ///< unknowns that an inner datum had to fix
  std::size_t looks_used = 0;
  std::size_t looks_not_evaluated = 0;  ///< left out because the model has no value there
  [[nodiscard]] double redundancy() const {
    return static_cast<double>(observation_count) - static_cast<double>(parameter_count) +
           static_cast<double>(datum_defects);
  }
  int iterations = 0;
  double initial_cost = 0.0;  ///< half the weighted square sum at the start, robust loss applied
  double final_cost = 0.0;
  double gradient = 0.0;        ///< largest |g_i| / sqrt(H_ii), dimensionless
  double remaining_step = 0.0;  ///< length of the Newton step left, in sigmas
  /// Factor on covariances (its root: on standard deviations) of points, pairs, corrections and
  /// strips: sigma0_squared where AdjustOptions::scale_by_posterior asks for it, else 1.
  double posterior_factor = 1.0;
  /// v'Pv over redundancy of looks and control, without priors; of all observations where the
  /// redundancy of the priors is not known (covariances not computed).
  double sigma0_squared = std::numeric_limits<double>::quiet_NaN();
  double test_redundancy = std::numeric_limits<double>::quiet_NaN();  ///< that of sigma0_squared
  Interval chi_square;  ///< acceptance interval of sigma0_squared * test_redundancy
  bool chi_square_passed = false;
  double condition = std::numeric_limits<double>::quiet_NaN();  ///< of the scaled reduced matrix
  /// The eight corrections with the largest |curvature|, the largest first. Empty without standard
  /// deviations of corrections, in an inner datum, where not converged, and in predictions.
  std::vector<CorrectionCurvature> curvatures;
  std::vector<StageCost> stages;
  SelectionReport selection;  ///< of `corrections = "auto"`, else empty
  std::vector<std::string> warnings;
};

/// What a mistake is about.
enum class MistakeKind : std::uint8_t {
  kTime,
  kRange,
  kCone,
  kPath,
  kControl,
  kIds,
  kSigma,
  kModel,  ///< corrections that are missing, or their priors
};
[[nodiscard]] const char* NameOf(MistakeKind kind);  ///< "time", "range", "cone", ...

/// One mistake that would explain why a block contradicts itself, with the evidence for it: the
/// weighted square sum v'Pv of a sample of the block as it is and with the mistake undone.
struct Explanation {
  MistakeKind kind = MistakeKind::kTime;
  std::string cause;     ///< stable word for programs: "time.constant", "ids.exchanged"
  std::string sentence;  ///< for people: what is wrong, how much of v'Pv it takes, what to change
  std::vector<std::string> passes;  ///< ids of the passes concerned; empty: all
  std::vector<std::string> points;  ///< ids of the points concerned
  double value = kNotGiven;         ///< size of the mistake; NaN where it has none
  double sigma = kNotGiven;         ///< its standard deviation
  std::string unit;                 ///< of value and sigma: "s", "m", "1", "rad/s"
  std::string equals;  ///< the known number that the value equals within its sigma; else empty
  std::string change;  ///< what to change: file and column, key of block.toml, correction
  double part = 0.0;   ///< of v'Pv that it takes away
  double square_sum_before = 0.0;  ///< v'Pv of the sample as it is
  double square_sum_after = 0.0;   ///< and with the mistake undone
  double redundancy_before = 0.0;  ///< of the sample as it is
  double redundancy_after = 0.0;   ///< less the parameters that undo the mistake
  /// The block as a whole with the mistake undone (docs/theory/diagnosis.md, "Cure").
  struct Cure {
    bool tried = false;  ///< solved; else the figures below are not set
    bool cures = false;  ///< looks and control, and the priors, are within their bands
    double factor = kNotGiven, lower = kNotGiven, upper = kNotGiven;  ///< looks and control
    double priors_factor = kNotGiven;                                 ///< NaN without priors
    std::size_t points = 0;  ///< of the block or, where it is very large, of a part of it
  };
  Cure cure;
  /// Looks of the sample without a valid position of their point (no intersection, or one on a side
  /// where they do not look).
  std::size_t looks_lost_before = 0, looks_lost_after = 0;
};

/// What was found, the most likely explanation first.
struct Diagnosis {
  bool contradicts = false;  ///< the sample fails its global test, or looks have no valid position
  std::vector<Explanation> explanations;
  /// Systematic pattern in the residuals, named where another standard deviation would explain them
  /// if they were noise; else empty.
  std::string pattern;
  std::vector<std::string> remarks;  ///< seen before any test: passes or points that are copies
  double square_sum = 0.0;           ///< v'Pv of the sample, check points as control
  double redundancy = 0.0;
  std::size_t points = 0;  ///< of the sample
  int hypotheses = 0;      ///< tried
  int solutions = 0;       ///< of the sample
  /// Hypotheses, or points that may be mistaken, that the bound of the work left untried.
  int untried = 0;
  /// Work done and its bound, in looks formed (docs/theory/diagnosis.md, eq. (11)).
  double work = 0.0, max_work = 0.0;
  /// Sentences for people, "most likely: " before the first explanation, "or: " before others.
  [[nodiscard]] std::vector<std::string> Sentences() const;
};

/// Memory and work of an adjustment, predicted from the block and the pattern of its reduced normal
/// matrix S (docs/theory/covariance.md) before anything is allocated. Memory is in bytes, 8 per
/// number; work is in operations, each a product and its sum. Fronts are those of one thread; each
/// further one may keep a branch of the elimination tree more.
struct ResourceNeeds {
  std::uint64_t looks_bytes = 0;   ///< looks, their weights and their results
  std::uint64_t points_bytes = 0;  ///< points, their state and their results
  std::uint64_t block_bytes = 0;   ///< part of these two that the block takes as it was read
  /// Arrays of looks and points large enough for scratch files (src/core/memory.h) ...
  std::uint64_t large_bytes = 0;
  std::uint64_t scratch_bytes = 0;  ///< ... and the part of these in scratch files, not in memory
  std::uint64_t matrix_bytes = 0;   ///< S, as formed and scaled
  std::uint64_t partial_sums_bytes = 0;  ///< of S while it is formed
  std::uint64_t factor_bytes = 0;        ///< L of S = L L'
  std::uint64_t fronts_bytes = 0;        ///< while it is formed, update matrices that wait
  std::uint64_t inverse_bytes = 0;       ///< S^-1 on the pattern of S and the fronts it comes from
  double sum_operations = 0.0;           ///< of one sum of S
  double factor_operations = 0.0;        ///< of one factor
  /// The most memory at one time: looks and points always, less scratch files, with S in turn its
  /// partial sums, its factor and its inverse.
  std::uint64_t peak_bytes = 0;
};

/// In words, on one line: "memory 41 MiB (looks 12, ...); operations: S 3.1e+07, factor 2.2e+05";
/// with scratch files "memory 29 MiB, 12 MiB in scratch files (looks 12, ...)".
[[nodiscard]] std::string DescribeNeeds(const ResourceNeeds& needs);

/// Adds a reason for which a result is not accepted.
void Refuse(AdjustResult* result, const std::string& reason);

/// Adds a warning to a result.
void Warn(AdjustResult* result, const std::string& text);

/// True where something that the finding names no longer takes part.
[[nodiscard]] bool LeavesOut(const BlunderFinding& finding);

/// The 3 x 3 matrix, east, north, up, of its six numbers (SymmetricEnu).
[[nodiscard]] inline Eigen::Matrix3d MatrixOf(const SymmetricEnu& c) {
  Eigen::Matrix3d matrix;
  matrix << c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2];
  return matrix;
}

/// The six numbers of a symmetric 3 x 3 matrix, from its upper triangle.
[[nodiscard]] inline SymmetricEnu SymmetricOf(const Eigen::Matrix3d& c) {
  return {c(0, 0), c(1, 1), c(2, 2), c(0, 1), c(0, 2), c(1, 2)};
}

}  // namespace sarblock
