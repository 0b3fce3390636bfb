// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "planned_family.h"

namespace sarblock {

/// Families of flights as they are recorded: noise, spacing and contradictions of the states, and
/// how far a flight wanders from a straight line.
[[nodiscard]] const std::vector<PlannedFamily>& RecordingFamilies();

}  // namespace sarblock
