// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "finding.h"
#include "model/problem.h"

namespace sarblock {

/// Findings in the make of a block, before any equation is formed: islands, passes that too few
/// points see, one point, points or control on one line, control on one side or missing, time and
/// along-track both free, range bias, across and up all free on a narrow swath. Points count that
/// `problem` solves, at the positions of `state` (start values will do). What priors or passes
/// without corrections hold is no finding. `check` and `adjust` say the same words.
/// docs/theory/rank.md, section 1, has the limits.
[[nodiscard]] std::vector<Finding> ExamineStructure(const AdjustmentProblem& problem,
                                                    const BlockState& state);

/// Sets of passes that no point connects, each ascending; passes without a look that takes part are
/// in none.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> PassIslands(const AdjustmentProblem& problem);

}  // namespace sarblock
