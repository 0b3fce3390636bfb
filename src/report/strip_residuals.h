// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accuracy.h"
#include "page.h"

namespace sarblock {

/// The time at which a pass looked at a place: where the line from the nearest to the farthest
/// ground of a station (strips.csv; without it the plane across the track) passes over the place,
/// linear between stations. NaN more than one station's distance before or after the strip. Good
/// to a small part of the strip, which is enough for a chart.
[[nodiscard]] double StripTimeOf_s(std::span<const StripStation> strip,
                                   const MapPlane& plane,
                                   const std::array<double, 2>& place_m);

/// Residuals of the looks in use of one pass against the time along its strip.
struct StripResiduals {
  std::uint32_t pass = 0;
  std::vector<std::size_t> looks;  ///< rows of ResultLooks, by time
  std::vector<double> time_s;
  std::array<std::vector<double>, 2> residual_m;  ///< range, azimuth
  /// Largest |correlation with time| sqrt(n) of the two: about a normal deviate without a trend.
  [[nodiscard]] double Trend_1() const;
};
[[nodiscard]] std::vector<StripResiduals> ResidualsAlongStrips(const ResultFolder& result);

/// A chart a pass, or a sentence in place of what the result does not have.
[[nodiscard]] std::vector<PageItem> StripResidualItems(const ResultFolder& result);

}  // namespace sarblock
