// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <functional>
#include <optional>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// Rounds after which the search ends, far more than a block that is fit to be adjusted needs.
inline constexpr int kMostSearchRounds = 200;

/// A solution that leaves out more than this part of the looks as blunders, outliers or misplaced
/// has not found blunders: a cause that many looks share is wrong, and what is left fits because
/// the rest is gone.
inline constexpr double kMostLeftOut_1 = 0.25;

/// Solves `problem` from `state` under a loss, with the looks now in use; updates both.
using SolveAgain = std::function<void(RobustLoss)>;

/// The search for blunders (data snooping, Baarda 1968), from a solved state;
/// docs/theory/quality.md.
///
/// Each round tests every observation of the solution. Above the critical value the largest |w| of
/// a point is a candidate; which observations of its point might hold the error instead is decided
/// by the correlation of the tests (suspects.h).
///
/// A look alone is a located blunder; it is rejected. Several looks are suspects of which nothing
/// is claimed: all of them are left out if the rest still determines the point, else the whole
/// point is. A known position among the suspects is left out with them, but never so that fewer
/// than three control points remain. Nothing leaves where the passes would fall into more islands,
/// a pass would lose its last look or the corrections would no longer be determined: it is
/// reported. Several candidates go in one round, in the order of |w|, where even the largest
/// correlation that the corrections allow between two points could not explain the one by the
/// other. Then the block is solved again from where it is. At the end looks left out whose
/// residuals turned out small are taken back, once each. `found` are findings made before, whose
/// looks and points are left out already: they are taken back likewise. A known position is left
/// out only where a search was asked for.
///
/// Leaves `problem` and `state` at the solution without the blunders. A search that has left out
/// more than kMostLeftOut_1 of the looks it began with has not found blunders: it gives way, leaves
/// `problem` and `state` as they were and returns nothing.
[[nodiscard]] std::optional<SnoopingReport> SearchBlunders(const AdjustOptions& options,
                                                           const SolveAgain& solve,
                                                           AdjustmentProblem* problem,
                                                           BlockState* state,
                                                           ProgressSink* progress,
                                                           std::vector<BlunderFinding> found = {});

}  // namespace sarblock
