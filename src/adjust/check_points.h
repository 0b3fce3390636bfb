// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/result.h"
#include "sarblock/block/block.h"

namespace sarblock {

/// Errors of check points against their known positions.
void FillChecks(const Block& block, AdjustResult* result);

}  // namespace sarblock
