// SPDX-License-Identifier: Apache-2.0
#include "step_tolerance.h"

#include <algorithm>

namespace sarblock {

double ToleranceFor(double tolerance_1, const AdjustmentProblem& problem) {
  const double share_1 = 1e-3 * static_cast<double>(problem.block.points.size());
  return tolerance_1 * std::clamp(share_1, 1e-2, 1.0);
}

}  // namespace sarblock
