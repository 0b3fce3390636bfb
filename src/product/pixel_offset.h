// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstddef>

namespace sarblock {

/// Looks of one image: measured minus where the given positions of their points lie in it, median
/// over those that take part; NaN where there are none.
struct PixelOffset {
  std::size_t looks = 0;
  double line_px = kNotGiven;
  double sample_px = kNotGiven;
  double line_sigma_px = kNotGiven;  ///< standard deviation of the median
  double sample_sigma_px = kNotGiven;
};

}  // namespace sarblock
