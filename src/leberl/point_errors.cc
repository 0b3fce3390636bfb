// SPDX-License-Identifier: Apache-2.0
#include "sarblock/leberl/point_errors.h"

namespace sarblock::leberl {

double AcrossErrorOfSecondAcross(const StereoConfiguration& c, double dy0_second_m) {
  return dy0_second_m * (c.base_m - c.ground_range_m) / c.base_m;
}

double AlongError(const StereoConfiguration& c, const StereoErrors& errors, Signs signs) {
  const auto& [first, second] = errors;
  const double yaw_m =
      first.dydot0_1 * c.ground_range_m + second.dydot0_1 * (c.ground_range_m - c.base_m);
  const double pitch_m = (first.dzdot0_1 + second.dzdot0_1) * c.height_m;
  return 0.5 * (first.dx0_m + second.dx0_m + (signs == Signs::kPrinted ? yaw_m : -yaw_m) + pitch_m);
}

double AcrossError(const StereoConfiguration& c, const StereoErrors& errors) {
  const auto& [first, second] = errors;
  const double y_m = c.ground_range_m;
  return (first.dy0_m * y_m - second.dy0_m * (y_m - c.base_m) -
          (first.dz0_m - second.dz0_m) * c.height_m + first.dr_m * FirstSlantRange(c) -
          second.dr_m * SecondSlantRange(c)) /
         c.base_m;
}

double HeightError(const StereoConfiguration& c, const StereoErrors& errors) {
  const auto& [first, second] = errors;
  const double y_m = c.ground_range_m;
  const double back_m = y_m - c.base_m;
  return ((first.dy0_m - second.dy0_m) * y_m * back_m / c.height_m - first.dz0_m * back_m +
          second.dz0_m * y_m +
          (first.dr_m * FirstSlantRange(c) * back_m - second.dr_m * SecondSlantRange(c) * y_m) /
              c.height_m) /
         c.base_m;
}

PointError PointErrors(const StereoConfiguration& c, const StereoErrors& errors, Signs signs) {
  return {AlongError(c, errors, signs), AcrossError(c, errors), HeightError(c, errors)};
}

}  // namespace sarblock::leberl
