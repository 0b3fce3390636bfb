// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/core/statistics.h"
#include "sarblock/model/assessment.h"
#include "sarblock/model/component_result.h"
#include "sarblock/model/montecarlo_result.h"
#include "sarblock/model/options.h"
#include "sarblock/model/selection_report.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

struct MonteCarloDraws;

/// What became of a point.
enum class PointStatus : std::uint8_t {
  kAdjusted,     ///< solved in the adjustment
  kIntersected,  ///< solved alone, flight paths held
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
  /// With the corrections known exactly (fixed_path_covariance.h); empty without that split.
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
  /// |value| over sigma; NaN without a sigma above 0.
  [[nodiscard]] double significance_1() const {
    return sigma > 0.0 ? std::abs(value) / sigma : std::numeric_limits<double>::quiet_NaN();
  }
};

/// A joint prior of one pass as it took part, in the axes of its corrections.
struct JointPriorResult {
  std::string name;
  std::vector<std::uint32_t> parameters;  ///< indices into `parameters`
  Eigen::MatrixXd covariance;             ///< in their units
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
  double w_1 = 0.0;                  ///< the largest standardised residual
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
/// track, or time where it was given in seconds); NaN where the look took no part. What alpha and
/// power of a test make of them (minimal detectable blunder delta0 sigma / sqrt(r), its influence
/// delta0 / sqrt(r) times shift) is for the reader. docs/theory/quality.md.
struct LookQuality {
  /// r = 1 - a C a' of the component in units of its sigma: what of an error shows in its residual.
  std::array<std::vector<float>, 2> redundancy_1;
  /// Standardised residual v / (sigma sqrt(r)); NaN where r vanishes.
  std::array<std::vector<float>, 2> w_1;
  /// Length of the shift of the point by an error of one sigma in the component.
  std::array<std::vector<float>, 2> shift_m;
  [[nodiscard]] bool empty() const { return redundancy_1[0].empty(); }
};

/// The same for one held component of a control point.
struct ControlQuality {
  std::uint32_t point = 0;
  int component = 0;  ///< 0 east, 1 north, 2 up
  double residual_m = 0.0;
  double redundancy_1 = 0.0;
  double w_1 = 0.0;
  double shift_m = 0.0;
};

/// Error of a check point against its known position, east-north-up.
struct CheckResult {
  std::uint32_t point = 0;
  Eigen::Vector3d error_enu_m = Eigen::Vector3d::Zero();  ///< NaN in components not known
  double chi_square = 0.0;  ///< e' Q^-1 e over the known components, both covariances in Q
  int components = 0;
  /// Of the error, from the covariance of the point, times CovarianceFactor(), and that of the
  /// known position; NaN where there is no error or no covariance.
  Eigen::Vector3d sigma_enu_m = Eigen::Vector3d::Constant(kNotGiven);
};

/// One place of a flight path within its strip: where the antenna is, what it sees, and how the
/// adjustment corrected it there (strip_stations.h).
struct StripStation {
  std::uint32_t pass = 0;
  double time_s = 0.0;
  double strip_time_1 = 0.0;  ///< strip-normalised time, -1 to 1 (docs/theory/flight_path.md)
  Eigen::Vector3d antenna_m = Eigen::Vector3d::Zero();  ///< nominal path, frame axes
  /// Ground at the nearest and farthest range of the pass's looks, at the median height of its
  /// points; NaN without looks or where the range does not reach that height.
  Eigen::Vector3d near_m = Eigen::Vector3d::Constant(kNotGiven);
  Eigen::Vector3d far_m = Eigen::Vector3d::Constant(kNotGiven);
  /// Position correction delta(t) along, across and up and its standard deviations; NaN where the
  /// pass has no position correction, sigmas (not scaled) also where they were not computed.
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

/// Largest Newton step left, in sigmas over all unknowns together, that is still a solution.
inline constexpr double kRemainingStepAccepted_1 = 1e-3;
/// The same under a robust loss, whose kinks (Huber) or flat places (two looks that contradict each
/// other) let the last steps shrink slowly: far below what the loss itself costs in efficiency.
inline constexpr double kRemainingRobustStepAccepted_1 = 0.1;

/// Everything an adjustment, an intersection or a prediction answers.
struct AdjustResult {
  AdjustStatus status = AdjustStatus::kNotConverged;
  Assessment assessment;  ///< the verdict, its reasons and the figures of the tests
  /// Converged and determined: positions and standard deviations may be used.
  [[nodiscard]] bool accepted() const { return assessment.verdict != Verdict::kNotAccepted; }
  PointResults points;
  std::vector<ParameterResult> parameters;
  std::vector<JointPriorResult> joint_priors;
  std::vector<ParameterCovariance> parameter_covariance;
  std::vector<PairResult> pairs;
  LookResults looks;
  LookQuality quality;  ///< empty where not computed
  std::vector<ControlQuality> control_quality;
  std::optional<SnoopingReport> snooping;
  /// Empty where not asked for. Its test is that before, the one below that after.
  std::optional<VarianceComponentReport> variance_components;
  std::optional<MonteCarloReport> montecarlo;
  /// With options.montecarlo_part, in place of the report.
  std::shared_ptr<MonteCarloDraws> montecarlo_draws;
  std::vector<CheckResult> checks;
  /// Independent components that the check points are worth (CheckFreedom); NaN: as many as known.
  double check_freedom_1 = std::numeric_limits<double>::quiet_NaN();
  std::vector<StripStation> strips;         ///< by pass and time
  std::vector<FlightPath> corrected_paths;  ///< by pass, states at the nominal times
                                            ///< and where a correction needs more

  std::size_t observation_count = 0;  ///< two a look, control components, priors
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
  double sigma0_squared = std::numeric_limits<double>::quiet_NaN();  ///< v'Pv / redundancy
  Interval chi_square;  ///< acceptance interval of sigma0_squared * redundancy
  bool chi_square_passed = false;
  double condition = std::numeric_limits<double>::quiet_NaN();  ///< of the scaled reduced matrix
  std::vector<StageCost> stages;
  SelectionReport selection;  ///< of `corrections = "auto"`, else empty
  std::vector<std::string> warnings;
};

/// Factor on every covariance that is written or printed: sigma0_squared with
/// `scale_by_posterior`, if there is one; else 1.
[[nodiscard]] double CovarianceFactor(const AdjustOptions& options, const AdjustResult& result);

/// Adds a reason for which a result is not accepted.
void Refuse(AdjustResult* result, const std::string& reason);

/// Adds a warning to a result.
void Warn(AdjustResult* result, const std::string& text);

}  // namespace sarblock
