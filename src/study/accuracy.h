// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "study/block_covariance.h"

namespace sarblock {

/// Points that a densification study speaks of: solved and not control.
[[nodiscard]] std::vector<std::uint32_t> PointsCounted(const Block& block,
                                                       const PointResults& points);

/// Accuracy of a block in a few numbers [m]; axes east, north, up.
struct Accuracy {
  std::array<double, 3> median_sigma_m{};
  std::array<double, 3> rms_sigma_m{};
  double median_sigma_h_m = 0.0;
  double max_sigma_h_m = 0.0;
  double max_sigma_u_m = 0.0;
  double median_distance_m = 0.0;  ///< of neighbours; NaN without any
  std::array<double, 3> median_difference_sigma_m{};
};

/// Covariances of points and of differences of neighbours, with the distances of those.
[[nodiscard]] Accuracy SummariseAccuracy(const std::vector<SymmetricEnu>& points_m2,
                                         const std::vector<SymmetricEnu>& differences_m2,
                                         const std::vector<double>& distances_m);

[[nodiscard]] double MedianOf(std::vector<double> values);  ///< NaN of none

}  // namespace sarblock
