// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <functional>
#include <string>

#include "model/problem.h"
#include "normals/reduced_system.h"

namespace sarblock {

/// The last step of adjustment, prediction and intersection: fills `strips`.
void DescribePaths(const Block& block, const AdjustOptions& options, AdjustResult* result);

/// Called with the problem and its state at the solution, before they are destroyed.
using AtSolution = std::function<void(const AdjustmentProblem&, const BlockState&, AdjustResult*)>;
/// Adjust() of corrections that are given or none; `at_solution` may be empty.
[[nodiscard]] AdjustResult AdjustGiven(const Block& block,
                                       const AdjustOptions& options,
                                       const Simplified& simplified,
                                       const PointPairs& pairs,
                                       const AtSolution& at_solution,
                                       ProgressSink* progress);

/// Needs of an adjustment of the problem with these options; its reduced normals `system` are
/// analysed but not formed.
[[nodiscard]] ResourceNeeds PredictNeeds(const AdjustmentProblem& problem,
                                         const AdjustOptions& options,
                                         ReducedSystem* system);

/// Why an adjustment that needs so much is refused, and what would help; empty where it fits
/// AdjustOptions::memory_mib, or what this computer has left for the process.
[[nodiscard]] std::string ProblemOfMemory(const ResourceNeeds& needs, const AdjustOptions& options);

}  // namespace sarblock
