// SPDX-License-Identifier: Apache-2.0
#include "rigorous.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/leberl/formulas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "linear/dense.h"
#include <fmt/core.h>

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

const double kMinCosineOfTracks = std::cos(kMaxConvergence_rad);
const double kMaxSineOfSquint = std::sin(kMaxSquint_rad);

}  // namespace

std::optional<StereoConfiguration> ReducePair(const Triple& point_m,
                                              const Triple& vertical,
                                              const ReducedLook& first,
                                              const ReducedLook& second) {
  const Triple first_track = Unit(first.velocity_mps);
  const Triple second_track = Unit(second.velocity_mps);
  const double cosine = Dot(first_track, second_track);
  // written so that NaN (a zero velocity) is refused too
  if (!(std::abs(cosine) >= kMinCosineOfTracks)) return std::nullopt;
  const Triple along = Unit(Sum(first_track, cosine < 0.0 ? -1.0 : 1.0, second_track));
  const Triple up = Unit(Sum(vertical, -Dot(vertical, along), along));
  const Triple across = Cross(up, along);

  const Triple first_los_m = Sum(point_m, -1.0, first.antenna_m);
  const Triple second_los_m = Sum(point_m, -1.0, second.antenna_m);
  for (const Triple& los_m : {first_los_m, second_los_m}) {
    const double sine = Dot(los_m, along) / std::sqrt(Dot(los_m, los_m));
    if (!(std::abs(sine) <= kMaxSineOfSquint)) return std::nullopt;
  }
  const double first_height_m = -Dot(first_los_m, up);
  const double second_height_m = -Dot(second_los_m, up);
  if (!(first_height_m > 0.0 && second_height_m > 0.0)) return std::nullopt;

  StereoConfiguration c;
  c.height_m = 0.5 * (first_height_m + second_height_m);
  c.ground_range_m = Dot(first_los_m, across);
  c.base_m = c.ground_range_m - Dot(second_los_m, across);
  const double sides_m2 = c.ground_range_m * (c.ground_range_m - c.base_m);
  c.arrangement = sides_m2 < 0.0 ? Arrangement::kOppositeSide : Arrangement::kSameSide;
  constexpr double kNoBase = 1e-9;  // of H: two looks from one track
  const bool meaningful =
      std::abs(first_height_m - second_height_m) <= kMaxHeightRatio * c.height_m &&
      std::abs(c.base_m) > kNoBase * c.height_m && sides_m2 != 0.0;
  if (!meaningful) return std::nullopt;
  return c;
}

}  // namespace sarblock::leberl

