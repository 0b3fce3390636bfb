// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

namespace sarblock {

/// Something that the finding names takes no part any more.
[[nodiscard]] bool LeavesOut(const BlunderFinding& finding);

}  // namespace sarblock
