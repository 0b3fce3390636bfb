// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/product/utc_time.h"

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// c_0 + c_1 x + c_2 x^2 + ...; times in seconds from SicdImage::start.
using SicdPolynomial = std::vector<double>;
[[nodiscard]] double ValueOf(const SicdPolynomial& polynomial, double x);
[[nodiscard]] SicdPolynomial DerivativeOf(const SicdPolynomial& polynomial);

/// What the metadata of a SICD image say of one in range and zero-Doppler time (RMA, INCA). Names
/// and meanings: NGA.STND.0024-1, SICD volume 1. Rows run along range, columns along azimuth.
struct SicdImage {
  std::string file;
  std::string core_name;
  LookSide side = LookSide::kRight;
  double wavelength_m = 0.0;          ///< c / FreqZero
  std::size_t rows = 0, columns = 0;  ///< of this file, which may be a part of the image
  double first_row_px = 0.0, first_column_px = 0.0;
  double centre_row_px = 0.0, centre_column_px = 0.0;  ///< SCPPixel, of the whole image
  double row_spacing_m = 0.0, column_spacing_m = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< SCP, earth-fixed
  UtcTime start;                                       ///< CollectStart
  double duration_s = 0.0;                             ///< CollectDuration
  std::array<SicdPolynomial, 3> path_m;                ///< ARPPoly, earth-fixed
  SicdPolynomial closest_time_s;  ///< TimeCAPoly, of metres in azimuth from the centre
  double closest_range_m = 0.0;   ///< R_CA_SCP

  /// Metres in azimuth of a column from the centre.
  [[nodiscard]] double Azimuth_m(double column_px) const {
    return (column_px + first_column_px - centre_column_px) * column_spacing_m;
  }
  /// Slant range of closest approach of a row.
  [[nodiscard]] double ClosestRange_m(double row_px) const {
    return closest_range_m + (row_px + first_row_px - centre_row_px) * row_spacing_m;
  }
};

/// Reads the metadata of a SICD image: a NITF file (2.1, or NSIF 1.0) with the XML in a data
/// extension segment, or the XML alone; pixels are never read. Throws InputError with file, line
/// and element for what is missing or makes no sense, for sizes that the file does not hold, for
/// bistatic images and for images that are not RMA/INCA of grid type RGZERO: of others the Doppler,
/// not the time, is what the image measures. docs/import_sicd.md.
[[nodiscard]] SicdImage ReadSicd(const std::string& file);
/// The same of bytes in memory; `file` is for messages.
[[nodiscard]] SicdImage ParseSicd(std::string_view bytes, const std::string& file);

}  // namespace sarblock
