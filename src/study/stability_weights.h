// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "planned_family.h"

namespace sarblock {

/// Families that push the weights of a block.
[[nodiscard]] const std::vector<PlannedFamily>& WeightFamilies();

}  // namespace sarblock
