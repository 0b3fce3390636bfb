// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <cstddef>

namespace sarblock {

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

/// For `tests` >= 0 observations of a block with `redundancy` degrees of freedom.
///     k      = N^-1(1 - alpha/2)                                      (Baarda 1968)
///     tau    = sqrt(f) t / sqrt(f - 1 + t^2),  t = t_{f-1}^-1(1 - alpha/2)    (Pope 1976)
///     delta0 : N(delta0 - k) + N(-delta0 - k) = power
/// Throws InputError where alpha or power is not between 0 and 1 or power <= alpha.
[[nodiscard]] ReliabilityFigures MakeReliability(const QualityOptions& options,
                                                 std::size_t tests,
                                                 double redundancy);

/// Chance that |w| exceeds `critical_1` where its expectation is `shift_1`.
[[nodiscard]] double TestPower(double shift_1, double critical_1);

/// Minimal detectable blunder delta0 sigma / sqrt(r), in the unit of sigma; NaN where no test is.
[[nodiscard]] double MinimalDetectable(double delta0_1, double sigma_m, double redundancy_1);

/// Shift of the point by a blunder of that size, delta0 / sqrt(r) times the shift by one sigma [m].
[[nodiscard]] double Influence_m(double delta0_1, double shift_m, double redundancy_1);

}  // namespace sarblock
