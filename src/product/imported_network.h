// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "product/matched_points.h"
#include "product/pixel_offset.h"

namespace sarblock {

/// Which ground range polynomial holds at a time between two that are given.
enum class RangePolynomialTimes : std::uint8_t {
  kGiven,    ///< linear between their own times, as ISIS reads them
  kUsgscsm,  ///< Lagrange's of up to eight at even times that USGSCSM gives them: N polynomials
             ///< divide the span of their times by N, not by N - 1
};

enum class MissingImages : std::uint8_t { kRefuse, kLeaveOut };

/// Which image a serial number of the network means.
struct SerialOfImage {
  std::string serial;
  std::size_t image = 0;  ///< index into the images
};

struct NetworkImportOptions {
  std::string name = "import";         ///< of the block
  std::vector<std::string> pass_ids;   ///< one an image; empty: the files' names without endings
  std::vector<SerialOfImage> serials;  ///< go before what files say
  /// Line and sample of the centre of the first pixel in the network's numbers: 1 of ISIS, 0.5 of
  /// CSM.
  std::array<double, 2> pixel_origin_px{1.0, 1.0};
  RangePolynomialTimes range_polynomial = RangePolynomialTimes::kGiven;
  std::optional<double> range_sigma_m;    ///< of measures to which the network gives none
  std::optional<double> azimuth_sigma_m;  ///< of measures to which the network gives none
  bool jigsaw_sigma = false;              ///< RadarImage::jigsaw for all measures instead
  std::optional<double> control_sigma_m;  ///< each axis, of constrained points without covariance
  double fixed_sigma_m = 1e-3;            ///< each axis, of fixed points: as good as held
  std::optional<double> height_sigma_m;   ///< free points with a position are held in height
  MissingImages missing = MissingImages::kRefuse;
  std::optional<MatchedPoints> points;  ///< more looks, beside those of the network
};

/// What became of one image.
struct ImportedImage {
  std::string file, pass, serial;
  std::size_t looks = 0, rejected = 0;
  PixelOffset offset{};  ///< of the network's measures
};

struct ImportedNetwork {
  Block block;
  std::vector<ImportedImage> images;  ///< one a pass
  std::size_t fixed_points = 0;
  std::size_t matches = 0;  ///< looks of NetworkImportOptions::points
  std::vector<std::string> warnings;
};

}  // namespace sarblock
