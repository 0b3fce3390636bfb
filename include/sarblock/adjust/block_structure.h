// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/problem.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sarblock {

/// Something in the make of a block that its adjustment will suffer from.
struct Finding {
  std::string text;                ///< what, of which passes or points, and what would mend it
  std::vector<std::string> names;  ///< of the passes or points concerned
};

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

/// Points that a solution would be given for although their own looks do not determine them, on the
/// paths of a state. Control points, whose coordinates hold them, are not looked at.
struct PointDefects {
  std::vector<std::size_t> touching;    ///< circles meet tangentially
  std::vector<std::size_t> coinciding;  ///< circles are the same (zero base, single flight)
  std::vector<std::size_t> ambiguous;   ///< a mirror point fits as well; start coordinates decided
};
[[nodiscard]] PointDefects FindPointDefects(const AdjustmentProblem& problem,
                                            const BlockState& state);
/// Leaves touching and coinciding points out by name; true if there were any.
bool LeaveOutOpenPoints(const PointDefects& defects, AdjustmentProblem* problem);
/// In words: points left out with the reason of the first; points whose given coordinates chose
/// between two solutions.
[[nodiscard]] std::vector<Finding> DescribePoints(const AdjustmentProblem& problem,
                                                  const PointDefects& defects);

}  // namespace sarblock
