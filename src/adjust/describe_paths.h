// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

namespace sarblock {

/// The last step of adjustment, prediction and intersection: what a result says of the flight
/// paths. Fills `strips` and, where that has a meaning, the covariances that the points would have
/// with the paths known exactly. `measured` is `block` with the looks that a prediction filled in.
void DescribePaths(const Block& block,
                   const Block& measured,
                   const AdjustOptions& options,
                   AdjustResult* result);

}  // namespace sarblock
