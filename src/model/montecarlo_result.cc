// SPDX-License-Identifier: Apache-2.0
#include "sarblock/model/montecarlo_result.h"

#include "sarblock/core/statistics.h"

namespace sarblock {
namespace {

constexpr double kConfidence_1 = 0.99;

}  // namespace

double RunMean::lower() const {
  return mean_1 - NormalQuantile(0.5 + 0.5 * kConfidence_1) * standard_error_1;
}
double RunMean::upper() const {
  return mean_1 + NormalQuantile(0.5 + 0.5 * kConfidence_1) * standard_error_1;
}
bool RunMean::Agrees() const { return lower() <= expected_1 && expected_1 <= upper(); }

}  // namespace sarblock
