// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/leberl/configuration.h"

namespace sarblock::leberl {

// Errors of coordinate differences, first order in the error and linear in the difference (Dy, Dz)
// between a point and the point (y, 0) of the configuration. dB = dy0'' - dy0', dH = dz0'' - dz0'.

/// dy = -(y/B) dB + const [m], without the constant (dy0'' itself). Leberl (1979), Eq. 16.
[[nodiscard]] double AcrossErrorOfBase(const StereoConfiguration& c, double base_error_m);
/// dz = ((B - y) y/(B H)) dB [m]. Leberl (1979), Eq. 17.
[[nodiscard]] double HeightErrorOfBase(const StereoConfiguration& c, double base_error_m);
/// dy = (H/B) dH [m]. Leberl (1979), Eq. 20.
[[nodiscard]] double AcrossErrorOfHeight(const StereoConfiguration& c, double height_error_m);
/// dz = (y/B) dH + const [m], without the constant. Leberl (1979), Eq. 21.
[[nodiscard]] double HeightErrorOfHeight(const StereoConfiguration& c, double height_error_m);

/// Difference of two points' coordinates: Dy across, Dz up.
struct Difference {
  double dy_m = 0.0;
  double dz_m = 0.0;
};

/// Effect of a base error [m]. Leberl (1979), Eq. 18 and 19:
///     d(Dy) = -(Dy/B) dB
///     d(Dz) = { Dy (B - 2y)/(B H) - Dz y (B - y)/(B H^2) } dB
/// kDerived: the Dz term is positive, because Dz reduces the height H above the point.
[[nodiscard]] Difference DifferenceErrorOfBase(const StereoConfiguration& c,
                                               const Difference& difference,
                                               double base_error_m,
                                               Signs signs);

/// Effect of a height difference error [m]. Leberl (1979), Eq. 22 and 23:
///     d(Dy) = (dH/B) Dz,   d(Dz) = (dH/B) Dy;   kDerived: d(Dy) = -(dH/B) Dz.
[[nodiscard]] Difference DifferenceErrorOfHeight(const StereoConfiguration& c,
                                                 const Difference& difference,
                                                 double height_error_m,
                                                 Signs signs);

/// Systematic slant range errors warp the model: d(Dy) = A Dy + F Dz, d(Dz) = C Dy + D Dz.
/// Leberl (1979), Eq. 24; the four are dimensionless. kDerived: F and D with the opposite sign.
struct Warp {
  double a_1 = 0.0;
  double f_1 = 0.0;
  double c_1 = 0.0;
  double d_1 = 0.0;
  [[nodiscard]] Difference Of(const Difference& difference) const {
    return {a_1 * difference.dy_m + f_1 * difference.dz_m,
            c_1 * difference.dy_m + d_1 * difference.dz_m};
  }
};
[[nodiscard]] Warp RangeWarp(const StereoConfiguration& c,
                             double range_error_first_m,
                             double range_error_second_m,
                             Signs signs);

/// Standard deviations of a point by independent range noise of both images, Leberl (1979), Eq. 25:
///     sigma_y^2 = sigma_r^2 (r'^2 + r''^2) / B^2
///     sigma_z^2 = sigma_r^2 (r'^2 (y - B)^2 + r''^2 y^2) / (B^2 H^2)
struct RangeNoise {
  double sigma_y_m = 0.0;
  double sigma_z_m = 0.0;
};
[[nodiscard]] RangeNoise NoiseOfRange(const StereoConfiguration& c, double range_sigma_m);

/// The same with a standard deviation for each image; equal ones give Eq. 25.
[[nodiscard]] RangeNoise NoiseOfRange(const StereoConfiguration& c,
                                      double first_range_sigma_m,
                                      double second_range_sigma_m);

}  // namespace sarblock::leberl
