// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include "model/problem.h"

namespace sarblock {

/// Compares the looks that a search, a loss or a consensus left out, by pass. A matcher that takes
/// one repeated pattern for the next puts many looks of a pass off by the same distance: at points
/// with enough other looks this shows; at other points, equally wrong looks were kept. A pass is
/// reported if its lost looks have residuals of one size (Student's t of their mean, chance below
/// 1e-4 over all passes and both components), or if it lost more than the other passes
/// (PassThatLosesMore, at that chance). The result is refused where points keep a look of that pass
/// that would hardly show the same error; otherwise there is a warning. Warns also of the number of
/// scattered blunders to be expected in looks that nothing checks.
///
/// Needs the residuals of a result and the reasons why looks were left out (FillReasons).
/// docs/theory/quality.md, section "Mismatches".
void ReportMismatches(const AdjustmentProblem& problem,
                      const AdjustOptions& options,
                      AdjustResult* result);

}  // namespace sarblock
