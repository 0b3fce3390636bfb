// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "block_builder.h"
#include "product/sicd.h"

namespace sarblock {

/// Whether the columns are evenly spaced zero-Doppler times.
[[nodiscard]] bool HasRaster(const SicdImage& image);
/// With a raster where columns are evenly spaced zero-Doppler times, to 1e-9 s; with ImagePass's
/// `aperture` for all other images. Its id is the file's name without ending.
[[nodiscard]] ImagePass PassOfSicd(const SicdImage& image);

}  // namespace sarblock
