// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "planned_family.h"

namespace sarblock {

/// All families, in the order they are run.
[[nodiscard]] std::vector<const PlannedFamily*> PlannedFamilies();

/// The block of a step of a family; throws InputError for a family that does not exist.
[[nodiscard]] StabilityPlan PlanOf(const std::string& family, double value);

}  // namespace sarblock
