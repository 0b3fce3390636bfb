// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <cstddef>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// Fills result->looks.reason from the problem, the looks dropped by a robust loss and the report.
void FillReasons(const AdjustmentProblem& problem,
                 const std::vector<std::size_t>& dropped,
                 AdjustResult* result);

}  // namespace sarblock
