// SPDX-License-Identifier: Apache-2.0
#include "sarblock/leberl/parallax.h"

#include <cmath>

namespace sarblock::leberl {
namespace {

double Factor(const StereoConfiguration& c, Presentation presentation) {
  const double first = HeightDisplacement(std::abs(FirstLookAngle(c)), 1.0, presentation);
  const double second = HeightDisplacement(std::abs(SecondLookAngle(c)), 1.0, presentation);
  return c.arrangement == Arrangement::kSameSide ? second - first : second + first;
}

}  // namespace

double HeightDisplacement(double look_rad, double height_m, Presentation presentation) {
  return presentation == Presentation::kGroundRange ? height_m / std::tan(look_rad)
                                                    : height_m * std::cos(look_rad);
}

double ParallaxFromHeight(const StereoConfiguration& c,
                          double height_m,
                          Presentation presentation) {
  return height_m * Factor(c, presentation);
}

double HeightFromParallax(const StereoConfiguration& c,
                          double parallax_m,
                          Presentation presentation) {
  return parallax_m / Factor(c, presentation);
}

double AbsoluteParallax(const StereoConfiguration& c) {
  // (r'^2 - r''^2) / (r' + r''): no cancellation for a short base
  return c.base_m * (2.0 * c.ground_range_m - c.base_m) /
         (FirstSlantRange(c) + SecondSlantRange(c));
}

double CameraExaggeration(double base_m, double height_m) { return 5.0 * base_m / height_m; }

double ExaggerationFromAngles(double first_look_rad,
                              double second_look_rad,
                              Arrangement arrangement) {
  const double first = 1.0 / std::tan(first_look_rad);
  const double second = 1.0 / std::tan(second_look_rad);
  return 5.0 * std::abs(arrangement == Arrangement::kSameSide ? first - second : first + second);
}

double Exaggeration(const StereoConfiguration& c) {
  return 5.0 * std::abs(c.height_m * c.base_m / (c.ground_range_m * (c.ground_range_m - c.base_m)));
}

}  // namespace sarblock::leberl
