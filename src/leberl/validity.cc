// SPDX-License-Identifier: Apache-2.0
#include "validity.h"

#include "sarblock/core/error.h"
#include "sarblock/leberl/formulas.h"

#include <array>
#include <cmath>

#include "rigorous.h"

namespace sarblock {
namespace {

constexpr double kHeight_m = 1e4;  // any: the figure depends on ratios only

std::vector<ValidityCase> Cases(const ValidityOptions& options) {
  std::vector<ValidityCase> cases;
  for (const auto source :
       {ValiditySource::kAcrossPosition, ValiditySource::kUpPosition, ValiditySource::kRange}) {
    for (const double base : options.base_ratio) {
      for (const double terrain : options.terrain_ratio) {
        for (const double look_deg : options.look_deg) {
          cases.push_back({.source = source,
                           .arrangement = std::tan(look_deg * kRadPerDeg) > base
                                              ? leberl::Arrangement::kSameSide
                                              : leberl::Arrangement::kOppositeSide,
                           .look_rad = look_deg * kRadPerDeg,
                           .base_ratio = base,
                           .terrain_ratio = terrain});
        }
      }
    }
  }
  return cases;
}

}  // namespace

const char* NameOf(ValiditySource source) {
  switch (source) {
    case ValiditySource::kAcrossPosition:
      return "dy0''";
    case ValiditySource::kUpPosition:
      return "dz0''";
    case ValiditySource::kRange:
      break;
  }
  return "dr''";
}

std::optional<double> RelativeDifference(const ValidityCase& v, double error_ratio) {
  const leberl::StereoConfiguration c{.base_m = v.base_ratio * kHeight_m,
                                      .height_m = kHeight_m,
                                      .ground_range_m = std::tan(v.look_rad) * kHeight_m,
                                      .arrangement = v.arrangement};
  const double sides_m2 = c.ground_range_m * (c.ground_range_m - c.base_m);
  const bool same_side = v.arrangement == leberl::Arrangement::kSameSide;
  if (!(same_side ? sides_m2 > 0.0 : sides_m2 < 0.0)) return std::nullopt;
  leberl::StereoErrors errors;
  const double size_m = error_ratio * kHeight_m;
  switch (v.source) {
    case ValiditySource::kAcrossPosition:
      errors.second.dy0_m = size_m;
      break;
    case ValiditySource::kUpPosition:
      errors.second.dz0_m = size_m;
      break;
    case ValiditySource::kRange:
      errors.second.dr_m = size_m;
      break;
  }
  const auto exact = StereoErrorExact(c, errors, v.terrain_ratio * kHeight_m);
  if (!exact) return std::nullopt;
  return std::hypot(AcrossError(c, errors) - exact->dy_m, HeightError(c, errors) - exact->dz_m) /
         std::hypot(exact->dy_m, exact->dz_m);
}

std::optional<double> ErrorRatioAtLevel(const ValidityCase& v, double level) {
  constexpr double kSmallest = 1e-7;
  constexpr int kStepsPerDecade = 8, kDecades = 7;
  const auto at_zero = RelativeDifference(v, kSmallest);
  if (!at_zero) return std::nullopt;
  if (*at_zero >= level) return 0.0;
  double below = kSmallest;
  for (int step = 1; step <= kStepsPerDecade * kDecades; ++step) {
    double above = kSmallest * std::pow(10.0, static_cast<double>(step) / kStepsPerDecade);
    const auto there = RelativeDifference(v, above);
    if (there && *there < level) {
      below = above;
      continue;
    }
    // where the circles no longer meet the first order is off by any level
    while (above - below > 1e-6 * below) {
      const double middle = 0.5 * (below + above);
      const auto difference = RelativeDifference(v, middle);
      (difference && *difference < level ? below : above) = middle;
    }
    return above;
  }
  return std::nullopt;
}

std::vector<ValidityRow> ValidityMap(const ValidityOptions& options) {
  std::vector<ValidityRow> rows;
  for (const ValidityCase& of : Cases(options)) {
    for (const double error_ratio : options.error_ratio) {
      rows.push_back({.of = of,
                      .error_ratio = error_ratio,
                      .relative_difference = RelativeDifference(of, error_ratio)});
    }
  }
  return rows;
}

std::vector<ValidityLine> ValidityLines(const ValidityOptions& options) {
  std::vector<ValidityLine> lines;
  for (const ValidityCase& of : Cases(options)) {
    lines.push_back({.of = of,
                     .error_ratio_1_percent = ErrorRatioAtLevel(of, 0.01),
                     .error_ratio_5_percent = ErrorRatioAtLevel(of, 0.05),
                     .error_ratio_20_percent = ErrorRatioAtLevel(of, 0.20)});
  }
  return lines;
}

}  // namespace sarblock
