// SPDX-License-Identifier: Apache-2.0
#include "support/share_sums.h"

#include <cmath>

#include "quality/assess.h"

namespace sarblock::test {

ShareSums SumShares(const Block& block, const AdjustResult& result) {
  ShareSums out;
  for (const PassShare& share : SharesOf(block, result)) {
    out.redundancy += share.redundancy + share.prior_redundancy;
    out.square_sum += share.square_sum + share.prior_square_sum;
  }
  for (const ControlQuality& control : result.control_quality) {
    out.redundancy += control.redundancy;
    if (std::isnan(control.w)) continue;
    out.square_sum += control.w * control.w * control.redundancy;
  }
  return out;
}

}  // namespace sarblock::test
