// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// A defect of the network configuration that affects the adjustment.
struct Finding {
  std::string text;                ///< the defect, its passes or points, and a remedy
  std::vector<std::string> names;  ///< of the passes or points concerned
};

/// How the passes of a block are connected by the points that take part: passes are nodes, a point
/// joins all passes whose looks of it are in use (union-find).
struct PassConnection {
  int components = 0;                        ///< of the passes that have looks
  std::vector<std::uint8_t> pass_has_looks;  ///< by pass

  /// True where `after` has as few connected components and no pass lost its last look.
  [[nodiscard]] bool IsKeptBy(const PassConnection& after) const;
};

[[nodiscard]] PassConnection ConnectPasses(const AdjustmentProblem& problem);

/// Defects of the network configuration, before any equation is formed: connected components,
/// passes with too few points, one point, points or control on one line, control on one side or
/// missing, time and along-track both free, range bias, across and up all free on a narrow swath.
/// Points count that `problem` solves, at the positions of `state` (start values will do). Freedoms
/// that priors or passes without corrections fix are no findings. `check` and `adjust` print the
/// same messages. docs/theory/rank.md, section 1, has the limits.
[[nodiscard]] std::vector<Finding> ExamineStructure(const AdjustmentProblem& problem,
                                                    const BlockState& state);

/// Sets of passes that no point connects, each ascending; passes without a look that takes part are
/// in none.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> ConnectedComponents(
    const AdjustmentProblem& problem);

}  // namespace sarblock
