// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "model/problem.h"
#include "structure.h"

namespace sarblock {

/// Points that would get a solution although their own looks do not determine them, on the paths
/// of a state. Control points, which their coordinates fix, are not examined.
struct PointDefects {
  std::vector<std::size_t> touching;    ///< circles meet tangentially
  std::vector<std::size_t> coinciding;  ///< circles are the same (zero base, single flight)
  std::vector<std::size_t> ambiguous;   ///< a mirror point fits as well; start coordinates decided
};
[[nodiscard]] PointDefects FindPointDefects(const AdjustmentProblem& problem,
                                            const BlockState& state);
/// Leaves touching and coinciding points out by name, and ambiguous ones whose coordinates were not
/// given; true if there were any.
bool LeaveOutOpenPoints(const PointDefects& defects, AdjustmentProblem* problem);
/// In words: points left out with the reason of the first; points whose given coordinates chose
/// between two solutions.
[[nodiscard]] std::vector<Finding> DescribePoints(const AdjustmentProblem& problem,
                                                  const PointDefects& defects);

}  // namespace sarblock
