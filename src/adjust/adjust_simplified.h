// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

namespace sarblock {

/// Adjusts a block with `options.groups` and a simplified model and examines it: where a point
/// would move by more than the limit, or a bound of what was taken is above it at the solution, the
/// block is adjusted again with the full model. `report` holds what ChooseSimplified() said and
/// gets the outcome.
[[nodiscard]] AdjustResult AdjustSimplified(const Block& block,
                                            const AdjustOptions& options,
                                            const Simplified& simplified,
                                            const PointPairs& pairs,
                                            SelectionReport* report,
                                            ProgressSink* progress = nullptr);

}  // namespace sarblock
