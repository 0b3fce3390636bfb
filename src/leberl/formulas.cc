// SPDX-License-Identifier: Apache-2.0
#include "sarblock/leberl/formulas.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <string>

#include "core/text.h"

namespace sarblock::leberl {

void Validate(const StereoConfiguration& c) {
  if (!std::isfinite(c.base_m) || c.base_m == 0.0) {
    throw InputError("base_m",
                     NumberText(c.base_m) + " is given, a finite number but 0 is allowed");
  }
  if (!(std::isfinite(c.height_m) && c.height_m > 0.0)) {
    throw InputError("height_m", NumberText(c.height_m) + " is given, > 0 is allowed");
  }
  const double sides = c.ground_range_m * (c.ground_range_m - c.base_m);
  if (c.arrangement == Arrangement::kSameSide && !(std::isfinite(sides) && sides > 0.0)) {
    throw InputError(
        "ground_range_m",
        NumberText(c.ground_range_m) + " is not on one side of both stations (0 and the base " +
            NumberText(c.base_m) + "); between them lies the opposite-side arrangement");
  }
  if (c.arrangement == Arrangement::kOppositeSide && !(sides < 0.0)) {
    throw InputError("ground_range_m",
                     NumberText(c.ground_range_m) +
                         " does not lie between the stations (0 and the base " +
                         NumberText(c.base_m) + "), as opposite-side stereo needs");
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
  return CheckViewing(std::abs(FirstLookAngle(c)), std::abs(SecondLookAngle(c)), c.arrangement);
}

ViewingGuidance CheckViewing(double first_look_rad,
                             double second_look_rad,
                             Arrangement arrangement) {
  const auto within = [](double angle_rad, double lower_deg, double upper_deg) {
    return angle_rad >= lower_deg * kRadPerDeg && angle_rad <= upper_deg * kRadPerDeg;
  };
  ViewingGuidance guidance;
  guidance.first_look_rad = first_look_rad;
  guidance.second_look_rad = second_look_rad;
  guidance.intersection_rad = arrangement == Arrangement::kSameSide
                                  ? std::abs(first_look_rad - second_look_rad)
                                  : first_look_rad + second_look_rad;
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

double AbsoluteParallax(const StereoConfiguration& c, Presentation presentation) {
  if (presentation == Presentation::kGroundRange) return c.base_m;
  // (r'^2 - r''^2) / (r' + r''): no cancellation for a short base
  return c.base_m * (2.0 * c.ground_range_m - c.base_m) /
         (FirstSlantRange(c) + SecondSlantRange(c));
}

double CameraExaggeration(double base_m, double height_m) {
  return kViewingRatio * base_m / height_m;
}

double EquivalentBase(double exaggeration, double height_m) {
  return exaggeration * height_m / kViewingRatio;
}

double ExaggerationFromAngles(double first_look_rad,
                              double second_look_rad,
                              Arrangement arrangement) {
  const double first = 1.0 / std::tan(first_look_rad);
  const double second = 1.0 / std::tan(second_look_rad);
  return kViewingRatio *
         std::abs(arrangement == Arrangement::kSameSide ? first - second : first + second);
}

double Exaggeration(const StereoConfiguration& c) {
  return kViewingRatio *
         std::abs(c.height_m * c.base_m / (c.ground_range_m * (c.ground_range_m - c.base_m)));
}

namespace {

/// Half the angle at which the eyes meet at the viewed images.
const double kHalfConvergence_rad = std::atan(0.5 / kViewingRatio);

}  // namespace

void Validate(const StereoViewing& viewing) {
  const auto require = [](const char* name, double value, bool allowed, const char* bound) {
    if (!(std::isfinite(value) && allowed)) {
      throw InputError(name, NumberText(value) + " is given, " + bound + " is allowed");
    }
  };
  require("scale", viewing.scale, viewing.scale > 0.0, "> 0");
  require("eye_base_m", viewing.eye_base_m, viewing.eye_base_m > 0.0, "> 0");
  require("acuity_rad", viewing.acuity_rad, viewing.acuity_rad > 0.0, "> 0");
  require("fusion_rad",
          viewing.fusion_rad,
          viewing.fusion_rad > viewing.acuity_rad && viewing.fusion_rad < kMaxFusion_rad,
          "more than the acuity and less than 0.2 rad");
}

double RetinalDisparity(double exaggeration, double height_m, const StereoViewing& viewing) {
  const double distance_m = kViewingRatio * viewing.eye_base_m;
  const double nearer_m = exaggeration * height_m / viewing.scale;
  return 2.0 *
         (std::atan(0.5 * viewing.eye_base_m / (distance_m - nearer_m)) - kHalfConvergence_rad);
}

double HeightOfDisparity(double exaggeration, double disparity_rad, const StereoViewing& viewing) {
  const double distance_m = kViewingRatio * viewing.eye_base_m;
  const double nearer_m =
      distance_m - 0.5 * viewing.eye_base_m / std::tan(kHalfConvergence_rad + 0.5 * disparity_rad);
  return nearer_m * viewing.scale / exaggeration;
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

namespace {

/// dr r of a station, with a scale error in dr.
double RangeMoment(const StationErrors& e, double range_m) {
  return (e.dr_m + e.range_scale * range_m) * range_m;
}

}  // namespace

double AcrossError(const StereoConfiguration& c, const StereoErrors& errors) {
  const auto& [first, second] = errors;
  const double y_m = c.ground_range_m;
  return (first.dy0_m * y_m - second.dy0_m * (y_m - c.base_m) -
          (first.dz0_m - second.dz0_m) * c.height_m + RangeMoment(first, FirstSlantRange(c)) -
          RangeMoment(second, SecondSlantRange(c))) /
         c.base_m;
}

double HeightError(const StereoConfiguration& c, const StereoErrors& errors) {
  const auto& [first, second] = errors;
  const double y_m = c.ground_range_m;
  const double back_m = y_m - c.base_m;
  return ((first.dy0_m - second.dy0_m) * y_m * back_m / c.height_m - first.dz0_m * back_m +
          second.dz0_m * y_m +
          (RangeMoment(first, FirstSlantRange(c)) * back_m -
           RangeMoment(second, SecondSlantRange(c)) * y_m) /
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

Warp RangeScaleWarp(const StereoConfiguration& c,
                    double range_scale_first,
                    double range_scale_second) {
  const double height = c.height_m, y = c.ground_range_m, back = y - c.base_m;
  const double e1 = range_scale_first / c.base_m, e2 = range_scale_second / c.base_m;
  const double square1 = y * y + height * height, square2 = back * back + height * height;
  return {.a = 2.0 * (e1 * y - e2 * back),
          .f = -2.0 * (e1 - e2) * height,
          .c = (e1 * (square1 + 2.0 * y * back) - e2 * (square2 + 2.0 * y * back)) / height,
          .d = (e1 * back * (y * y - height * height) - e2 * y * (back * back - height * height)) /
               (height * height)};
}

Difference DifferenceErrors(const StereoConfiguration& c,
                            const StereoErrors& errors,
                            const Difference& difference,
                            Signs signs) {
  const auto& [first, second] = errors;
  const bool printed = signs == Signs::kPrinted;
  const double first_constant_m = first.range_scale * FirstSlantRange(c);
  const double second_constant_m = second.range_scale * SecondSlantRange(c);
  Difference sum{};
  const auto add = [&sum](const Difference& part) {
    sum.dy_m += part.dy_m;
    sum.dz_m += part.dz_m;
  };
  add(DifferenceErrorOfBase(c, difference, second.dy0_m - first.dy0_m, signs));
  add(DifferenceErrorOfHeight(c, difference, second.dz0_m - first.dz0_m, signs));
  add(RangeWarp(c,
                first.dr_m + (printed ? first_constant_m : 0.0),
                second.dr_m + (printed ? second_constant_m : 0.0),
                signs)
          .Apply(difference));
  if (!printed) {
    add(RangeScaleWarp(c, first.range_scale, second.range_scale).Apply(difference));
  }
  return sum;
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
