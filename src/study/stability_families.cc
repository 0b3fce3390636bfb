// SPDX-License-Identifier: Apache-2.0
#include "stability_families.h"

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"

#include <cmath>
#include <string>

namespace sarblock {

std::vector<double> Ratios(double from, double to, int count) {
  std::vector<double> out;
  for (int i = 0; i < count; ++i) {
    const double power = std::log10(from) + std::log10(to / from) * i / (count - 1);
    out.push_back(std::pow(10.0, power));
  }
  return out;
}

std::vector<double> With(double first, std::vector<double> rest) {
  rest.insert(rest.begin(), first);
  return rest;
}

void HoldControlTo(double sigma_m, StabilityPlan* plan) {
  for (PlannedControl& control : plan->control) control.sigma_enu_m.fill(sigma_m);
}

namespace {

template <typename F>
void ForEachFamily(F&& f) {
  for (const std::vector<PlannedFamily>* part :
       {&GeometryFamilies(), &WeightFamilies(), &CorrectionFamilies()}) {
    for (const PlannedFamily& family : *part) f(family);
  }
}

}  // namespace

std::vector<StabilityFamily> StabilityFamilies() {
  std::vector<StabilityFamily> out;
  ForEachFamily([&](const PlannedFamily& family) {
    out.push_back({family.name, family.parameter, family.about, family.values, family.whole});
  });
  return out;
}

StabilityPlan PlanOf(const std::string& name, double value) {
  std::vector<std::string> names;
  const PlannedFamily* found = nullptr;
  ForEachFamily([&](const PlannedFamily& family) {
    names.emplace_back(family.name);
    if (name == family.name) found = &family;
  });
  if (found == nullptr) {
    throw InputError(
        "family", "'" + name + "' does not exist; did you mean " + NearestName(name, names) + "?");
  }
  return found->plan(value);
}

}  // namespace sarblock
