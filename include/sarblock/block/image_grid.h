// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace sarblock {

/// How the columns of an image count: slant range, or range along a reference surface (Leberl
/// (1979): slant and ground presentation; docs/theory/image_coordinates.md).
enum class Presentation { kSlant, kGround };

/// Slant range R as a polynomial of ground range g [m], valid at a time:
///
///     R(g) = sum_k c_k (g - g0)^k
struct GroundRangePolynomial {
  double time_s = 0.0;               ///< azimuth time it belongs to; of one alone it says nothing
  double origin_m = 0.0;             ///< g0
  std::vector<double> coefficients;  ///< c_k in m^(1-k), two or more
};

/// The raster of one image: azimuth time of a line, slant range of a pixel.
///
///     t = first_line_s + line line_interval_s                              (or by burst, below)
///     R = near_range_m + pixel range_spacing_m                             kSlant
///     R = R(g, t),  g = near_range_m + pixel range_spacing_m               kGround
///
/// Lines and pixels count from 0 and may be fractions. Between the times of two ground range
/// polynomials R is interpolated linearly in time, before the first and after the last one it is
/// that one's. docs/theory/image_coordinates.md, eq. (1)-(4).
struct ImageGrid {
  Presentation presentation = Presentation::kSlant;
  double first_line_s = 0.0;
  double line_interval_s = 0.0;
  double near_range_m = 0.0;  ///< of pixel 0: slant range, or ground range (often 0)
  double range_spacing_m = 0.0;
  std::vector<GroundRangePolynomial> ground_range;  ///< kGround: one or more, times increasing
  /// Images made of bursts that overlap in time: time of the first line of each; empty for others.
  /// Line l is line l - b lines_per_burst of burst b.
  std::vector<double> burst_start_s;
  std::size_t lines_per_burst = 0;
};

/// Throws InputError naming the key (`line_interval_s`, `ground_range[1].coefficients`, ...) of
/// what no image can have.
void CheckImageGrid(const ImageGrid& grid);

struct ImageCoordinates {
  double line_px = 0.0;
  double pixel_px = 0.0;
};
struct RadarCoordinates {
  double time_s = 0.0;
  double range_m = 0.0;
};

/// Time and range of a line and a pixel; nothing where the range is not positive or, in a ground
/// presentation, does not grow with the pixel there (the polynomial is used outside its domain).
[[nodiscard]] std::optional<RadarCoordinates> RadarFromImage(const ImageGrid& grid,
                                                             const ImageCoordinates& image);

/// The inverse, to 1e-9 pixel. A time in two bursts belongs to the one whose edge is farther
/// away; a time between bursts has no line. Nothing where RadarFromImage() would give
/// nothing or Newton's method finds no ground range.
[[nodiscard]] std::optional<ImageCoordinates> ImageFromRadar(const ImageGrid& grid,
                                                             const RadarCoordinates& radar);

/// Slant range from one pixel to the next at a place of the image [m]: turns standard deviations
/// and residuals of range into pixels and back.
[[nodiscard]] std::optional<double> SlantRangePerPixel_m(const ImageGrid& grid,
                                                         const RadarCoordinates& radar);

}  // namespace sarblock
