// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sarblock {

/// What the tests of a result make of an error in one observation; NaN where there is no test.
struct BlunderSize {
  double sigma_m = kNotGiven;       ///< standard deviation that the observation was weighted with
  double detectable_m = kNotGiven;  ///< minimal detectable blunder, delta0 sigma / sqrt(r)
  double influence_m = kNotGiven;   ///< how far one of that size moves the point
};

/// Minimal detectable blunders of a result and their influence (docs/theory/quality.md), with the
/// standard deviations that the result was made with: those of the block, times the square roots of
/// the variance components where they were estimated. `factor_1` multiplies all variances (the
/// posterior variance factor where covariances are scaled by it).
class BlunderSizes {
 public:
  BlunderSizes(const Block& block,
               const AdjustOptions& options,
               const AdjustResult& result,
               double factor_1);
  /// Range and azimuth of a look of `point`. The result has quality figures.
  [[nodiscard]] std::array<BlunderSize, 2> OfLook(std::uint64_t look, std::size_t point) const;
  [[nodiscard]] BlunderSize OfControl(const ControlQuality& control) const;

 private:
  const Block& block_;
  const AdjustResult& result_;
  double delta0_1_;
  double scale_1_;                                     // on standard deviations
  std::vector<std::array<double, 2>> sigma_factor_1_;  // by pass, range and azimuth
};

}  // namespace sarblock
