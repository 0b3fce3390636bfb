// SPDX-License-Identifier: Apache-2.0
#include "sarblock/leberl/formulas.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <string>

namespace sarblock::leberl {

void Validate(const StereoConfiguration& c) {
  if (!std::isfinite(c.base_m) || c.base_m == 0.0) {
    throw InputError("base_m", std::to_string(c.base_m) + " is no stereo base, not 0 is allowed");
  }
  if (!(std::isfinite(c.height_m) && c.height_m > 0.0)) {
    throw InputError("height_m", std::to_string(c.height_m) + " is given, > 0 is allowed");
  }
  const double sides = c.ground_range_m * (c.ground_range_m - c.base_m);
  if (c.arrangement == Arrangement::kSameSide && !(std::isfinite(sides) && sides > 0.0)) {
    throw InputError("ground_range_m",
                     std::to_string(c.ground_range_m) +
                         " is not on one side of both stations (0 and base_m); between them lies "
                         "the opposite-side arrangement");
  }
  if (c.arrangement == Arrangement::kOppositeSide && !(sides < 0.0)) {
    throw InputError("ground_range_m",
                     std::to_string(c.ground_range_m) +
                         " does not lie between the stations (0 and base_m), as opposite-side "
                         "stereo needs");
  }
}

double FirstLookAngle(const StereoConfiguration& c) {
  return std::atan2(c.ground_range_m, c.height_m);
}

double SecondLookAngle(const StereoConfiguration& c) {
  return std::atan2(c.ground_range_m - c.base_m, c.height_m);
}

double IntersectionAngle(const StereoConfiguration& c) {
  return std::abs(FirstLookAngle(c) - SecondLookAngle(c));
}

double FirstSlantRange(const StereoConfiguration& c) {
  return std::hypot(c.height_m, c.ground_range_m);
}

double SecondSlantRange(const StereoConfiguration& c) {
  return std::hypot(c.height_m, c.ground_range_m - c.base_m);
}

ViewingGuidance CheckViewing(const StereoConfiguration& c) {
  const auto within = [](double angle_rad, double lower_deg, double upper_deg) {
    return angle_rad >= lower_deg * kRadPerDeg && angle_rad <= upper_deg * kRadPerDeg;
  };
  ViewingGuidance guidance;
  guidance.first_look_rad = std::abs(FirstLookAngle(c));
  guidance.second_look_rad = std::abs(SecondLookAngle(c));
  guidance.intersection_rad = IntersectionAngle(c);
  guidance.looks_within_37_and_67_deg =
      within(guidance.first_look_rad, 37.0, 67.0) && within(guidance.second_look_rad, 37.0, 67.0);
  guidance.looks_not_below_40_deg =
      within(guidance.first_look_rad, 40.0, 90.0) && within(guidance.second_look_rad, 40.0, 90.0);
  guidance.intersection_within_12_and_15_deg = within(guidance.intersection_rad, 12.0, 15.0);
  return guidance;
}

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

double AcrossErrorOfSecondAcross(const StereoConfiguration& c, double dy0_second_m) {
  return dy0_second_m * (c.base_m - c.ground_range_m) / c.base_m;
}

double AlongError(const StereoConfiguration& c, const StereoErrors& errors, Signs signs) {
  const auto& [first, second] = errors;
  const double yaw_m =
      first.dydot0 * c.ground_range_m + second.dydot0 * (c.ground_range_m - c.base_m);
  const double pitch_m = (first.dzdot0 + second.dzdot0) * c.height_m;
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
  warp.a = e1 * y / r1 - e2 * back / r2;
  warp.f = (e1 * height / r1 - e2 * height / r2) * HeightSign(signs);
  warp.c =
      e1 * (r1 / height + y * back / (height * r1)) - e2 * (r2 / height + y * back / (height * r2));
  warp.d = (e1 * (back / r1 - back * r1 / (height * height)) -
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
