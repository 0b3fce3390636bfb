// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

namespace sarblock {

/// Errors of check points against their known positions.
void FillChecks(const Block& block, const AdjustOptions& options, AdjustResult* result);

}  // namespace sarblock
