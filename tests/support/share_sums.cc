// SPDX-License-Identifier: Apache-2.0
#include "support/share_sums.h"

#include <cmath>

#include "quality/assess.h"

namespace sarblock::test {

ShareSums SumShares(const Block& block, const AdjustResult& result) {
  ShareSums out;
  for (const PassShare& share : SharesOf(block, result)) {
    out.redundancy_1 += share.redundancy_1 + share.prior_redundancy_1;
    out.square_sum_1 += share.square_sum_1 + share.prior_square_sum_1;
  }
  for (const ControlQuality& control : result.control_quality) {
    out.redundancy_1 += control.redundancy_1;
    if (std::isnan(control.w_1)) continue;
    out.square_sum_1 += control.w_1 * control.w_1 * control.redundancy_1;
  }
  return out;
}

}  // namespace sarblock::test
