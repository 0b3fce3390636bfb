// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"

#include <cmath>
#include <numbers>

#include "quality/covariance.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

// Hand: axes 3 and 2 m, the longer one 30 degrees clockwise from north (rotate diag(4, 9)).
TEST(EllipseOfTest, TurnsTheMajorAxisToWhereTheErrorsAre) {
  const double s = 0.5, c = std::sqrt(0.75);
  const double ee = 9 * s * s + 4 * c * c, nn = 9 * c * c + 4 * s * s, en = (9 - 4) * s * c;
  const ErrorEllipse e = EllipseOf({ee, nn, 7.0, en, 0.3, -0.2});
  EXPECT_NEAR(e.major_m, 3.0, 1e-14);
  EXPECT_NEAR(e.minor_m, 2.0, 1e-14);
  EXPECT_NEAR(e.azimuth_rad * kDegPerRad, 30.0, 1e-12);
  EXPECT_NEAR(EllipseOf({9, 4, 1, 0, 0, 0}).azimuth_rad * kDegPerRad, 90.0, 1e-12);
  EXPECT_NEAR(EllipseOf({ee, nn, 1, -en, 0, 0}).azimuth_rad * kDegPerRad, 150.0, 1e-12);
}

// Oracle: GeographicLib's conversion of each corner, from the poles to the equator, on a flat body
// too, from a millimetre to where the closed form no longer serves.
TEST(EllipseRingTest, IsTheConversionOfEachCorner) {
  for (const char* body : {"WGS84", "Mars", "Moon"}) {
    const Frame frame = Frame::Geocentric(NamedEllipsoid(body));
    for (const double lat_deg : {-90.0, -89.999999, -45.0, -10.0, 0.0, 30.0, 70.0, 89.9999, 90.0}) {
      for (const double major_m : {1e-3, 0.3, 20.0, 150.0, 400.0, 3e3, 3e4}) {
        const Eigen::Vector3d p_m = frame.FrameFromGeodetic(
            {.lat_rad = lat_deg * kRadPerDeg, .lon_rad = 179.99999 * kRadPerDeg, .h_m = 3000.0});
        const ErrorEllipse ellipse = {
            .major_m = major_m, .minor_m = 0.4 * major_m, .azimuth_rad = 0.7};
        const auto corners = EllipseCorners(ellipse);
        const auto ring = EllipseRing(frame, p_m, ellipse);
        const Eigen::Matrix3d frame_from_enu = frame.EnuFromFrame(p_m).transpose();
        const double centre_rad = frame.GeodeticFromFrame(p_m).lon_rad;
        for (std::size_t i = 0; i < ring.size(); ++i) {
          const Eigen::Vector3d corner_m = p_m + frame_from_enu.leftCols<2>() * corners[i];
          const Eigen::Vector3d found_m =
              frame.FrameFromGeodetic({.lat_rad = ring[i].lat_rad,
                                       .lon_rad = ring[i].lon_rad,
                                       .h_m = frame.GeodeticFromFrame(corner_m).h_m});
          EXPECT_LT((found_m - corner_m).norm(), 1e-8) << body << ' ' << lat_deg << ' ' << major_m;
          EXPECT_LE(std::abs(ring[i].lon_rad - centre_rad), std::numbers::pi + 1e-12);
        }
      }
    }
  }
}

}  // namespace
}  // namespace sarblock
