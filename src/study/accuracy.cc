// SPDX-License-Identifier: Apache-2.0
#include "accuracy.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sarblock {

std::vector<std::uint32_t> PointsCounted(const Block& block, const PointResults& points) {
  std::vector<std::uint32_t> counted;
  for (std::size_t i = 0; i < points.status.size(); ++i) {
    if (IsSolved(points.status[i]) && block.points.role[i] != PointRole::kControl) {
      counted.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return counted;
}

double MedianOf(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const std::size_t middle = values.size() / 2;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(middle);
  std::nth_element(values.begin(), at, values.end());
  if (values.size() % 2 == 1) return *at;
  return 0.5 * (*at + *std::max_element(values.begin(), at));
}

Accuracy SummariseAccuracy(const std::vector<SymmetricEnu>& points_m2,
                           const std::vector<SymmetricEnu>& differences_m2,
                           const std::vector<double>& distances_m) {
  Accuracy out;
  const auto sigmas = [](const std::vector<SymmetricEnu>& covariances_m2, std::size_t axis) {
    std::vector<double> values;
    for (const SymmetricEnu& q : covariances_m2) values.push_back(std::sqrt(q[axis]));
    return values;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.median_sigma_m[axis] = MedianOf(sigmas(points_m2, axis));
    double sum = 0.0;
    for (const SymmetricEnu& q : points_m2) sum += q[axis];
    out.rms_sigma_m[axis] = std::sqrt(sum / static_cast<double>(points_m2.size()));
    out.median_difference_sigma_m[axis] = MedianOf(sigmas(differences_m2, axis));
  }
  std::vector<double> horizontal_m;
  for (const SymmetricEnu& q : points_m2) {
    horizontal_m.push_back(std::sqrt(q[0] + q[1]));
    out.max_sigma_h_m = std::max(out.max_sigma_h_m, horizontal_m.back());
    out.max_sigma_u_m = std::max(out.max_sigma_u_m, std::sqrt(q[2]));
  }
  out.median_sigma_h_m = MedianOf(std::move(horizontal_m));
  out.median_distance_m = MedianOf(distances_m);
  return out;
}

}  // namespace sarblock
