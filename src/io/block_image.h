// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <string>

#include "tables/toml.h"

namespace sarblock {

/// Standard deviations that a pass gives in pixels; NaN where it gives none.
struct PixelSigma {
  double line_px = kNotGiven;
  double pixel_px = kNotGiven;
};

/// Reads the table `[pass.image]` (docs/formats.md).
[[nodiscard]] ImageGrid ReadImageTable(const TomlTable& table, PixelSigma* sigma);

/// The same as TOML text, to stand behind the keys of its `[[pass]]`.
[[nodiscard]] std::string ImageTableText(const ImageGrid& grid);

}  // namespace sarblock
