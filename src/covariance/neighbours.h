// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <cstddef>

#include "model/problem.h"

namespace sarblock {

/// Each solved point with its nearest solved neighbour, each pair once, ascending.
[[nodiscard]] PointPairs NeighbourPairs(const AdjustmentProblem& problem, const BlockState& state);

/// All pairs of solved points; throws InputError above `most` pairs.
[[nodiscard]] PointPairs AllPairs(const AdjustmentProblem& problem, std::size_t most = 2000000);

}  // namespace sarblock
