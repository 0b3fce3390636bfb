// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// Prior standard deviation of one parameter; NaN (kNotGiven) means no prior.
using PriorSigma = double;

/// Correction of the antenna position, delta(t) (model.md, section 3; docs/theory/flight_path.md).
struct PositionCorrection {
  enum class Basis { kPolynomial, kSpline };
  enum class Axes { kTrack, kFrame };
  /// Prior relation between successive coefficients of a spline along an axis
  /// (docs/theory/adjustment.md, eq. (3c)).
  enum class Process {
    kWhite,       ///< they are independent of each other
    kRandomWalk,  ///< each is the one before plus a step; the steps of a strip add up to the sigma
    kGaussMarkov  ///< of first order and stationary
  };
  Basis basis = Basis::kPolynomial;
  int degree = 0;                     ///< polynomial: Legendre 0..degree, <= kMaxDegree
  double knot_spacing_s = kNotGiven;  ///< spline
  Axes axes = Axes::kTrack;
  std::array<bool, 3> components{true, true, true};  ///< along, across, up or x, y, z
  /// Per axis: empty = no prior; one value = for every degree or spline coefficient; else one a
  /// degree (polynomial only, size degree + 1).
  std::array<std::vector<double>, 3> prior_sigma_m;
  Process process = Process::kWhite;      ///< spline; others need one sigma an axis that has any
  double correlation_time_s = kNotGiven;  ///< of kGaussMarkov: correlations fall as exp(-t/T)
  /// Standard deviation of the first coefficient of kRandomWalk, by axis.
  std::array<PriorSigma, 3> start_sigma_m{kNotGiven, kNotGiven, kNotGiven};
  static constexpr int kMaxDegree = 15;
};

/// Error of the velocity direction in the cone only: v/|v| + c_across across + c_up up.
struct VelocityCorrection {
  std::array<bool, 2> components{true, true};                   ///< across, up
  std::array<PriorSigma, 2> prior_sigma{kNotGiven, kNotGiven};  ///< dimensionless
};

/// R = rho + bias + scale rho.
struct RangeCorrection {
  bool bias = false;
  PriorSigma bias_prior_sigma_m = kNotGiven;
  bool scale = false;
  PriorSigma scale_prior_sigma = kNotGiven;  ///< dimensionless (the file gives ppm)
};

/// The path is read at t + bias.
struct TimeCorrection {
  PriorSigma bias_prior_sigma_s = kNotGiven;
};

/// tau + bias in the Doppler cone.
struct SquintCorrection {
  PriorSigma bias_prior_sigma_rad = kNotGiven;
};

/// Adds zenith * exp(-h / scale_height) / cos(incidence at the target) to the range.
struct TroposphereCorrection {
  PriorSigma zenith_prior_sigma_m = kNotGiven;
  double scale_height_m = 7000.0;
};

/// A correction of one kind.
using Correction = std::variant<PositionCorrection,
                                VelocityCorrection,
                                RangeCorrection,
                                TimeCorrection,
                                SquintCorrection,
                                TroposphereCorrection>;
/// Its kind: the index of the variant.
enum class CorrectionKind : std::uint8_t {
  kPosition,
  kVelocity,
  kRange,
  kTime,
  kSquint,
  kTroposphere
};

/// One group of corrections for some passes.
struct CorrectionGroup {
  std::string name;  ///< as in the file ("position", "range"); owner of shared parameters
  Correction model;
  std::vector<std::string> passes;  ///< empty: all
  bool shared = false;              ///< one set of parameters for all of `passes`
};

/// A matrix of any size whose memory is the standard library's. Programs and this library may be
/// compiled for different processors, and matrices of Eigen are then aligned differently: those of
/// a size not known to the compiler cannot be handed from one to the other.
struct DenseMatrix {
  std::size_t rows = 0, columns = 0;
  std::vector<double> values;  ///< column by column

