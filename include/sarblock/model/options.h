// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/corrections.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sarblock {

enum class CorrectionChoice { kGiven, kNone, kAuto };
enum class RobustLoss { kNone, kHuber, kCauchy, kTukey };
enum class CovarianceLevel { kNone, kLeberl, kIntersection, kBlock, kMonteCarlo };
enum class Datum { kGiven, kInner };
enum class Engine { kAuto, kCeres, kReduced };
/// How Ceres solves its normal equations once the points are eliminated: the reduced matrix dense,
/// sparse, or never formed and solved by conjugate gradients.
enum class CeresSolver { kAuto, kDenseSchur, kSparseSchur, kIterativeSchur };
enum class CovarianceMethod { kAuto, kReduced, kCeres };
enum class PairChoice { kNone, kNeighbours, kAll, kList };
enum class VarianceComponents { kNone, kRangeAzimuth, kPerPass };
enum class BlunderTest { kW, kTau };
enum class FamilyWise { kNone, kSidak, kBonferroni };
enum class Snooping { kNone, kIterative, kRobust };

/// The `[adjust.quality]` table: tests of single observations and the search for blunders
/// (docs/theory/quality.md).
struct QualityOptions {
  double alpha_1 = 0.001;  ///< level of a test, or of all together with `family_wise`
  double power_1 = 0.80;   ///< with which a minimal detectable blunder is found
  FamilyWise family_wise = FamilyWise::kNone;
  BlunderTest test = BlunderTest::kW;  ///< kTau where the standard deviations are known but for a
                                       ///< common factor
  Snooping snooping = Snooping::kNone;
  /// A block that contradicts itself as asked for is solved once more by consensus of its looks
  /// (docs/theory/consensus.md).
  bool consensus = true;
  double separation_1 = 0.95;  ///< probability of naming no wrong look, see blunder_search.h
};

/// How `corrections = "auto"` chooses (docs/theory/selection.md).
struct SelectionOptions {
  enum class Mode {
    kCommon,   ///< the same corrections for all passes, each with values of its own
    kPerPass,  ///< every pass for itself
  };
  Mode mode = Mode::kCommon;
  double significance_1 = 0.05;  ///< level of the F tests of one step, all candidates together
  /// Kinds tried where no correction groups are given; indices of CorrectionGroup::model. Velocity
  /// errors act like a squint that differs from look to look and are tried only when asked for.
  std::vector<std::size_t> kinds{0, 2, 3, 4, 5};
  int max_degree = 3;                                  ///< of position polynomials
  std::optional<std::vector<double>> knot_spacings_s;  ///< not given: a quarter and an eighth of
                                                       ///< the longest strip
  double max_condition_1 = 1e8;        ///< beyond it a candidate is not determinable
  double max_posterior_prior_1 = 0.9;  ///< beyond it the observations add nothing to the prior
  double simplify_1 = 0.01;  ///< part of its sigma by which a simplification may move a point
  static constexpr std::size_t kMostSpacings = 3;
};

/// Why corrections = "auto" refuses joint priors.
inline constexpr const char* kNoAutomaticPriors =
    "stands beside corrections = \"auto\", which chooses among corrections with priors that are "
    "independent; allowed is \"given\", or standard deviations in the correction tables";

/// The `[adjust]` table of a block (interface.md). Defaults as there.
struct AdjustOptions {
  CorrectionChoice corrections = CorrectionChoice::kNone;
  std::vector<CorrectionGroup> groups;  ///< used when corrections == kGiven;
                                        ///< with kAuto the candidates, if there are some
  std::vector<JointPrior> priors;       ///< of `groups`; not with kAuto
  SelectionOptions selection;           ///< used when corrections == kAuto
  RobustLoss robust = RobustLoss::kNone;
  double robust_scale = 0.0;  ///< in sigmas; 0: 1.345 Huber, 2.385 Cauchy, 4.685 Tukey (95 percent
                              ///< efficiency at the normal distribution)
  CovarianceLevel covariance = CovarianceLevel::kBlock;
  PairChoice pairs = PairChoice::kNone;
  std::string pairs_file;  ///< kList: CSV with columns point_a, point_b, relative to the block
  Datum datum = Datum::kGiven;
  /// kInner: ids of the points whose coordinates fix the datum; empty: all that are solved.
  std::vector<std::string> datum_points;
  bool scale_by_posterior = false;
  VarianceComponents variance_components = VarianceComponents::kNone;
  /// kRangeAzimuth: pass ids that share their variances; empty: all passes together.
  std::vector<std::vector<std::string>> variance_groups;
  int montecarlo_runs = 200;
  std::uint64_t montecarlo_seed = 1;
  /// Draws these of the runs alone and keeps them as AdjustResult::montecarlo_draws, for several
  /// machines (docs/studies.md); TaskPart::None() draws none. Set by the command line.
  std::optional<TaskPart> montecarlo_part = {};
  /// A guard; iteration ends before where steps no longer shrink (docs/theory/adjustment.md).
  int max_iterations = 1000;
  /// Newton step left, in sigmas over all unknowns together, at which iteration ends. Above
  /// kRemainingStepAccepted_1 (adjust.h) nothing would be accepted.
  double tolerance_1 = 1e-6;
  Engine engine = Engine::kAuto;
  CeresSolver ceres_solver = CeresSolver::kAuto;  ///< with Engine::kCeres alone
  CovarianceMethod covariance_method = CovarianceMethod::kAuto;
  QualityOptions quality;
  std::string rejections_file;  ///< CSV with columns pass, point, rejected, such as residuals.csv
                                ///< of a result, relative to the block; empty: none
  double test_level = 0.95;     ///< of the global (chi-square) test, two-sided
  bool diagnose = true;         ///< the command explains a result whose tests fail, see diagnose.h
  int threads = 1;              ///< set by the command line, not by the table
  /// Memory that an adjustment may be predicted to need (resource_needs.h); more is refused before
  /// it is allocated. 0: what this computer has free. Set by the command line.
  double memory_mib = 0.0;
};

}  // namespace sarblock
