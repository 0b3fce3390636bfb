// SPDX-License-Identifier: Apache-2.0
#include "global_test.h"

#include "sarblock/core/statistics.h"
#include "sarblock/model/result.h"

#include <algorithm>

#include "model/problem.h"

namespace sarblock {

double SquareLeftOut(std::size_t dropped, std::size_t looks, const AdjustResult& result) {
  constexpr double kMostByChance_1 = 0.01;
  const double limit_1 = FarSquare_1();
  double square_1 = 0.0, count = 0.0;
  const auto add = [&](double number, double each_1) {
    square_1 += number * each_1;
    count += number;
  };
  add(static_cast<double>(dropped), limit_1);
  if (result.snooping) {
    add(static_cast<double>(result.snooping->robust.size()), limit_1);
    for (const BlunderFinding& finding : result.snooping->findings) {
      if (!LeavesOut(finding)) continue;
      // One statistic tells of all the looks of a point that contradict each other.
      const double square = finding.w_1 * finding.w_1;
      add(1.0, square < limit_1 ? square : limit_1);  // no w of its own: NaN
    }
  }
  const double most = kMostByChance_1 * static_cast<double>(looks);
  return count > most ? square_1 * most / count : square_1;
}

GlobalTest TestGlobally(const AdjustmentProblem& problem,
                        double level,
                        double square_sum_1,
                        double left_out_1) {
  const ProblemCounts counts = CountProblem(problem);
  GlobalTest test;
  test.redundancy_1 = counts.redundancy();
  if (!(test.redundancy_1 > 0.0)) return test;
  test.sigma0_squared = square_sum_1 / test.redundancy_1;
  test.chi_square = ChiSquareInterval(level, test.redundancy_1);
  test.chi_square.lower = std::max(0.0, test.chi_square.lower - left_out_1);
  test.passed = test.chi_square.Contains(square_sum_1);
  return test;
}

}  // namespace sarblock
