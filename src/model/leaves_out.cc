// SPDX-License-Identifier: Apache-2.0
#include "sarblock/model/leaves_out.h"

namespace sarblock {

bool LeavesOut(const BlunderFinding& finding) {
  return finding.action == BlunderFinding::Action::kRejected ||
         finding.action == BlunderFinding::Action::kPointLeftOut ||
         finding.action == BlunderFinding::Action::kControlReleased;
}

}  // namespace sarblock
