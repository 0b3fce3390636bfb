// SPDX-License-Identifier: Apache-2.0
#include "sarblock/leberl/relative_errors.h"

#include <cmath>

namespace sarblock::leberl {
namespace {

// The paper differentiates by H where a height difference reduces H: Dz terms change sign.
double HeightSign(Signs signs) { return signs == Signs::kPrinted ? 1.0 : -1.0; }

}  // namespace

double AcrossErrorOfBase(const StereoConfiguration& c, double base_error_m) {
  return -c.ground_range_m / c.base_m * base_error_m;
}

double HeightErrorOfBase(const StereoConfiguration& c, double base_error_m) {
  return (c.base_m - c.ground_range_m) * c.ground_range_m / (c.base_m * c.height_m) * base_error_m;
}

double AcrossErrorOfHeight(const StereoConfiguration& c, double height_error_m) {
  return c.height_m / c.base_m * height_error_m;
}

double HeightErrorOfHeight(const StereoConfiguration& c, double height_error_m) {
  return c.ground_range_m / c.base_m * height_error_m;
}

Difference DifferenceErrorOfBase(const StereoConfiguration& c,
                                 const Difference& difference,
                                 double base_error_m,
                                 Signs signs) {
  const double across = (c.base_m - 2.0 * c.ground_range_m) / (c.base_m * c.height_m);
  const double up = -c.ground_range_m * (c.base_m - c.ground_range_m) /
                    (c.base_m * c.height_m * c.height_m) * HeightSign(signs);
  return {-difference.dy_m / c.base_m * base_error_m,
          (difference.dy_m * across + difference.dz_m * up) * base_error_m};
}

Difference DifferenceErrorOfHeight(const StereoConfiguration& c,
                                   const Difference& difference,
                                   double height_error_m,
                                   Signs signs) {
  const double ratio = height_error_m / c.base_m;
  return {HeightSign(signs) * ratio * difference.dz_m, ratio * difference.dy_m};
}

Warp RangeWarp(const StereoConfiguration& c,
               double range_error_first_m,
               double range_error_second_m,
               Signs signs) {
  const double base = c.base_m, height = c.height_m;
  const double y = c.ground_range_m, back = y - base;
  const double r1 = FirstSlantRange(c), r2 = SecondSlantRange(c);
  const double e1 = range_error_first_m / base, e2 = range_error_second_m / base;
  Warp warp;
  warp.a_1 = e1 * y / r1 - e2 * back / r2;
  warp.f_1 = (e1 * height / r1 - e2 * height / r2) * HeightSign(signs);
  warp.c_1 =
      e1 * (r1 / height + y * back / (height * r1)) - e2 * (r2 / height + y * back / (height * r2));
  warp.d_1 = (e1 * (back / r1 - back * r1 / (height * height)) -
              e2 * (y / r2 - y * r2 / (height * height))) *
             HeightSign(signs);
  return warp;
}

RangeNoise NoiseOfRange(const StereoConfiguration& c, double range_sigma_m) {
  return NoiseOfRange(c, range_sigma_m, range_sigma_m);
}

RangeNoise NoiseOfRange(const StereoConfiguration& c,
                        double first_range_sigma_m,
                        double second_range_sigma_m) {
  const double first = first_range_sigma_m * FirstSlantRange(c) / c.base_m;
  const double second = second_range_sigma_m * SecondSlantRange(c) / c.base_m;
  return {
      std::hypot(first, second),
      std::hypot(first * (c.ground_range_m - c.base_m), second * c.ground_range_m) / c.height_m};
}

}  // namespace sarblock::leberl
