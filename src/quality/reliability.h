// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstddef>

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

/// Chance that |w| exceeds `critical_1` where its expectation is `shift_1`.
[[nodiscard]] double TestPower(double shift_1, double critical_1);

/// Minimal detectable blunder delta0 sigma / sqrt(r), in the unit of sigma; NaN where no test is.
[[nodiscard]] double MinimalDetectable(double delta0_1, double sigma_m, double redundancy_1);

/// Shift of the point by a blunder of that size, delta0 / sqrt(r) times the shift by one sigma [m].
[[nodiscard]] double Influence_m(double delta0_1, double shift_m, double redundancy_1);

/// What v'Pv may lack because good looks were left out, `dropped` far off in a robust solution and
/// those that the search of `result` left out: each took at least the limit of its test with it. Of
/// all looks one in a hundred at most is taken for good. docs/theory/quality.md, eq. (19).
[[nodiscard]] double SquareLeftOut(std::size_t dropped,
                                   std::size_t looks,
                                   const AdjustResult& result);

/// v'Pv against chi-square of the redundancy, two-sided, the lower end lower by `left_out_1`; NaN
/// without redundancy.
[[nodiscard]] GlobalTest TestGlobally(const AdjustmentProblem& problem,
                                      double level,
                                      double square_sum_1,
                                      double left_out_1 = 0.0);

/// Errors of check points against their known positions.
void FillChecks(const Block& block, const AdjustOptions& options, AdjustResult* result);

}  // namespace sarblock
