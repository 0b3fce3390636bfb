// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include "model/problem.h"
#include "normals/reduced_system.h"

namespace sarblock {

/// Of an adjustment of the problem with these options; `system` is its reduced normals, which are
/// analysed and not formed.
[[nodiscard]] ResourceNeeds PredictNeeds(const AdjustmentProblem& problem,
                                         const AdjustOptions& options,
                                         ReducedSystem* system);

/// Why an adjustment that needs so much is refused, and what would help; empty where it fits
/// AdjustOptions::memory_mib, or what this computer has left for the process.
[[nodiscard]] std::string ProblemOfMemory(const ResourceNeeds& needs, const AdjustOptions& options);

}  // namespace sarblock