  DenseMatrix() = default;
  /// Copies any matrix of Eigen.
  template <typename Derived>
  DenseMatrix(const Eigen::EigenBase<Derived>& matrix)  // NOLINT(google-explicit-constructor)
      : rows(static_cast<std::size_t>(matrix.rows())),
        columns(static_cast<std::size_t>(matrix.cols())),
        values(rows * columns) {
    Eigen::Map<Eigen::MatrixXd>(values.data(), matrix.rows(), matrix.cols()) = matrix;
  }
  [[nodiscard]] bool empty() const { return values.empty(); }
  [[nodiscard]] double& operator()(std::size_t row, std::size_t column) {
    return values[column * rows + row];
  }
  [[nodiscard]] double operator()(std::size_t row, std::size_t column) const {
    return values[column * rows + row];
  }
  /// As a matrix of Eigen, as long as this one is not changed.
  [[nodiscard]] Eigen::Map<const Eigen::MatrixXd> matrix() const {
    return {values.data(), static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns)};
  }
  bool operator==(const DenseMatrix&) const = default;
};

/// One prior of several corrections of a pass, with their full covariance
/// (docs/theory/adjustment.md, eq. (3a)). Every pass draws its own; the parameters are those of the
/// pass itself, neither shared by passes nor coefficients of a spline, and have no standard
/// deviation of their own.
struct JointPrior {
  /// Axes in which the position parameters are named and their covariance is given.
  enum class Axes {
    kCorrection,   ///< those of the pass's position correction
    kTrack,        ///< along, across, up
    kFrame,        ///< x, y, z
    kRic,          ///< radial, in-track, cross-track, of the velocity in the block's frame
    kRicInertial,  ///< the same, of the velocity that does not turn with the body
  };
  std::string name;
  std::vector<std::string> passes;  ///< empty: all that have the parameters
  /// As results name them ("position.along.0", "range.bias"); in axes other than those of the
  /// correction all three of a degree, which are turned at the middle of the strip.
  std::vector<std::string> parameters;
  Axes axes = Axes::kCorrection;
  /// Symmetric, positive definite, in the order of `parameters`: products of their units (m, s,
  /// rad, 1). Or empty, with standard deviations and, unless they are independent, correlations in
  /// its place.
  DenseMatrix covariance;
  std::vector<double> sigma;
  DenseMatrix correlation;

  /// The covariance, however it was given.
  [[nodiscard]] DenseMatrix Covariance() const;
};

/// True where two groups that are not shared exclude each other for one pass: both of one kind,
/// position groups only where they have a component in common or have different axes.
[[nodiscard]] bool Overlap(const CorrectionGroup& a, const CorrectionGroup& b);

/// Corrections of an adjustment: the groups that are given (of which there may be none), none
/// whatever is given, or those that the measurements show.
enum class CorrectionChoice { kGiven, kNone, kAuto };
enum class RobustLoss { kNone, kHuber, kCauchy, kTukey };
enum class CovarianceLevel { kNone, kLeberl, kIntersection, kBlock, kMonteCarlo };
enum class Datum { kGiven, kInner };
enum class Engine { kAuto, kCeres, kReduced };
/// How Ceres solves its normal equations once the points are eliminated: the reduced matrix dense,
/// sparse, or never formed and solved by conjugate gradients.
enum class CeresSolver { kAuto, kDenseSchur, kSparseSchur, kIterativeSchur };
enum class CovarianceMethod { kAuto, kReduced, kCeres };
enum class PairChoice { kNone, kNeighbours, kAll, kDistances, kList };
enum class VarianceComponents { kNone, kRangeAzimuth, kPerPass };
enum class BlunderTest { kW, kTau };
enum class FamilyWise { kNone, kSidak, kBonferroni };
enum class Snooping { kNone, kIterative, kRobust };

/// The `[adjust.quality]` table: tests of single observations and the search for blunders
/// (docs/theory/quality.md).
struct QualityOptions {
  double alpha = 0.001;  ///< level of a test, or of all together with `family_wise`
  double power = 0.80;   ///< with which a minimal detectable blunder is found
  FamilyWise family_wise = FamilyWise::kNone;
  BlunderTest test = BlunderTest::kW;  ///< kTau where the standard deviations are known but for a
                                       ///< common factor
  Snooping snooping = Snooping::kNone;
  /// A block that contradicts itself as asked for is solved once more by consensus of its looks
  /// (docs/theory/consensus.md).
  bool consensus = true;
  double separation = 0.95;  ///< probability of naming no wrong look, see blunder_search.h
};

