// SPDX-License-Identifier: Apache-2.0
#include "sarblock/leberl/configuration.h"

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

}  // namespace sarblock::leberl
