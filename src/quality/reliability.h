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

/// Chance that |w| exceeds `critical` where its expectation is `shift`.
[[nodiscard]] double TestPower(double shift, double critical);

/// Minimal detectable blunder delta0 sigma / sqrt(r), in the unit of sigma; NaN where no test is.
[[nodiscard]] double MinimalDetectable(double delta0, double sigma_m, double redundancy);

/// Shift of the point by a blunder of that size, delta0 / sqrt(r) times the shift by one sigma [m].
[[nodiscard]] double Influence_m(double delta0, double shift_m, double redundancy);

/// What v'Pv may lack because good looks were left out, `dropped` far off in a robust solution and
/// those that the search of `result` left out: each took at least the limit of its test with it. Of
/// all looks one in a hundred at most is taken for good. docs/theory/quality.md, eq. (19).
[[nodiscard]] double SquareLeftOut(std::size_t dropped,
                                   std::size_t looks,
                                   const AdjustResult& result);

/// Errors of check points against their known positions.
void FillChecks(const Block& block, const AdjustOptions& options, AdjustResult* result);

}  // namespace sarblock
