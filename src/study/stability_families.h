// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/study/stability.h"

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

[[nodiscard]] const std::vector<PlannedFamily>& GeometryFamilies();
[[nodiscard]] const std::vector<PlannedFamily>& WeightFamilies();
[[nodiscard]] const std::vector<PlannedFamily>& CorrectionFamilies();

/// The block of a step of a family; throws InputError for a family that does not exist.
[[nodiscard]] StabilityPlan PlanOf(const std::string& family, double value);

/// `count` values from `from` to `to` with equal ratios.
[[nodiscard]] std::vector<double> Ratios(double from, double to, int count);
[[nodiscard]] std::vector<double> With(double first, std::vector<double> rest);
/// The same standard deviation for all components of all control points.
void HoldControlTo(double sigma_m, StabilityPlan* plan);

}  // namespace sarblock
