// SPDX-License-Identifier: Apache-2.0
#include "step_tolerance.h"

#include <algorithm>

namespace sarblock {

double ToleranceFor(double tolerance_1, const AdjustmentProblem& problem) {
  const double share_1 = 1e-3 * static_cast<double>(problem.block.points.size());
  return tolerance_1 * std::clamp(share_1, 1e-2, 1.0);
}

const char kStagnates[] =
    "the steps no longer shrink, more iterations would not end it (contradicting observations, "
    "start values too far off, or corrections that are hardly determined)";

std::string LimitReached(int max_iterations) {
  return "the steps still shrank when max_iterations = " + std::to_string(max_iterations) +
         " ended them; raise it";
}

bool ProgressOfSteps::Stagnates(int iteration, double cost_1, double decrement_1) {
  constexpr int kWindow = 50;
  if (iteration < iteration_ + kWindow) return false;
  const bool shrinks = cost_1 < 0.999 * cost_1_ || decrement_1 < 0.5 * decrement_1_;
  iteration_ = iteration;
  cost_1_ = cost_1;
  decrement_1_ = decrement_1;
  return !shrinks;
}

}  // namespace sarblock
