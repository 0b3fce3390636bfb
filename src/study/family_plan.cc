// SPDX-License-Identifier: Apache-2.0
#include "family_plan.h"

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"

#include "stability_corrections.h"
#include "stability_geometry.h"
#include "stability_recordings.h"
#include "stability_weights.h"

namespace sarblock {

std::vector<const PlannedFamily*> PlannedFamilies() {
  std::vector<const PlannedFamily*> out;
  for (const std::vector<PlannedFamily>* part :
       {&GeometryFamilies(), &WeightFamilies(), &CorrectionFamilies(), &RecordingFamilies()}) {
    for (const PlannedFamily& family : *part) out.push_back(&family);
  }
  return out;
}

StabilityPlan PlanOf(const std::string& name, double value) {
  std::vector<std::string> names;
  const PlannedFamily* found = nullptr;
  for (const PlannedFamily* family : PlannedFamilies()) {
    names.emplace_back(family->name);
    if (name == family->name) found = family;
  }
  if (found == nullptr) {
    throw InputError("family",
                     "'" + name + "' does not exist" + DidYouMean(NearestName(name, names)));
  }
  return found->plan(value);
}

}  // namespace sarblock
