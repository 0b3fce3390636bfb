// SPDX-License-Identifier: Apache-2.0
#include "image_sigma.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sarblock {
namespace {

constexpr double kLightSpeed_mps = 299792458.0;
constexpr double kEdge_rad = std::numbers::pi / 180.0;
/// Full width at half maximum of a Gaussian curve over its standard deviation, sqrt(8 ln 2).
constexpr double kFullWidth = 2.3548200450309493;

double Bounded(double local_incidence_rad) {
  return std::clamp(local_incidence_rad, kEdge_rad, 0.5 * std::numbers::pi - kEdge_rad);
}

/// Signal over noise of ground at a local incidence.
double SignalToNoise(const SceneImage& image, double local_incidence_rad) {
  const double falls = std::cos(Bounded(local_incidence_rad)) / std::cos(image.snr_incidence_rad);
  return std::pow(10.0, 0.1 * image.snr_db) * std::pow(falls, image.backscatter_exponent);
}

}  // namespace

ImageView ViewOf(const Frame& frame,
                 const Eigen::Vector3d& point_m,
                 const Eigen::Vector3d& normal,
                 const Eigen::Vector3d& antenna_m) {
  const Eigen::Vector3d sight = (antenna_m - point_m).normalized();
  const Eigen::Vector3d enu = frame.EnuFromFrame(point_m) * sight;
  ImageView view;
  view.local_incidence_rad =
      std::atan2(normal.cross(sight).norm(), std::max(0.0, normal.dot(sight)));
  const double level = enu.head<2>().norm();
  if (level > 0.0) view.parallax = -enu.head<2>() * (enu[2] / (level * level));
  return view;
}

ImageSigma SigmaOfMatch(const SceneImage& image, const ImageView& view, const ImageView& other) {
  const double range_m = 0.5 * kLightSpeed_mps / image.bandwidth_hz;
  if (std::isnan(image.window_m)) {
    const double part = std::sqrt(1.5 * std::pow(10.0, -0.1 * image.snr_db)) / std::numbers::pi;
    return {part * range_m, part * image.azimuth_resolution_m};
  }
  const double sine = std::sin(Bounded(view.local_incidence_rad));
  const double sine_of_other = std::sin(Bounded(other.local_incidence_rad));
  const double cells = std::max(
      1.0, image.window_m * image.window_m * sine / (range_m * image.azimuth_resolution_m));
  double correlation =
      image.correlation / std::sqrt((1.0 + 1.0 / SignalToNoise(image, view.local_incidence_rad)) *
                                    (1.0 + 1.0 / SignalToNoise(image, other.local_incidence_rad)));
  const double smear_m =
      image.slope_rms * image.window_m / std::sqrt(12.0) * (view.parallax - other.parallax).norm();
  const double texture_m = 0.5 * (range_m / sine + range_m / sine_of_other) / kFullWidth;
  correlation /= std::hypot(1.0, smear_m / texture_m);
  // Of the shift between both images, which share it.
  const double part = std::sqrt(1.5 / cells) * std::sqrt(1.0 - correlation * correlation) /
                      (std::numbers::pi * correlation * std::numbers::sqrt2);
  return {part * range_m, part * image.azimuth_resolution_m};
}

LookSigma SigmaOfPass(const SceneLooks& looks) {
  LookSigma out = looks.azimuth;
  out.range_m = looks.range_sigma_m;
  if (looks.image) {
    const ImageView level{looks.image->snr_incidence_rad, Eigen::Vector2d::Zero()};
    const ImageSigma sigma = SigmaOfMatch(*looks.image, level, level);
    out.range_m = sigma.range_m;
    out.azimuth = sigma.azimuth_m;
    out.azimuth_unit = AzimuthUnit::kMetres;
  }
  return out;
}

}  // namespace sarblock
