// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <string>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// For `tests` >= 0 observations of a block with `redundancy` degrees of freedom.
///     k      = N^-1(1 - alpha/2)                                      (Baarda 1968)
///     tau    = sqrt(f) t / sqrt(f - 1 + t^2),  t = t_{f-1}^-1(1 - alpha/2)    (Pope 1976)
///     delta0 : N(delta0 - k) + N(-delta0 - k) = power
/// Throws InputError where alpha or power is not between 0 and 1 or power <= alpha.
[[nodiscard]] ReliabilityFigures MakeReliability(const QualityOptions& options,
                                                 std::size_t tests,
                                                 double redundancy);

/// Chance that |w| exceeds `critical` where its expectation is `shift`.
[[nodiscard]] double TestPower(double shift, double critical);

/// Minimal detectable blunder delta0 sigma / sqrt(r), in the unit of sigma; NaN where there is no
/// test.
[[nodiscard]] double MinimalDetectable(double delta0, double sigma_m, double redundancy);

/// Shift of the point by a blunder of that size, delta0 / sqrt(r) times the shift by one sigma [m].
[[nodiscard]] double Influence_m(double delta0, double shift_m, double redundancy);

/// Part of v'Pv that may be missing because good looks were left out: `dropped` outliers of a
/// robust solution and those that the search of `result` left out. Each removed at least the limit
/// of its test. At most one in a hundred of all looks counts as left out although good.
/// docs/theory/quality.md, eq. (19).
[[nodiscard]] double SquareLeftOut(std::size_t dropped,
                                   std::size_t looks,
                                   const AdjustResult& result);

/// Factor on covariances: sigma0_squared with `scale_by_posterior`, if it is known; else 1.
[[nodiscard]] double PosteriorFactor(const AdjustOptions& options, const AdjustResult& result);

/// Errors of check points against their known positions.
void FillChecks(const Block& block, const AdjustOptions& options, AdjustResult* result);

/// Test of a prior (docs/theory/quality.md, eq. (18)): c the correction, which the prior expects to
/// be zero with the standard deviation sigma0, sigma its standard deviation in the result:
///     r = 1 - sigma^2 / sigma0^2,   w = c / (sigma0 sqrt(r))
/// For a joint prior Q with P = Q^-1 and C, the covariance of its corrections in the result (eq.
/// (18a)):
///     r_i = 1 - (C P)_ii,   w_i = (P c)_i / sqrt(N_ii),   N = P - P C P,   v'Pv: c_i (P c)_i
struct PriorTest {
  /// Part of the redundancy of the block; NaN without a prior or without a standard deviation. For
  /// a joint prior it may lie outside 0 to 1, but the sum over the prior does not.
  double redundancy = kNotGiven;
  /// NaN also where r (for a joint prior N_ii / P_ii) is kMinRedundancy or less, or nothing is
  /// measured.
  double w = kNotGiven;
  double square = kNotGiven;  ///< part of v'Pv; NaN where w is or nothing is measured
};
/// By parameter of the result.
[[nodiscard]] std::vector<PriorTest> TestsOfPriors(const AdjustResult& result);

/// Number of tests that make a verdict. They share equally the chance of failing that `test_level`
/// leaves to a block without mistakes. Looks and control; ranges; azimuths; control; priors; check
/// points; the largest test of an observation; the number of those beyond their critical value; the
/// largest of a prior.
inline constexpr double kTestsOfVerdict = 9.0;
/// Level of one of them, 1 - (1 - test_level) / kTestsOfVerdict.
[[nodiscard]] double LevelOfOneTest(double test_level);

/// By how much standard deviations may be wrong before a test of a group fails, whatever its level.
inline constexpr double kSigmaThatMatters = 0.02;
/// How many times too tight priors may be, as a group, before their test fails: tighter ones
/// distort a solution or are of no use.
inline constexpr double kPriorsThatMatter = 3.0;

/// All priors of a layout in one sum. With W the rows that make them observations of unit variance,
/// C the covariance of the corrections and K = W C W':
///     v'Pv = |W (c - c0)|^2,   redundancy = tr(I - K),   unsure = tr(K - K^2)
/// Looks and control, n observations and u unknowns, have the redundancy n - u + tr(K); if the
/// priors were exact, tr(Q_vv^2) = n - u + tr(K^2) of it would remain.
struct PriorSums {
  bool known = false;  ///< all corrections with a prior have a covariance
  double square_sum = 0.0, redundancy = 0.0, unsure = 0.0;
};
/// Entries of K that `covariance` leaves out count as zero. Without priors all sums are zero.
[[nodiscard]] PriorSums SumPriors(const ParameterLayout& layout,
                                  const Eigen::VectorXd& corrections,
                                  const std::vector<ParameterCovariance>& covariance);

/// v'Pv of all observations of a problem, and the part that was removed with good looks that were
/// left out.
struct SquareSum {
  double kept = kNotGiven;
  double left_out = 0.0;
};

/// The test of looks and control, without the priors: v'Pv over the sum of their redundancies,
/// against chi-square at the level of one test, 2 % of the standard deviations allowed. Where the
/// priors' redundancy is not known all observations are tested. docs/theory/quality.md, "Groups".
[[nodiscard]] GlobalTest TestMeasurements(const ProblemCounts& counts,
                                          const PriorSums& priors,
                                          const SquareSum& square_sum,
                                          double test_level);

/// Whether v'Pv of all priors is no larger than chance allows at the level of one test.
[[nodiscard]] bool PriorsHold(const PriorSums& priors, double test_level);

/// Those of the groups ranges, azimuths, control, priors and all observations that exist; `result`
/// has its quality figures. Without these, or without the redundancy of priors, only the groups
/// that are known.
[[nodiscard]] std::vector<ObservationGroup> ListGroups(const AdjustmentProblem& problem,
                                                       const PriorSums& priors,
                                                       const SquareSum& square_sum,
                                                       double test_level,
                                                       const AdjustResult& result);

/// Contradicted priors: kinds of corrections whose priors are too tight as a group, and by which
/// factor, or single ones. Each text is empty where there are none.
struct PriorFindings {
  std::string reason;  ///< against `accepted`
  /// Names single priors that bend their corrections by less than one standard deviation.
  std::string note;
};
[[nodiscard]] PriorFindings TestPriors(const AdjustResult& result, double test_level);

/// How the warning of EmptyPriors() begins.
inline constexpr const char* kWidePriors = "priors far wider than what came out say nothing";
/// Kinds of corrections whose priors are more than ten times wider than the corrections found, and
/// by how much the standard deviations of points would shrink at most with suitable priors; empty
/// where that is less than `kSigmaThatMatters`.
[[nodiscard]] std::string EmptyPriors(const AdjustResult& result);

}  // namespace sarblock
