// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "accuracy.h"
#include "charts.h"

namespace sarblock {

/// Meridians and parallels of round degrees across a box of the map plane [m], three to eight of
/// each, named "45.5° N"; places in metres. Drawn at the height of the plane's origin. None in a
/// local frame.
[[nodiscard]] std::vector<MapChart::Line> GraticuleOf(const Frame& frame,
                                                      const MapPlane& plane,
                                                      const std::array<double, 2>& low_m,
                                                      const std::array<double, 2>& high_m);

}  // namespace sarblock
