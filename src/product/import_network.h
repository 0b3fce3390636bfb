// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "product/control_network.h"
#include "product/imported_network.h"
#include "product/radar_image.h"

namespace sarblock {

/// Makes one block of a control network and its images, one pass an image that is measured in:
/// geocentric frame of the images' ellipsoid, paths body-fixed, times counted from the whole UTC
/// second before the first line. Free points become tie points, constrained and fixed ones control
/// with the covariance that the network gives them; measures ignored or rejected, and those of such
/// points, become rejected looks. docs/import_isis.md.
///
/// Throws InputError for options that make no sense, serial numbers without an image (unless they
/// are to be left out), images of another body than the network's or each other's, constrained
/// points without position or covariance, measures without standard deviations and measures outside
/// their image's path. What is likely a mistake but not certain is a warning: images without
/// measures, a network and an image whose start times are a line apart, offsets of half a pixel or
/// of a line.
[[nodiscard]] ImportedNetwork ImportNetwork(const ControlNetwork& network,
                                            const std::vector<RadarImage>& images,
                                            const NetworkImportOptions& options);

}  // namespace sarblock
