// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "block_builder.h"
#include "product/import_options.h"
#include "product/imported_network.h"
#include "product/nisar.h"
#include "product/radar_image.h"
#include "product/sentinel1.h"

namespace sarblock {

/// The image of a product as a pass, its id made of the product's own names. An annotation of
/// Sentinel-1 does not tell the look side: its grid does.
[[nodiscard]] ImagePass PassOfSentinel1(const Sentinel1Product& product,
                                        const std::vector<OrbitFile>& orbits,
                                        const ImportOptions& options,
                                        std::vector<std::string>* warnings);
[[nodiscard]] ImagePass PassOfNisar(const NisarProduct& product,
                                    const ImportOptions& options,
                                    std::vector<std::string>* warnings);
/// Of a cube or an ISD; its id is the file's name without ending.
[[nodiscard]] ImagePass PassOfRadarImage(const RadarImage& image,
                                         RangePolynomialTimes range_polynomial);

}  // namespace sarblock
