// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/statistics.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sarblock {

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
inline constexpr double kLeastRedundancy_1 = 1e-9;

/// Levels, critical values and the non-centrality of the tests of single observations
/// (docs/theory/quality.md, eq. (7)-(13)).
struct ReliabilityFigures {
  std::size_t tests = 0;        ///< observations that can be tested
  double alpha_one_1 = 0.0;     ///< level of each test, after `family_wise`
  double alpha_all_1 = 0.0;     ///< chance that one of all rejects without cause, were they
                                ///< independent
  double critical_w_1 = 0.0;    ///< of |w|
  double critical_tau_1 = 0.0;  ///< of |tau|; NaN where the redundancy is 1 or less
  double delta0_1 = 0.0;        ///< shift of w that is found with the power asked for
};

/// One observation whose test is among the largest.
struct TestedLook {
  std::uint64_t look = 0;
  std::uint32_t point = 0;
  bool azimuth = false;
  double w_1 = 0.0;
  double redundancy_1 = 0.0;
};

/// The tests of a result in short. Above the critical value counts |w| or, where that is the test,
/// |tau|.
struct QualitySummary {
  ReliabilityFigures figures;
  std::array<std::size_t, 2> looks_tested{};  ///< range, azimuth
  std::array<std::size_t, 2> looks_above{};
  std::size_t control_tested = 0, control_above = 0;
  /// Looks tested whose point has one degree of freedom: all its tests are one.
  std::size_t looks_not_localisable = 0;
  std::array<double, 2> median_redundancy_1{};  ///< NaN without looks
  std::vector<TestedLook> worst;                ///< largest |w| first, at most ten; none predicted
  std::size_t worst_control = 0;                ///< index into `control_quality`
  double worst_control_w_1 = kNotGiven;         ///< NaN where no control is tested
  [[nodiscard]] std::size_t above() const {
    return looks_above[0] + looks_above[1] + control_above;
  }
  /// Above the critical value by chance.
  [[nodiscard]] double expected_above_1() const {
    return figures.alpha_one_1 * static_cast<double>(figures.tests);
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
  double freedom_1 = 0.0;  ///< independent components they are worth
  double chi_square = 0.0;
  Interval chi_square_interval;    ///< two-sided at test_level
  std::size_t points_outside = 0;  ///< chi-square alone above the quantile at test_level
  /// sqrt(chi_square / components): errors in units of what was predicted, and its interval.
  double error_ratio_1 = kNotGiven;
  Interval error_ratio_interval_1;
  [[nodiscard]] bool realistic() const { return chi_square_interval.Contains(chi_square); }
};

/// The tests of priors in short, at the level of one observation.
struct PriorSummary {
  std::size_t priors = 0;  ///< with a redundancy number
  std::size_t tested = 0;  ///< with a standardised residual
  std::size_t above = 0;   ///< beyond the critical value of |w| (|tau| where that is the test)
  double expected_above_1 = 0.0;    ///< by chance
  std::size_t worst = 0;            ///< index of the parameter with the largest |w|
  double worst_w_1 = kNotGiven;     ///< NaN where none is tested
  double redundancy_1 = kNotGiven;  ///< of all priors together
};

/// What a pass (or a group of corrections that passes share) has of v'Pv and of the redundancy of
/// the block. The shares of all, and of the control points, add to both but for observations
/// without redundancy.
struct PassShare {
  std::string owner;                              ///< id of the pass, or name of the group
  std::size_t looks = 0;                          ///< with redundancy numbers
  double square_sum_1 = 0.0, redundancy_1 = 0.0;  ///< of its looks
  double prior_square_sum_1 = 0.0, prior_redundancy_1 = 0.0;  ///< of its priors
  /// v'Pv over redundancy of both together; NaN where there is no redundancy.
  [[nodiscard]] double variance_factor() const {
    const double redundancy = redundancy_1 + prior_redundancy_1;
    return redundancy > kLeastRedundancy_1 ? (square_sum_1 + prior_square_sum_1) / redundancy
                                           : kNotGiven;
  }
};

/// The verdict on a result and the figures of the tests that it rests on.
struct Assessment {
  Verdict verdict = Verdict::kNotAccepted;
  /// Why it is not `accepted`, the gravest first: what failed, by how much, and what usually causes
  /// it. Empty for an accepted result.
  std::vector<std::string> reasons;
  QualitySummary tests;  ///< empty counts where no quality figures were computed
  PriorSummary priors;
  CheckSummary checks;            ///< empty counts without check points
  std::vector<PassShare> shares;  ///< by pass in order, then shared groups; empty without figures
};

}  // namespace sarblock