namespace sarblock {
namespace {

using leberl::PointError;
using leberl::StationErrors;
using leberl::StereoConfiguration;
using leberl::StereoErrors;
using stereo::Dual;
using stereo::Station;
using stereo::Vector;

/// The true stations, seen from a point (0, y, z).
template <typename T>
std::array<Station<T>, 2> TrueStations(const StereoConfiguration& c, const Vector<T>& p) {
  std::array<Station<T>, 2> stations{};
  for (std::size_t k = 0; k < 2; ++k) {
    const long double across = k == 0 ? 0.0L : static_cast<long double>(c.base_m);
    stations[k].antenna = {T{0.0L}, T{across}, T{static_cast<long double>(c.height_m)}};
    stations[k].axis = {T{1.0L}, T{0.0L}, T{0.0L}};
    Vector<T> observation{};
    for (std::size_t i = 0; i < 3; ++i) observation[i] = p[i] - stations[k].antenna[i];
    stations[k].range = stereo::Norm(observation);
  }
  return stations;
}

template <typename T>
Vector<T> Derivative(const StereoConfiguration& c, const StereoErrors& errors, const Vector<T>& p) {
  const std::array<Station<T>, 2> stations = TrueStations(c, p);
  std::array<Vector<T>, 2> observations{};
  for (std::size_t k = 0; k < 2; ++k) {
    for (std::size_t i = 0; i < 3; ++i) observations[k][i] = p[i] - stations[k].antenna[i];
  }
  const auto equations = stereo::Evaluate(p, stations);
  std::array<T, 4> right =
      stereo::ErrorDirection(equations, observations, {errors.first, errors.second});
  for (T& value : right) value = -value;
  return stereo::LeastSquares(equations.row, right);
}

void Perturb(const StationErrors& e, Station<long double>* station) {
  station->antenna[0] += static_cast<long double>(e.dx0_m);
  station->antenna[1] += static_cast<long double>(e.dy0_m);
  station->antenna[2] += static_cast<long double>(e.dz0_m);
  station->range += static_cast<long double>(e.dr_m) + e.range_scale * station->range;
  const Vector<long double> direction{1.0L, e.dydot0, e.dzdot0};
  const long double length = stereo::Norm(direction);
  for (std::size_t i = 0; i < 3; ++i) station->axis[i] = direction[i] / length;
}

/// Across-track orientation of the two lines of sight: its sign distinguishes the two
/// intersections.
long double Orientation(const stereo::Equations<long double>& e) {
  return e.row[0][1] * e.row[1][2] - e.row[0][2] * e.row[1][1];
}

PointError ToPointError(long double dx, long double dy, long double dz) {
  return {static_cast<double>(dx), static_cast<double>(dy), static_cast<double>(dz)};
}

/// First order in one direction: a component below 1e-14 of the largest is rounding of a zero.
PointError WithoutRounding(long double dx, long double dy, long double dz) {
  const long double floor = 1e-14L * std::max({std::abs(dx), std::abs(dy), std::abs(dz)});
  const auto clean = [floor](long double value) { return std::abs(value) < floor ? 0.0L : value; };
  return ToPointError(clean(dx), clean(dy), clean(dz));
}

/// Range r(h) of the point (offset, h) and its image coordinate, with the derivative by h.
struct ImageCoordinate {
  long double value_m = 0.0L;
  long double slope = 0.0L;
};
std::optional<ImageCoordinate> ImageOf(long double offset_m,
                                       long double flying_height_m,
                                       long double height_m,
                                       leberl::Presentation presentation) {
  const long double below_m = flying_height_m - height_m;
  const long double range_m = std::hypot(offset_m, below_m);
  if (presentation == leberl::Presentation::kSlantRange) {
    return ImageCoordinate{range_m, -below_m / range_m};
  }
  const long double square_m2 = range_m * range_m - flying_height_m * flying_height_m;
  if (!(square_m2 > 0.0L)) return std::nullopt;
  return ImageCoordinate{std::sqrt(square_m2), -below_m / std::sqrt(square_m2)};
}

/// Parallax difference and its derivative by h.
std::optional<ImageCoordinate> Parallax(const StereoConfiguration& c,
                                        long double height_m,
                                        leberl::Presentation presentation) {
  const long double sign = c.arrangement == leberl::Arrangement::kSameSide ? -1.0L : 1.0L;
  const long double offsets[] = {
      static_cast<long double>(c.ground_range_m),
      static_cast<long double>(c.ground_range_m) - static_cast<long double>(c.base_m)};
  ImageCoordinate sum;
  for (int k = 0; k < 2; ++k) {
    const auto datum = ImageOf(offsets[k], c.height_m, 0.0L, presentation);
    const auto raised = ImageOf(offsets[k], c.height_m, height_m, presentation);
    if (!datum || !raised) return std::nullopt;
    const long double factor = k == 0 ? sign : 1.0L;
    sum.value_m += factor * (datum->value_m - raised->value_m);
    sum.slope -= factor * raised->slope;
  }
  return sum;
}

}  // namespace

PointError StereoErrorDerivative(const StereoConfiguration& c,
                                 const StereoErrors& errors,
                                 double terrain_height_m) {
  const Vector<long double> p{0.0L, c.ground_range_m, terrain_height_m};
  const Vector<long double> dp = Derivative(c, errors, p);
  return WithoutRounding(dp[0], dp[1], dp[2]);
}

std::optional<PointError> StereoErrorExact(const StereoConfiguration& c,
                                           const StereoErrors& errors,
                                           double terrain_height_m) {
  const Vector<long double> truth{0.0L, c.ground_range_m, terrain_height_m};
  std::array<Station<long double>, 2> stations = TrueStations(c, truth);
  const long double orientation = Orientation(stereo::Evaluate(truth, stations));
  Perturb(errors.first, &stations[0]);
  Perturb(errors.second, &stations[1]);

  // Gauss-Newton from the truth: the residual is at most the disagreement of the two planes, small
  // against the ranges, so convergence is nearly quadratic. A gap between the circles shows in a
  // step that does not shrink or in the orientation lost.
  constexpr int kMaxIterations = 100;
  constexpr long double kStep = 1e-15L;  // of the range: far below 1e-9 of any error worth asking
  Vector<long double> p = truth;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const auto equations = stereo::Evaluate(p, stations);
    std::array<long double, 4> right{};
    for (std::size_t k = 0; k < 4; ++k) right[k] = -equations.error[k];
    const Vector<long double> step = stereo::LeastSquares(equations.row, right);
    for (std::size_t i = 0; i < 3; ++i) p[i] += step[i];
    const long double length = stereo::Norm(step);
    if (!std::isfinite(length)) return std::nullopt;
    if (length > kStep * stations[0].range) continue;
    const auto solved = stereo::Evaluate(p, stations);
    if (!(Orientation(solved) * orientation > 0.0L)) return std::nullopt;
    return ToPointError(p[0] - truth[0], p[1] - truth[1], p[2] - truth[2]);
  }
  return std::nullopt;
}

