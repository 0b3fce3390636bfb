// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/resource_needs.h"
#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"

#include <string>
#include <vector>

namespace sarblock {

/// What an adjustment would say of a block before it forms an equation.
struct BlockCheck {
  int corrections = 0;                ///< parameters of the corrections given
  std::vector<std::string> findings;  ///< what it will suffer from, and what would mend that
  ResourceNeeds needs;                ///< of an adjustment with the corrections given
};

/// Examines the make of a block and, on its start values, the points that its looks leave open.
/// Throws InputError for options that do not fit the block, UndeterminedError, Interrupted.
[[nodiscard]] BlockCheck CheckBlock(const Block& block,
                                    const AdjustOptions& options,
                                    ProgressSink* progress = nullptr);

}  // namespace sarblock
