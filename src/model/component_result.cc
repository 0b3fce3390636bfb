// SPDX-License-Identifier: Apache-2.0
#include "sarblock/model/component_result.h"

#include <cmath>

namespace sarblock {

double VarianceComponent::sigma_after() const { return std::sqrt(factor_1) * sigma_before; }

double VarianceComponent::sigma_deviation() const {
  return 0.5 * sigma_after() * factor_deviation_1 / factor_1;
}

}  // namespace sarblock
