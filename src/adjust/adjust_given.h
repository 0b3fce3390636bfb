// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <functional>

#include "model/problem.h"

namespace sarblock {

/// The last step of adjustment, prediction and intersection: fills `strips`.
void DescribePaths(const Block& block, const AdjustOptions& options, AdjustResult* result);

/// What a caller wants of the problem and its state at the solution, before they go.
using AtSolution = std::function<void(const AdjustmentProblem&, const BlockState&, AdjustResult*)>;
/// Adjust() of corrections that are given or none; `at_solution` may be empty.
[[nodiscard]] AdjustResult AdjustGiven(const Block& block,
                                       const AdjustOptions& options,
                                       const Simplified& simplified,
                                       const PointPairs& pairs,
                                       const AtSolution& at_solution,
                                       ProgressSink* progress);

}  // namespace sarblock
