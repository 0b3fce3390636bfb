// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "block_builder.h"
#include "image.h"

namespace sarblock {

/// Rational polynomials of an image (RPC00B, NGA STDI-0002, appendix E): with latitude, longitude
/// and height above the ellipsoid, each less its offset over its scale,
///
///     line = line_offset + line_scale P_1/P_2,  sample = sample_offset + sample_scale P_3/P_4
///
/// and P_i polynomials of degree 3. Lines and samples count from 0.
struct RationalPolynomials {
  std::array<double, 5> offset{};  ///< line, sample [px], latitude, longitude [deg], height [m]
  std::array<double, 5> scale{};
  std::array<std::array<double, 20>, 4> coefficients{};  ///< P_1 to P_4

  [[nodiscard]] ImageCoordinates At(const Geodetic& place) const;
};

/// A corner of an image, or its centre.
struct IceyePlace {
  const char* name = "";  ///< of its element
  int line = 0, sample = 0;
  double lat_rad = 0.0, lon_rad = 0.0;
  std::size_t file_line = 0;
};

/// Geometry in the metadata (XML) of an ICEYE image in ground range (GRD). Names and meanings:
/// ICEYE SAR product guide, metadata of version 2.
struct IceyeProduct : ZeroDopplerImage {
  std::string satellite;        ///< ICEYE-X7
  std::string orbit_level;      ///< precise, predicted, ...
  double scene_height_m = 0.0;  ///< average
  /// Delay of the troposphere that the processor subtracted from the ranges; 0: none.
  double troposphere_m = 0.0;
  std::vector<IceyePlace> places;  ///< four corners and the centre
  std::optional<RationalPolynomials> rpc;
};

/// Reads the metadata. What it lacks or what makes no sense throws InputError with file, line and
/// element; other products than GRD too, and images whose first pixel is not early and near.
[[nodiscard]] IceyeProduct ParseIceye(std::string_view text, const std::string& file);

/// Its image as a pass; its id is such as ICEYE-X7_GRD_20211027T183203. Throws InputError where the
/// image contradicts itself: corners that its path sees more than two lines from theirs or on the
/// other side, rational polynomials that are more than a pixel from its raster. `stated` says
/// what was found.
[[nodiscard]] ImagePass PassOfIceye(const IceyeProduct& product,
                                    const ImportOptions& options,
                                    std::vector<std::string>* warnings,
                                    std::string* stated);

}  // namespace sarblock
