// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "planned_family.h"

namespace sarblock {

/// Families that push the corrections of a block.
[[nodiscard]] const std::vector<PlannedFamily>& CorrectionFamilies();

}  // namespace sarblock