PointError DifferenceErrorDerivative(const StereoConfiguration& c,
                                     const StereoErrors& errors,
                                     const leberl::Difference& difference) {
  const Vector<Dual> p{
      Dual{0.0L, 0.0L}, Dual{c.ground_range_m, difference.dy_m}, Dual{0.0L, difference.dz_m}};
  const Vector<Dual> dp = Derivative(c, errors, p);
  return WithoutRounding(dp[0].slope, dp[1].slope, dp[2].slope);
}

std::optional<PointError> DifferenceErrorExact(const StereoConfiguration& c,
                                               const StereoErrors& errors,
                                               const leberl::Difference& difference) {
  StereoConfiguration moved = c;
  moved.ground_range_m += difference.dy_m;
  const auto here = StereoErrorExact(c, errors);
  const auto there = StereoErrorExact(moved, errors, difference.dz_m);
  if (!here || !there) return std::nullopt;
  return PointError{there->dx_m - here->dx_m, there->dy_m - here->dy_m, there->dz_m - here->dz_m};
}

leberl::RangeNoise StereoRangeNoise(const StereoConfiguration& c, double range_sigma_m) {
  // The looks go to the intersection as an observer has them: antennas, directions, ranges. Each
  // looks to the side of its flight direction (+x) on which the point lies.
  const Eigen::Vector3d point_m(0.0, c.ground_range_m, 0.0);
  std::array<FixedPathLook, 2> observations;
  for (std::size_t k = 0; k < 2; ++k) {
    FixedPathLook& observation = observations[k];
    observation.antenna_m = Eigen::Vector3d(0.0, k == 0 ? 0.0 : c.base_m, c.height_m);
    observation.velocity_mps = Eigen::Vector3d(1.0, 0.0, 0.0);
    observation.range_m = (point_m - observation.antenna_m).norm();
    observation.side = point_m.y() > observation.antenna_m.y() ? +1 : -1;
    observation.range_sigma_m = range_sigma_m;
    observation.azimuth_sigma = range_sigma_m;
  }
  const Intersection found = Intersect(observations, Frame::Local());
  if (found.outcome != IntersectionOutcome::kDetermined) {
    throw UndeterminedError("the stereo pair does not determine the point",
                            {NameOf(found.outcome)});
  }
  return {std::sqrt(found.covariance_m2(1, 1)), std::sqrt(found.covariance_m2(2, 2))};
}

std::optional<double> ExactParallaxFromHeight(const StereoConfiguration& c,
                                              double height_m,
                                              leberl::Presentation presentation) {
  const auto parallax = Parallax(c, height_m, presentation);
  if (!parallax) return std::nullopt;
  return static_cast<double>(parallax->value_m);
}

