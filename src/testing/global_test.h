// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <cstddef>

#include "model/problem.h"

namespace sarblock {

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

}  // namespace sarblock
