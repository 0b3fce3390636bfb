// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// Looks of a pass that take part, and those that were left out.
struct LookCounts {
  std::size_t kept = 0, lost = 0;

  /// Part that was left out; 0 of none.
  [[nodiscard]] double lost_1() const {
    return lost == 0 ? 0.0 : static_cast<double>(lost) / static_cast<double>(kept + lost);
  }
  /// As many for a path as against it decide nothing.
  [[nodiscard]] bool Decide() const { return lost < 2 || lost < kept; }
};

/// Of one pass, at points of two looks and more. `deciding` are those at points of three looks and
/// more: two looks meet nearly always, wherever their paths are, and speak for none.
struct PassLooks {
  LookCounts all, deciding;
};

/// By pass. A look that the block rejects is not counted.
std::vector<PassLooks> CountPassLooks(const AdjustmentProblem& problem);

}  // namespace sarblock
