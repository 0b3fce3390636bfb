// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <vector>

namespace sarblock {

/// Stations at equal steps from start to end of every strip: kStripStations of them, where a spline
/// has more pieces up to four a piece, at most kMostStripStations. `groups` are the correction
/// groups that the result was made with. The standard deviation is that of the linear function of
/// the parameters, sqrt(g C g'), from the covariances in the result; the cone of the swath's edges
/// is that of the look in the middle of the strip.
inline constexpr std::size_t kStripStations = 13;
inline constexpr std::size_t kMostStripStations = 201;
[[nodiscard]] std::vector<StripStation> SampleStrips(const Block& block,
                                                     const std::vector<CorrectionGroup>& groups,
                                                     const AdjustResult& result);

}  // namespace sarblock
