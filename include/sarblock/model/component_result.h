// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/statistics.h"

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace sarblock {

/// A standard deviation whose unit stands beside it: metres, or seconds of azimuth time.
using SigmaInUnit = double;

/// One estimated variance: that of the ranges or of the azimuths of a group of passes
/// (docs/theory/variance_components.md).
struct VarianceComponent {
  std::string group;  ///< "all", or the passes: "A1", "A1+A2"
  std::vector<std::size_t> passes;
  int component = 0;  ///< 0 range, 1 azimuth
  std::size_t looks = 0;
  double redundancy_1 = 0.0;  ///< sum of the redundancy numbers, under the weights reached
  double factor_1 = 1.0;      ///< variance after over variance before
  /// Standard deviation of factor_1; NaN where it was held.
  double factor_deviation_1 = std::numeric_limits<double>::quiet_NaN();
  /// Root mean square of the looks' standard deviations before, in `unit`; NaN where units mix.
  SigmaInUnit sigma_before = std::numeric_limits<double>::quiet_NaN();
  std::string unit;        ///< "m" or "s"
  bool estimated = false;  ///< else held at factor 1, `note` says why
  std::string note;

  [[nodiscard]] double sigma_after() const;
  /// Standard deviation of sigma_after(), to first order half that of the variance.
  [[nodiscard]] double sigma_deviation() const;
};

/// A global test as it was.
struct GlobalTest {
  double sigma0_squared = std::numeric_limits<double>::quiet_NaN();
  double redundancy_1 = 0.0;
  Interval chi_square;
  bool passed = false;
};

/// What the estimation of variance components did.
struct VarianceComponentReport {
  std::vector<VarianceComponent> components;
  GlobalTest before;  ///< with the standard deviations given
  int iterations = 0;
  bool converged = false;
};

/// What estimated components multiply standard deviations by: by pass of `passes`, range and
/// azimuth; 1 for passes in no component.
[[nodiscard]] std::vector<std::array<double, 2>> SigmaFactors(
    const std::vector<VarianceComponent>& components, std::size_t passes);

}  // namespace sarblock
