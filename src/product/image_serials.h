// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "product/control_network.h"
#include "product/imported_network.h"
#include "product/radar_image.h"

namespace sarblock {

/// Serial numbers of a network and their images.
struct SerialMatches {
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> image_of_serial;  ///< kNone: no image
  std::vector<std::size_t> serial_of_image;  ///< kNone: no measure of the network is in it
  std::vector<std::string> warnings;
};

/// Finds the image of every serial number: as the options say, else the image's own serial number,
/// else instrument and start time of it, else the file's name (which Ames Stereo Pipeline writes as
/// serial number), else the start time at its end, within two lines. Warns of images that no
/// measure is in and of start times a line apart. Throws InputError where two images have one
/// serial number and, unless they are to be left out, where one has no image.
[[nodiscard]] SerialMatches MatchSerials(const ControlNetwork& network,
                                         const std::vector<RadarImage>& images,
                                         const NetworkImportOptions& options);

}  // namespace sarblock
