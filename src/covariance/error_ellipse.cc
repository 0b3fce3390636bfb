// SPDX-License-Identifier: Apache-2.0
#include "error_ellipse.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sarblock {

ErrorEllipse EllipseOf(const SymmetricEnu& covariance_m2, double scale_1) {
  const double ee = covariance_m2[0], nn = covariance_m2[1], en = covariance_m2[3];
  const double mean = 0.5 * (ee + nn);
  const double radius = std::hypot(0.5 * (nn - ee), en);
  ErrorEllipse ellipse;
  ellipse.major_m = scale_1 * std::sqrt(mean + radius);
  ellipse.minor_m = scale_1 * std::sqrt(std::max(mean - radius, 0.0));
  ellipse.azimuth_rad = 0.5 * std::atan2(2.0 * en, nn - ee);
  if (ellipse.azimuth_rad < 0.0) ellipse.azimuth_rad += std::numbers::pi;
  return ellipse;
}

double EllipseScale(double confidence_1) {
  if (!(confidence_1 > 0.0 && confidence_1 < 1.0)) {
    throw InputError("confidence",
                     std::to_string(confidence_1) + " is not allowed, a number between 0 and 1 is");
  }
  return std::sqrt(-2.0 * std::log1p(-confidence_1));
}

std::array<Eigen::Vector2d, kEllipseCorners> EllipseCorners(const ErrorEllipse& ellipse) {
  const double sin_azimuth = std::sin(ellipse.azimuth_rad);
  const double cos_azimuth = std::cos(ellipse.azimuth_rad);
  std::array<Eigen::Vector2d, kEllipseCorners> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double angle = -2.0 * std::numbers::pi * static_cast<double>(i) / kEllipseCorners;
    const double along_m = ellipse.major_m * std::cos(angle);
    const double across_m = ellipse.minor_m * std::sin(angle);
    corners[i] = {along_m * sin_azimuth + across_m * cos_azimuth,
                  along_m * cos_azimuth - across_m * sin_azimuth};
  }
  return corners;
}

std::array<Geodetic, kEllipseCorners> EllipseRing(const Frame& frame,
                                                  const Eigen::Vector3d& p_m,
                                                  const ErrorEllipse& ellipse) {
  const Eigen::Matrix3d frame_from_enu = frame.EnuFromFrame(p_m).transpose();
  const double centre_rad = frame.GeodeticFromFrame(p_m).lon_rad;
  const auto corners = EllipseCorners(ellipse);
  std::array<Geodetic, kEllipseCorners> ring;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    ring[i] = frame.GeodeticFromFrame(p_m + frame_from_enu.leftCols<2>() * corners[i]);
    ring[i].lon_rad =
        centre_rad + std::remainder(ring[i].lon_rad - centre_rad, 2.0 * std::numbers::pi);
  }
  return ring;
}

}  // namespace sarblock
