// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/files/result.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include "exchange/export_options.h"

namespace sarblock {

/// What the writers of the single formats share.
struct ExportView {
  const ResultFile& result;
  const ExportOptions& options;
  double ellipse_scale_1 = 1.0;
  std::vector<std::uint32_t> points;  ///< solved ones, in their order

  [[nodiscard]] bool HasCovariance(std::uint32_t point) const;
  [[nodiscard]] const Eigen::Vector3d& Position_m(std::uint32_t point) const {
    return result.points.results.position_m[point];
  }
  [[nodiscard]] const SymmetricEnu& Covariance_m2(std::uint32_t point) const {
    return result.points.results.covariance_m2[point];
  }
};

inline bool ExportView::HasCovariance(std::uint32_t point) const {
  return !result.points.results.covariance_m2.empty() &&
         !std::isnan(result.points.results.covariance_m2[point][0]);
}

}  // namespace sarblock
