// SPDX-License-Identifier: Apache-2.0
#include "export_view.h"

#include <cmath>

namespace sarblock {

bool ExportView::HasCovariance(std::uint32_t point) const {
  return !result.points.results.covariance_m2.empty() &&
         !std::isnan(result.points.results.covariance_m2[point][0]);
}

}  // namespace sarblock
