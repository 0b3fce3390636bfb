// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/leberl/configuration.h"

namespace sarblock::leberl {

/// How the image shows range: projected on the datum, or as measured.
enum class Presentation { kGroundRange, kSlantRange };

/// Displacement of a point of height h in one image, wave fronts replaced by planes:
/// ground range p = h cot(theta), slant range p = h cos(theta). Leberl (1979), Eq. 6 and 7.
/// `look_rad` is the magnitude of the look angle, in (0, pi/2). Positive towards the antenna. [m]
[[nodiscard]] double HeightDisplacement(double look_rad,
                                        double height_m,
                                        Presentation presentation);

/// Parallax difference dp of two points that differ in height by h: [m]
///     ground range: dp = h (cot(theta'') -/+ cot(theta')),
///     slant range:  dp = h (cos(theta'') -/+ cos(theta')),
/// minus for same-side, plus for opposite-side. Leberl (1979), Eq. 6 and 7.
[[nodiscard]] double ParallaxFromHeight(const StereoConfiguration& c,
                                        double height_m,
                                        Presentation presentation);

/// Inverse of ParallaxFromHeight: h = dp / (cot(theta'') -/+ cot(theta')), and with cosines for
/// slant range. [m] Leberl (1979), Eq. 6 and 7.
[[nodiscard]] double HeightFromParallax(const StereoConfiguration& c,
                                        double parallax_m,
                                        Presentation presentation);

/// Absolute parallax in slant range presentation of a point of the datum, a = r' - r'' [m].
/// Leberl (1979), Eq. 8, with the plus sign under the second root. Points of equal height have
/// different a: a flat surface appears as a hyperbola-like cylinder.
[[nodiscard]] double AbsoluteParallax(const StereoConfiguration& c);

/// Vertical exaggeration q of a stereo model, three forms. Dimensionless magnitudes.
/// Camera: q ~ 5 Bc/H. Leberl (1979), Eq. 9. base_m >= 0, height_m > 0.
[[nodiscard]] double CameraExaggeration(double base_m, double height_m);
/// Radar: q ~ 5 |cot(theta') -/+ cot(theta'')|, minus same-side, plus opposite-side; look angles
/// are magnitudes in (0, pi/2). Leberl (1979), Eq. 10.
[[nodiscard]] double ExaggerationFromAngles(double first_look_rad,
                                            double second_look_rad,
                                            Arrangement arrangement);
/// Radar: q ~ 5 H B / (y (y - B)), magnitude. Leberl (1979), Eq. 11.
[[nodiscard]] double Exaggeration(const StereoConfiguration& c);

}  // namespace sarblock::leberl
