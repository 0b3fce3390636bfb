// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <optional>

#include "model/problem.h"
#include "normals/reduced_system.h"

namespace sarblock {

/// Throws UndeterminedError unless something can be solved at all.
void RequireSolvable(const AdjustmentProblem& problem);

/// Forms the reduced system at a state, leaving out the points whose own equations turn out rank
/// deficient, with their reason.
void FormDetermined(const BlockState& state,
                    const Weighting& weighting,
                    AdjustmentProblem* problem,
                    std::optional<ReducedSystem>* system,
                    ProgressSink* progress);

}  // namespace sarblock
