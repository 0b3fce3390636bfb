// SPDX-License-Identifier: Apache-2.0
#include "export_view.h"

#include <algorithm>

namespace sarblock {

bool ExportView::HasCovariance(std::uint32_t point) const {
  return !result.points.results.covariance_m2.empty() &&
         !std::isnan(result.points.results.covariance_m2[point][0]);
}

const CheckResult* FindCheck(const std::vector<CheckResult>& checks, std::uint32_t point) {
  const auto found = std::lower_bound(
      checks.begin(), checks.end(), point, [](const CheckResult& check, std::uint32_t value) {
        return check.point < value;
      });
  return found != checks.end() && found->point == point ? &*found : nullptr;
}

}  // namespace sarblock
