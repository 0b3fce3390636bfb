// SPDX-License-Identifier: Apache-2.0
#include "sicd_projection.h"

#include <cmath>

#include <Eigen/Dense>

namespace sarblock {
namespace {

using RangeAndRate = Eigen::Vector2d;  // [m], [m/s]

// As an antenna in motion sees a place that stands still.
RangeAndRate Seen(const SicdMotion& antenna, const Eigen::Vector3d& p_m) {
  const Eigen::Vector3d from_m = antenna.position_m - p_m;
  const double range_m = from_m.norm();
  return {range_m, antenna.velocity_mps.dot(from_m) / range_m};
}

// The image projections of SICD volume 3 at a time that is given apart.
RangeAndRate OfInca(const SicdImage& image, double x_m, double y_m, double time_s) {
  const double closest_s = ValueOf(image.closest_time_s, y_m);
  const double closest_m = image.closest_range_m + x_m;
  const double speed_mps = MotionOf(image, closest_s).velocity_mps.norm();
  const double rate_m2ps2 = ValueOf(image.rate_scale_1, x_m, y_m) * speed_mps * speed_mps;
  const double since_s = time_s - closest_s;
  const double range_m = std::sqrt(closest_m * closest_m + rate_m2ps2 * since_s * since_s);
  return {range_m, rate_m2ps2 * since_s / range_m};
}

RangeAndRate OfPolarFormat(const SicdImage& image, double x_m, double y_m, double time_s) {
  const double angle_rad = ValueOf(image.polar_angle_rad, time_s);
  const double turn_radps = ValueOf(DerivativeOf(image.polar_angle_rad), time_s);
  const double scale_1 = ValueOf(image.frequency_scale_1, angle_rad);
  const double scale_rate_1 = ValueOf(DerivativeOf(image.frequency_scale_1), angle_rad);
  const double along_m = x_m * std::cos(angle_rad) + y_m * std::sin(angle_rad);
  const double across_m = y_m * std::cos(angle_rad) - x_m * std::sin(angle_rad);
  const RangeAndRate centre = Seen(MotionOf(image, time_s), image.centre_m);
  return centre + RangeAndRate(scale_1 * along_m,
                               (scale_rate_1 * along_m + scale_1 * across_m) * turn_radps);
}

RangeAndRate OfAzimuthCompression(const SicdImage& image, double x_m, double y_m, double time_s) {
  const SicdMotion antenna = MotionOf(image, time_s);
  return Seen(antenna, image.centre_m) +
         RangeAndRate(x_m, -antenna.velocity_mps.norm() * image.cone_cosine_per_m * y_m);
}

RangeAndRate OfPlane(const SicdImage& image, double x_m, double y_m, double time_s) {
  return Seen(MotionOf(image, time_s),
              image.centre_m + x_m * image.axes_1[0] + y_m * image.axes_1[1]);
}

RangeAndRate Measured(const SicdImage& image, double x_m, double y_m, double time_s) {
  switch (image.kind) {
    case SicdKind::kPolarFormat:
      return OfPolarFormat(image, x_m, y_m, time_s);
    case SicdKind::kAzimuthCompression:
      return OfAzimuthCompression(image, x_m, y_m, time_s);
    case SicdKind::kPlane:
      return OfPlane(image, x_m, y_m, time_s);
    case SicdKind::kInca:
      break;
  }
  return OfInca(image, x_m, y_m, time_s);
}

// By central differences over a metre of rows and of columns; the functions are nearly linear.
template <typename Function>
Eigen::Matrix2d Slopes(const Function& function, double x_m, double y_m) {
  constexpr double kHalf_m = 0.5;
  Eigen::Matrix2d slopes;
  slopes.col(0) = function(x_m + kHalf_m, y_m) - function(x_m - kHalf_m, y_m);
  slopes.col(1) = function(x_m, y_m + kHalf_m) - function(x_m, y_m - kHalf_m);
  return slopes;
}

}  // namespace

SicdMotion MotionOf(const SicdImage& image, double time_s) {
  SicdMotion motion;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    motion.position_m[i] = ValueOf(image.path_m[axis], time_s);
    motion.velocity_mps[i] = ValueOf(DerivativeOf(image.path_m[axis]), time_s);
  }
  return motion;
}

std::optional<ApertureLook> LookOfPlace(const SicdImage& image, double row_px, double column_px) {
  const double x_m = image.Row_m(row_px), y_m = image.Azimuth_m(column_px);
  const double time_s = ValueOf(image.aperture_time_s, x_m, y_m);
  const RangeAndRate measured = Measured(image, x_m, y_m, time_s);
  const double speed_mps = MotionOf(image, time_s).velocity_mps.norm();
  const bool possible = std::isfinite(time_s) && std::isfinite(measured[0]) && measured[0] > 0.0 &&
                        std::isfinite(speed_mps) && std::abs(measured[1]) < speed_mps;
  if (!possible) return std::nullopt;
  return ApertureLook{time_s, measured[0], measured[1]};
}

std::optional<ApertureSigma> SigmaOfPlace(const SicdImage& image,
                                          double row_px,
                                          double column_px,
                                          double row_sigma_px,
                                          double column_sigma_px) {
  const double x_m = image.Row_m(row_px), y_m = image.Azimuth_m(column_px);
  const double time_s = ValueOf(image.aperture_time_s, x_m, y_m);
  const Eigen::Matrix2d slopes = Slopes(
      [&](double row_m, double column_m) { return Measured(image, row_m, column_m, time_s); },
      x_m,
      y_m);
  const Eigen::Vector2d sigma_m(row_sigma_px * image.row_spacing_m,
                                column_sigma_px * image.column_spacing_m);
  const Eigen::Vector2d sigma = (slopes * sigma_m.asDiagonal()).rowwise().norm();
  if (!sigma.allFinite() || !(sigma.minCoeff() > 0.0)) return std::nullopt;
  return ApertureSigma{sigma[0], sigma[1]};
}

std::optional<ImageCoordinates> PlaceInSicd(const SicdImage& image, const Eigen::Vector3d& p_m) {
  constexpr int kMostSteps = 30;
  constexpr double kEnd_m = 1e-8, kFarthest_m = 1e7;
  // What the image says of a place less what the antenna sees there at the same time.
  const auto difference = [&](double x_m, double y_m) -> Eigen::Vector2d {
    const double time_s = ValueOf(image.aperture_time_s, x_m, y_m);
    return Measured(image, x_m, y_m, time_s) - Seen(MotionOf(image, time_s), p_m);
  };
  Eigen::Vector2d place_m = Eigen::Vector2d::Zero();
  for (int step = 0; step < kMostSteps; ++step) {
    const Eigen::Matrix2d slopes = Slopes(difference, place_m.x(), place_m.y());
    const Eigen::Vector2d change_m = -slopes.inverse() * difference(place_m.x(), place_m.y());
    place_m += change_m;
    if (!(place_m.norm() < kFarthest_m)) return std::nullopt;
    if (change_m.norm() > kEnd_m * (1.0 + place_m.norm())) continue;
    return ImageCoordinates{
        place_m.x() / image.row_spacing_m + image.centre_row_px - image.first_row_px,
        place_m.y() / image.column_spacing_m + image.centre_column_px - image.first_column_px};
  }
  return std::nullopt;
}

}  // namespace sarblock
