// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

namespace sarblock {

/// Rigorous intersection of every point, flight paths held (corrections none): position,
/// covariance R^-1 R^-T and residuals of each point alone, control not used.
[[nodiscard]] AdjustResult IntersectBlock(const Block& block,
                                          const AdjustOptions& options,
                                          ProgressSink* progress = nullptr);

}  // namespace sarblock
