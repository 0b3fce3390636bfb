// SPDX-License-Identifier: Apache-2.0
#include "reduction.h"

#include <cmath>

namespace sarblock::leberl {
namespace {

double Dot(const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Triple Sum(const Triple& a, double factor, const Triple& b) {
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}

Triple Unit(const Triple& a) {
  const double length = std::sqrt(Dot(a, a));
  return {a[0] / length, a[1] / length, a[2] / length};
}

Triple Cross(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

std::optional<StereoConfiguration> ReducePair(const Triple& point_m,
                                              const Triple& up_1,
                                              const ReducedLook& first,
                                              const ReducedLook& second,
                                              const ReductionLimits& limits) {
  const Triple first_track = Unit(first.velocity_mps);
  const Triple second_track = Unit(second.velocity_mps);
  const double cosine = Dot(first_track, second_track);
  // written so that NaN (a zero velocity) is refused too
  if (!(std::abs(cosine) >= std::cos(limits.max_convergence_rad))) return std::nullopt;
  const Triple along = Unit(Sum(first_track, cosine < 0.0 ? -1.0 : 1.0, second_track));
  const Triple up = Unit(Sum(up_1, -Dot(up_1, along), along));
  const Triple across = Cross(up, along);

  const Triple first_sight_m = Sum(point_m, -1.0, first.antenna_m);
  const Triple second_sight_m = Sum(point_m, -1.0, second.antenna_m);
  for (const Triple& sight_m : {first_sight_m, second_sight_m}) {
    const double sine = Dot(sight_m, along) / std::sqrt(Dot(sight_m, sight_m));
    if (!(std::abs(sine) <= std::sin(limits.max_squint_rad))) return std::nullopt;
  }
  const double first_height_m = -Dot(first_sight_m, up);
  const double second_height_m = -Dot(second_sight_m, up);
  if (!(first_height_m > 0.0 && second_height_m > 0.0)) return std::nullopt;

  StereoConfiguration c;
  c.height_m = 0.5 * (first_height_m + second_height_m);
  c.ground_range_m = Dot(first_sight_m, across);
  c.base_m = c.ground_range_m - Dot(second_sight_m, across);
  const double sides_m2 = c.ground_range_m * (c.ground_range_m - c.base_m);
  c.arrangement = sides_m2 < 0.0 ? Arrangement::kOppositeSide : Arrangement::kSameSide;
  constexpr double kNoBase = 1e-9;  // of H: two looks from one track
  const bool meaningful =
      std::abs(first_height_m - second_height_m) <= limits.max_height_ratio_1 * c.height_m &&
      std::abs(c.base_m) > kNoBase * c.height_m && sides_m2 != 0.0;
  if (!meaningful) return std::nullopt;
  return c;
}

}  // namespace sarblock::leberl
