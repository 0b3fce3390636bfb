// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/product/imported_network.h"

#include <array>
#include <string>
#include <vector>

namespace sarblock {

/// Fills the offsets of the images of an imported block: measured lines and samples minus those
/// where the given positions of the points lie in the image, by its path as given.
void MeasureOffsets(ImportedNetwork* imported);

/// Names offsets that are half a pixel or one line, within 0.15 pixels and three standard
/// deviations of the median: mistakes of the origin of pixels or of start times. One sentence for
/// all images with the same one.
[[nodiscard]] std::vector<std::string> NameOffsets(const ImportedNetwork& imported,
                                                   const std::array<double, 2>& pixel_origin_px);

}  // namespace sarblock
