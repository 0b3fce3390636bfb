// SPDX-License-Identifier: Apache-2.0
#include "sicd_points.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"

#include <array>

#include "sicd_pass.h"
#include "sicd_projection.h"

namespace sarblock {
namespace {

GridPoint LookAt(const SicdImage& image,
                 const ImageCoordinates& pixel,
                 const Geodetic& place,
                 double start_s,
                 const char* what) {
  GridPoint point;
  point.place = place;
  if (HasRaster(image)) {
    point.time_s = start_s + ValueOf(image.closest_time_s, image.Azimuth_m(pixel.pixel_px));
    point.range_m = image.ClosestRange_m(pixel.line_px);
    return point;
  }
  const auto look = LookOfPlace(image, pixel.line_px, pixel.pixel_px);
  if (!look) {
    throw InputError(
        image.PlaceOf("SICD.Grid"),
        std::string("gives ") + what + " no range above 0 with a rate below the speed");
  }
  point.time_s = start_s + look->time_s;
  point.range_m = look->range_m;
  point.cone = {Cone::Kind::kDoppler, 0.0, -look->range_rate_mps};
  return point;
}

}  // namespace

SicdPoint CentreOfSicd(const SicdImage& image, double start_s) {
  const Frame earth = Frame::Geocentric(NamedEllipsoid("WGS84"));
  return {"SCP",
          LookAt(image,
                 {image.centre_row_px - image.first_row_px,
                  image.centre_column_px - image.first_column_px},
                 earth.GeodeticFromFrame(image.centre_m),
                 start_s,
                 "the scene centre")};
}

std::vector<SicdPoint> CornersOfSicd(const SicdImage& image, double start_s) {
  if (!image.corners) {
    throw InputError(image.PlaceOf("SICD.GeoData.ImageCorners"),
                     "does not place the four corners (ICP, 1:FRFC to 4:LRFC)");
  }
  const double last_row = static_cast<double>(image.rows - 1);
  const double last_column = static_cast<double>(image.columns - 1);
  const std::array<const char*, 4> names{"FRFC", "FRLC", "LRLC", "LRFC"};
  const std::array<ImageCoordinates, 4> pixels{
      {{0.0, 0.0}, {0.0, last_column}, {last_row, last_column}, {last_row, 0.0}}};
  std::vector<SicdPoint> points;
  for (std::size_t k = 0; k < names.size(); ++k) {
    points.push_back(
        {names[k], LookAt(image, pixels[k], (*image.corners)[k], start_s, "a corner")});
  }
  return points;
}

}  // namespace sarblock
