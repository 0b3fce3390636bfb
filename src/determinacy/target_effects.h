// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "model/problem.h"
#include <Eigen/Core>

namespace sarblock {

/// Metres at the target that one unit of each parameter moves a look, and the mean slant range.
struct TargetEffects {
  Eigen::VectorXd metres;
  double range_m = 0.0;
};

/// `pass_of_parameter` from PassOfParameters.
[[nodiscard]] TargetEffects TargetEffectsOf(const AdjustmentProblem& problem,
                                            const std::vector<int>& pass_of_parameter);

}  // namespace sarblock
