// SPDX-License-Identifier: Apache-2.0
#include "global_test.h"

#include "sarblock/core/quantile.h"

namespace sarblock {

GlobalTest TestGlobally(const AdjustmentProblem& problem, double level, double square_sum_1) {
  const ProblemCounts counts = CountProblem(problem);
  GlobalTest test;
  test.redundancy_1 = counts.redundancy();
  if (!(test.redundancy_1 > 0.0)) return test;
  test.sigma0_squared = square_sum_1 / test.redundancy_1;
  test.chi_square = ChiSquareInterval(level, test.redundancy_1);
  test.passed = test.chi_square.Contains(square_sum_1);
  return test;
}

}  // namespace sarblock
