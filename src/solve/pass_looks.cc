// SPDX-License-Identifier: Apache-2.0
#include "pass_looks.h"

#include <cstdint>

namespace sarblock {

std::vector<PassLooks> CountPassLooks(const AdjustmentProblem& problem) {
  const Looks& looks = problem.block.looks;
  std::vector<PassLooks> by_pass(problem.block.passes.size());
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    std::size_t given = 0;
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      given += looks.rejected(i) ? 0U : 1U;
    }
    if (given < 2) continue;
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (looks.rejected(i)) continue;
      PassLooks& of_pass = by_pass[looks.pass[i]];
      const bool kept = problem.look_used[i] != 0;
      ++(kept ? of_pass.all.kept : of_pass.all.lost);
      if (given > 2) ++(kept ? of_pass.deciding.kept : of_pass.deciding.lost);
    }
  }
  return by_pass;
}

}  // namespace sarblock
