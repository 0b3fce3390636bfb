// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/component_result.h"
#include "sarblock/adjust/problem.h"

namespace sarblock {

/// v'Pv against chi-square of the redundancy, two-sided; NaN without redundancy.
[[nodiscard]] GlobalTest TestGlobally(const AdjustmentProblem& problem,
                                      double level,
                                      double square_sum_1);

}  // namespace sarblock
