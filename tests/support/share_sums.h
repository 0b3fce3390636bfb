// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

namespace sarblock::test {

/// Redundancy and v'Pv of a block, added up from the shares of its passes and its control.
struct ShareSums {
  double redundancy = 0.0;
  double square_sum = 0.0;
};
[[nodiscard]] ShareSums SumShares(const Block& block, const AdjustResult& result);

}  // namespace sarblock::test