std::optional<double> ExactHeightFromParallax(const StereoConfiguration& c,
                                              double parallax_m,
                                              leberl::Presentation presentation) {
  constexpr int kMaxIterations = 60;
  long double height_m = 0.0L;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const auto parallax = Parallax(c, height_m, presentation);
    if (!parallax) return std::nullopt;
    const long double step_m =
        (static_cast<long double>(parallax_m) - parallax->value_m) / parallax->slope;
    height_m += step_m;
    if (!std::isfinite(height_m)) return std::nullopt;
    if (std::abs(step_m) <= 1e-15L * static_cast<long double>(c.height_m)) {
      return static_cast<double>(height_m);
    }
  }
  return std::nullopt;
}

namespace {

constexpr double kRankTolerance = 1e-10;  // rows have length near 1; rounding is 1e-15

void Validate(const SingleFlightPair& pair) {
  if (!(std::isfinite(pair.height_m) && pair.height_m > 0.0)) {
    throw InputError("height_m", fmt::format("{} is given, > 0 is allowed", pair.height_m));
  }
  if (!std::isfinite(pair.ground_range_m) || pair.ground_range_m == 0.0) {
    throw InputError("ground_range_m", "the point must not lie below the flight line");
  }
  for (const double squint_rad : {pair.first_squint_rad, pair.second_squint_rad}) {
    if (!(std::abs(squint_rad) < 0.5 * std::numbers::pi)) {
      throw InputError("squint_rad",
                       fmt::format("{} is given, (-pi/2, pi/2) is allowed", squint_rad));
    }
  }
  if (pair.first_squint_rad == pair.second_squint_rad) {
    throw InputError("second_squint_rad", "both looks have the same squint: it is one look");
  }
}

}  // namespace

SingleFlightProof ProveSingleFlight(const SingleFlightPair& pair) {
  Validate(pair);
  const Eigen::Vector3d velocity_mps(1.0, 0.0, 0.0);
  const Eigen::Vector3d point_m(0.0, pair.ground_range_m, 0.0);
  const double radius_m = std::hypot(pair.ground_range_m, pair.height_m);
  std::array<FixedPathLook, 2> observations;
  Eigen::Matrix<double, 4, 3> jacobian;
  std::array<double, 2> plane_m{}, circle_m{};
  for (std::size_t k = 0; k < 2; ++k) {
    const double squint_rad = k == 0 ? pair.first_squint_rad : pair.second_squint_rad;
    FixedPathLook& observation = observations[k];
    observation.antenna_m = Eigen::Vector3d(-radius_m * std::tan(squint_rad), 0.0, pair.height_m);
    observation.velocity_mps = velocity_mps;
    observation.range_m = (point_m - observation.antenna_m).norm();
    observation.cone.squint_rad = squint_rad;
    observation.side = pair.ground_range_m > 0.0 ? +1 : -1;
    plane_m[k] = observation.antenna_m.x() + observation.range_m * std::sin(squint_rad);
    circle_m[k] = observation.range_m * std::cos(squint_rad);
    LookEquations equations;
    if (!EvaluateLookEquations(
            point_m, observation.antenna_m, velocity_mps, observation.cone, 0.0, &equations)) {
      throw InputError("squint_rad", "the look equations have no value for this squint");
    }
    const auto row = static_cast<Eigen::Index>(2 * k);
    jacobian.row(row) = equations.drho_dp;
    jacobian.row(row + 1) = equations.ded_dp;
  }
  SingleFlightProof proof;
  const Eigen::Vector3d singular = dense::DecomposeSingular(jacobian).values;
  for (int i = 0; i < 3; ++i) {
    proof.singular[i] = singular(i);
    if (singular(i) > kRankTolerance) ++proof.rank;
  }
  proof.plane_gap_m = std::abs(plane_m[0] - plane_m[1]);
  proof.radius_gap_m = std::abs(circle_m[0] - circle_m[1]);
  proof.outcome = Intersect(observations, Frame::Local()).outcome;
  proof.reason = fmt::format(
      "both looks confine the point to the same circle of radius {:.6g} m normal to the flight "
      "line: {} of 3 coordinates are determined, there is no parallax from one flight line",
      circle_m[0],
      proof.rank);
  return proof;
}

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
