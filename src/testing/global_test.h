// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/component_result.h"

#include "model/problem.h"

namespace sarblock {

/// v'Pv against chi-square of the redundancy, two-sided; NaN without redundancy.
[[nodiscard]] GlobalTest TestGlobally(const AdjustmentProblem& problem,
                                      double level,
                                      double square_sum_1);

}  // namespace sarblock
