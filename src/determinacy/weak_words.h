// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "model/problem.h"
#include "rank_report.h"

namespace sarblock {

/// What the parameters of a direction are ("across position (constant) of all passes and range bias
/// of A1"), what that means and what would remove it. `pass_of_parameter` from PassOfParameters.
[[nodiscard]] std::string DescribeDirection(const AdjustmentProblem& problem,
                                            const std::vector<int>& pass_of_parameter,
                                            const WeakDirection& direction);

}  // namespace sarblock
