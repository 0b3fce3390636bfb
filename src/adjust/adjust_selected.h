// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

namespace sarblock {

/// Adjust() with options.corrections == kAuto: the selection, then the adjustment with what it
/// chose.
[[nodiscard]] AdjustResult AdjustSelected(const Block& block,
                                          const AdjustOptions& options,
                                          const PointPairs& pairs,
                                          ProgressSink* progress);

}  // namespace sarblock
