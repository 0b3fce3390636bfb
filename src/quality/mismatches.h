// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// Looks of one pass that were left out and are no scattered blunders: a matcher that took one
/// repeated pattern for the next, for instance, puts all of them off by the same distance. Where a
/// point has enough other looks this shows; where it has not, looks that are just as wrong were
/// kept.
struct Mismatch {
  std::uint32_t pass = 0;
  std::size_t lost = 0;   ///< looks of the pass that were left out
  std::size_t given = 0;  ///< looks of the pass at points of two looks and more
  /// Range and azimuth: the mean residual of the looks left out and its standard deviation [m],
  /// where the residuals agree in it; otherwise NaN.
  std::array<double, 2> shift_m{kNotGiven, kNotGiven};
  std::array<double, 2> shift_sigma_m{kNotGiven, kNotGiven};
  /// Points at which a look of this pass would hardly show the same error.
  std::size_t unchecked = 0;
  [[nodiscard]] bool alike() const;
};

/// By pass, the one that lost most first. A pass is listed whose lost looks have residuals of one
/// size (Student's t of their mean, chance below 1e-4 over all passes and both components), or that
/// lost more than the other passes (PassThatLosesMore, at that level). Needs the residuals of a
/// result and the reasons why looks were left out (FillReasons). docs/theory/quality.md, section
/// "Mismatches".
[[nodiscard]] std::vector<Mismatch> FindMismatches(const AdjustmentProblem& problem,
                                                   const AdjustOptions& options,
                                                   const AdjustResult& result);

/// Refuses a result with unchecked points; warns of mismatches that are checked everywhere, and of
/// the number of scattered blunders to be expected in looks that nothing checks.
void ReportMismatches(const AdjustmentProblem& problem,
                      const AdjustOptions& options,
                      AdjustResult* result);

}  // namespace sarblock
