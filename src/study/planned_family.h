// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "stability_plan.h"

namespace sarblock {

/// A family with the way from its number to a block.
struct PlannedFamily {
  const char* name;
  const char* parameter;
  const char* about;
  std::vector<double> values;
  StabilityPlan (*plan)(double value);
  bool whole = false;
};

/// `count` values from `from` to `to` with equal ratios.
[[nodiscard]] std::vector<double> Ratios(double from, double to, int count);
[[nodiscard]] std::vector<double> With(double first, std::vector<double> rest);
/// The same standard deviation for all components of all control points.
void HoldControlTo(double sigma_m, StabilityPlan* plan);

}  // namespace sarblock
