// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "grid_fit.h"
#include "product/sicd.h"

namespace sarblock {

/// A place that the metadata of a SICD image give both in the image and on the ground.
struct SicdPoint {
  std::string name;
  GridPoint point;  ///< times from `start_s`, that of CollectStart
};

/// The scene centre, "SCP". Throws InputError where the image gives it no look.
[[nodiscard]] SicdPoint CentreOfSicd(const SicdImage& image, double start_s);

/// The corners of this file's pixels, "FRFC", "FRLC", "LRLC" and "LRFC" (first or last row, first
/// or last column), at the height of the scene centre. Throws InputError where the file does not
/// place all four, or a corner has no look.
[[nodiscard]] std::vector<SicdPoint> CornersOfSicd(const SicdImage& image, double start_s);

}  // namespace sarblock
