// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <vector>

#include <Eigen/Core>

namespace sarblock::test {

/// One straight pass along +x at 211 m/s in the frame of Leberl (1979), looking to +y or to -y.
struct PaperPass {
  double across_m = 0.0;  ///< y of the flight line: 0 for station ', B for station ''
  double height_m = 0.0;  ///< H
  double range_sigma_m = 1.0;
  double squint_rad = 0.0;
};

/// Looks of every pass at every point, exact for these positions; the side follows from the first
/// point. Azimuth standard deviation 1.3 m. Points are ties without coordinates, P1, P2, ...
[[nodiscard]] Block MakePaperBlock(const std::vector<PaperPass>& passes,
                                   const std::vector<Eigen::Vector3d>& points_m);

}  // namespace sarblock::test
