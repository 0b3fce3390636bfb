// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "product/pixel_offset.h"
#include <Eigen/Core>

namespace sarblock {

/// Where a place lies in the image of a pass, by its path as given; nothing where its path does
/// not see it at zero Doppler.
[[nodiscard]] std::optional<ImageCoordinates> PlaceInImage(const Pass& pass,
                                                           const Eigen::Vector3d& p_m);

/// Collects offsets by pass.
class OffsetCollector {
 public:
  /// A look of a point whose given position is `p_m`; left out where one of both is outside.
  void Add(std::size_t index,
           const Pass& pass,
           const RadarCoordinates& measured,
           const Eigen::Vector3d& p_m);
  /// The same of lines and samples.
  void Add(std::size_t index,
           const ImageCoordinates& measured_px,
           const ImageCoordinates& given_px);
  /// One a pass.
  [[nodiscard]] std::vector<PixelOffset> Offsets(std::size_t passes) const;

 private:
  std::vector<std::vector<double>> lines_px_, samples_px_;
};

/// Names offsets that are half a pixel or one line, within 0.15 pixels and three standard
/// deviations of the median: mistakes of the origin of pixels or of start times. One sentence for
/// all passes with the same one; `measured_by` is what the lines and samples stand in and `option`
/// what sets their origin.
[[nodiscard]] std::vector<std::string> NameOffsets(const Block& block,
                                                   const std::vector<PixelOffset>& offsets,
                                                   const std::array<double, 2>& pixel_origin_px,
                                                   const std::string& measured_by,
                                                   const std::string& option);

}  // namespace sarblock
