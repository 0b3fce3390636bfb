// SPDX-License-Identifier: Apache-2.0
#include "planned_family.h"

#include <cmath>

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

}  // namespace sarblock
