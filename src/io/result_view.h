// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

namespace sarblock {

/// What the writers of the single files of a result share.
struct ResultView {
  const Block& block;
  const AdjustOptions& options;
  const AdjustResult& result;
  double factor = 1.0;  ///< on covariances
};

}  // namespace sarblock