/// How `corrections = "auto"` chooses (docs/theory/selection.md).
struct SelectionOptions {
  enum class Mode {
    kCommon,   ///< the same corrections for all passes, each with values of its own
    kPerPass,  ///< every pass for itself
  };
  Mode mode = Mode::kCommon;
  double significance = 0.05;  ///< level of the F tests of one step, all candidates together
  /// Kinds tried where no correction groups are given. Velocity errors act like a squint that
  /// differs from look to look and are tried only when asked for.
  std::vector<CorrectionKind> kinds{CorrectionKind::kPosition,
                                    CorrectionKind::kRange,
                                    CorrectionKind::kTime,
                                    CorrectionKind::kSquint,
                                    CorrectionKind::kTroposphere};
  int max_degree = 3;                                  ///< of position polynomials
  std::optional<std::vector<double>> knot_spacings_s;  ///< not given: a quarter and an eighth of
                                                       ///< the longest strip
  double max_condition = 1e8;        ///< beyond it a candidate is not determinable
  double max_posterior_prior = 0.9;  ///< beyond it the observations add nothing to the prior
  double simplify = 0.01;  ///< part of its sigma by which a simplification may move a point
  static constexpr std::size_t kMaxSpacings = 3;
};

/// What an adjustment is asked for: the `[adjust]` table of a block without what needs files
/// (AdjustTable in files/block_file.h).
struct AdjustOptions {
  CorrectionChoice corrections = CorrectionChoice::kGiven;
  std::vector<CorrectionGroup> groups;  ///< that are estimated; with kAuto the candidates, if there
                                        ///< are some
  std::vector<JointPrior> priors;       ///< of `groups`; not with kAuto
  SelectionOptions selection;           ///< of kAuto
  RobustLoss robust = RobustLoss::kNone;
  double robust_scale = 0.0;  ///< in sigmas; 0: 1.345 Huber, 2.385 Cauchy, 4.685 Tukey (95 percent
                              ///< efficiency at the normal distribution)
  CovarianceLevel covariance = CovarianceLevel::kBlock;
  /// Differences of points; kList: those handed to Adjust() or Predict(), which need not be said.
  PairChoice pairs = PairChoice::kNone;
  Datum datum = Datum::kGiven;
  /// kInner: ids of the points whose coordinates fix the datum; empty: all that are solved.
  std::vector<std::string> datum_points;
  bool scale_by_posterior = false;
  VarianceComponents variance_components = VarianceComponents::kNone;
  /// kRangeAzimuth: pass ids that share their variances; empty: all passes together.
  std::vector<std::vector<std::string>> variance_groups;
  int montecarlo_runs = 200;
  std::uint64_t montecarlo_seed = 1;
  /// A guard; iteration ends before where steps no longer shrink (docs/theory/adjustment.md).
  int max_iterations = 1000;
  /// Newton decrement, in sigmas over all unknowns together, at which iteration ends. Above
  /// kRemainingStepAccepted (adjust.h) nothing would be accepted.
  double tolerance = 1e-6;
  Engine engine = Engine::kAuto;
  CeresSolver ceres_solver = CeresSolver::kAuto;  ///< with Engine::kCeres alone
  CovarianceMethod covariance_method = CovarianceMethod::kAuto;
  QualityOptions quality;
  double test_level = 0.999;  ///< chance that a block without mistakes passes all its tests
  /// Threads of a call at most, the caller's own among them; 0, or more than it has: all that it
  /// may use. No other thread of the process is limited (a task arena of TBB). `--threads`.
  int threads = 1;
  /// Memory that an adjustment may be predicted to need (ResourceNeeds); more is refused before
  /// it is allocated. 0: what this computer has free. `--memory`.
  double memory_mib = 0.0;
};

}  // namespace sarblock
