// SPDX-License-Identifier: Apache-2.0
#include "sarblock/model/component_result.h"

#include <cmath>

namespace sarblock {

double VarianceComponent::sigma_after() const { return std::sqrt(factor_1) * sigma_before; }

double VarianceComponent::sigma_deviation() const {
  return 0.5 * sigma_after() * factor_deviation_1 / factor_1;
}

std::vector<std::array<double, 2>> SigmaFactors(const std::vector<VarianceComponent>& components,
                                                std::size_t passes) {
  std::vector<std::array<double, 2>> factor(passes, {1.0, 1.0});
  for (const VarianceComponent& component : components) {
    for (const std::size_t pass : component.passes) {
      factor[pass][static_cast<std::size_t>(component.component)] = std::sqrt(component.factor_1);
    }
  }
  return factor;
}

}  // namespace sarblock
