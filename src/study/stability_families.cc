// SPDX-License-Identifier: Apache-2.0
#include "study/stability_families.h"

#include "family_plan.h"

namespace sarblock {

std::vector<StabilityFamily> StabilityFamilies() {
  std::vector<StabilityFamily> out;
  for (const PlannedFamily* family : PlannedFamilies()) {
    out.push_back({family->name, family->parameter, family->about, family->values, family->whole});
  }
  return out;
}

}  // namespace sarblock
