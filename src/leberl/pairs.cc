// SPDX-License-Identifier: Apache-2.0
#include "pairs.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace sarblock {
namespace {

using Eigen::Vector3d;
using leberl::Arrangement;

constexpr double kRightAngle_rad = 0.5 * std::numbers::pi;

/// The two looks at the point in the origin; x along the tracks, y across, z up there. The first
/// antenna is at negative y. |v| is 1 m/s: a standard deviation in metres at the target does not
/// depend on it.
std::optional<std::array<FixedPathLook, 2>> LooksOf(const StereoPair& pair) {
  std::array<FixedPathLook, 2> looks;
  for (std::size_t k = 0; k < 2; ++k) {
    const bool opposite = k == 1 && pair.arrangement == Arrangement::kOppositeSide;
    const double incidence_rad =
        IncidenceAngle(pair.look_rad[k], pair.height_m, pair.body_radius_m);
    const double range_m = SlantRange(pair.look_rad[k], pair.height_m, pair.body_radius_m);
    if (!std::isfinite(incidence_rad)) return std::nullopt;
    FixedPathLook& look = looks[k];
    look.antenna_m =
        range_m *
        Vector3d(0.0, (opposite ? 1.0 : -1.0) * std::sin(incidence_rad), std::cos(incidence_rad));
    look.velocity_mps = Vector3d::UnitX();
    if (std::isfinite(pair.body_radius_m)) {  // a circle about the centre
      const Vector3d from_centre_m = look.antenna_m + Vector3d(0.0, 0.0, pair.body_radius_m);
      look.acceleration_mps2 = -from_centre_m / from_centre_m.squaredNorm();
    }
    look.range_m = range_m;
    look.side = opposite ? -1 : +1;
  }
  return looks;
}

std::optional<PointSigmas> SigmasWith(std::array<FixedPathLook, 2> looks,
                                      const PairSigmas& sigmas) {
  for (std::size_t k = 0; k < looks.size(); ++k) {
    FixedPathLook& look = looks[k];
    const double along_part =
        LookTimeRates(
            Vector3d::Zero(), look.antenna_m, look.velocity_mps, look.acceleration_mps2, look.cone)
            .along_mps;
    look.range_sigma_m = std::hypot(sigmas.range_m[k], sigmas.path_m);
    look.azimuth_sigma = std::hypot(sigmas.azimuth_m[k], along_part * sigmas.path_m);
  }
  return SigmasOf(looks, Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ());
}

constexpr double kNadir_rad = 1e-3;

/// The widest look that sees the body.
double LastLook_rad(const StereoPair& pair) {
  const double horizon_rad =
      std::isinf(pair.body_radius_m)
          ? kRightAngle_rad
          : std::asin(pair.body_radius_m / (pair.body_radius_m + pair.height_m));
  constexpr double kAlmost = 1.0 - 1e-6;
  return horizon_rad * kAlmost;
}

}  // namespace

double IncidenceAngle(double look_rad, double height_m, double body_radius_m) {
  if (std::isinf(body_radius_m)) return look_rad;
  const double sine = (body_radius_m + height_m) / body_radius_m * std::sin(look_rad);
  return sine < 1.0 ? std::asin(sine) : std::numeric_limits<double>::quiet_NaN();
}

double SlantRange(double look_rad, double height_m, double body_radius_m) {
  if (std::isinf(body_radius_m)) return height_m / std::cos(look_rad);
  const double incidence_rad = IncidenceAngle(look_rad, height_m, body_radius_m);
  const double centre_rad = incidence_rad - look_rad;
  // Near nadir the quotient of the law of sines is 0/0; this form of it is not.
  return (body_radius_m + height_m) * std::cos(look_rad) -
         body_radius_m * std::cos(look_rad + centre_rad);
}

std::optional<PointSigmas> SigmasOf(std::span<const FixedPathLook> observations,
                                    const Vector3d& along,
                                    const Vector3d& across,
                                    const Vector3d& up) {
  const Intersection found = Intersect(observations, Frame::Local());
  if (found.outcome != IntersectionOutcome::kDetermined) return std::nullopt;
  const auto sigma = [&](const Vector3d& axis) {
    return std::sqrt(axis.dot(found.covariance_m2 * axis));
  };
  return PointSigmas{sigma(along), sigma(across), sigma(up)};
}

std::optional<PairAccuracy> AccuracyOf(const StereoPair& pair, const PairSigmas& sigmas) {
  const auto looks = LooksOf(pair);
  if (!looks) return std::nullopt;
  PairAccuracy accuracy;
  accuracy.intersection_rad = IntersectionAngle(Vector3d::Zero(), (*looks)[0], (*looks)[1]);
  for (std::size_t k = 0; k < 2; ++k) {
    accuracy.incidence_rad[k] = IncidenceAngle(pair.look_rad[k], pair.height_m, pair.body_radius_m);
    accuracy.range_m[k] = (*looks)[k].range_m;
  }
  PairSigmas measured = sigmas;
  measured.path_m = 0.0;
  const auto by_looks = SigmasWith(*looks, measured), all = SigmasWith(*looks, sigmas);
  if (!by_looks || !all) return std::nullopt;
  accuracy.measured = *by_looks;
  accuracy.all = *all;
  if (sigmas.path_m > 0.0) {
    const auto paths = SigmasWith(*looks, {{}, {}, sigmas.path_m});
    if (!paths) return std::nullopt;
    accuracy.paths = *paths;
  }
  return accuracy;
}

SlopeLimits SlopesShown(const std::array<double, 2>& incidence_rad, Arrangement arrangement) {
  const auto [first, second] = incidence_rad;
  const bool same = arrangement == Arrangement::kSameSide;
  // The second antenna lays over what faces it: for opposite sides, what faces away from the first.
  return {std::min(first, same ? second : kRightAngle_rad - second),
          std::min(kRightAngle_rad - first, same ? kRightAngle_rad - second : second)};
}

SecondLooks SecondLooksFor(const StereoPair& pair, const PairSigmas& sigmas, double sigma_up_m) {
  const auto reaches = [&](double second_rad) {
    StereoPair trial = pair;
    trial.look_rad[1] = second_rad;
    const auto accuracy = AccuracyOf(trial, sigmas);
    return accuracy && accuracy->all.up_m <= sigma_up_m;
  };
  // The height gets better from the first look to `end`, which reaches the goal.
  const auto edge = [&](double start_rad, double end_rad) -> std::optional<double> {
    if (!reaches(end_rad)) return std::nullopt;
    double misses = start_rad, meets = end_rad;
    for (int step = 0; step < 60; ++step) {
      const double middle = 0.5 * (misses + meets);
      (reaches(middle) ? meets : misses) = middle;
    }
    return meets;
  };
  return {edge(pair.look_rad[0], kNadir_rad), edge(pair.look_rad[0], LastLook_rad(pair))};
}

std::optional<BestLook> BestSecondLook(
    const StereoPair& pair, const std::function<PairSigmas(const StereoPair&)>& sigmas_of) {
  constexpr int kSteps = 900;
  const double last_rad = LastLook_rad(pair);
  std::optional<BestLook> best;
  for (int step = 0; step <= kSteps; ++step) {
    StereoPair trial = pair;
    trial.look_rad[1] = kNadir_rad + (last_rad - kNadir_rad) * step / kSteps;
    const auto accuracy = AccuracyOf(trial, sigmas_of(trial));
    if (!accuracy || (best && accuracy->all.up_m >= best->sigma_up_m)) continue;
    best = BestLook{trial.look_rad[1], accuracy->all.up_m};
  }
  return best;
}

namespace {

using Eigen::Vector3d;
using leberl::Arrangement;
using leberl::StereoConfiguration;

constexpr double kConvergentSquint_rad = 20.0 * kRadPerDeg;
constexpr double kSingleSquint_rad = 15.0 * kRadPerDeg;
constexpr double kLowRatio = 0.6, kHighRatio = 1.2;  // heights of flight over H
constexpr double kOrbitHeight_m = 700e3;
constexpr double kOrbitLook_rad = 45.0 * kRadPerDeg;
constexpr double kApolloHeight_m = 116e3;

/// A straight flight: its point closest to the target, and its direction.
struct Line {
  Vector3d closest_m = Vector3d::Zero();
  Vector3d track = Vector3d::UnitX();  ///< unit vector
};

/// The look of a straight flight, squinted, at the point.
FixedPathLook LookFrom(const Line& line, double squint_rad, const Vector3d& point_m) {
  FixedPathLook look;
  const Vector3d across_m = point_m - line.closest_m;
  look.antenna_m = line.closest_m - across_m.norm() * std::tan(squint_rad) * line.track;
  look.velocity_mps = line.track;
  look.cone.squint_rad = squint_rad;
  look.side = Vector3d::UnitZ().cross(line.track).dot(across_m) > 0.0 ? +1 : -1;
  return look;
}

/// The look of a circular orbit about the body's centre, in the plane y = 0 of the frame whose
/// origin is `radius_m` below the orbit's highest point, at the point (0, y, z) of that frame.
FixedPathLook LookFromOrbit(double radius_m, double squint_rad, const Vector3d& point_m) {
  const Vector3d centre_m(0.0, 0.0, -radius_m);
  const Vector3d from_centre_m = point_m - centre_m;
  const double sine = std::sin(squint_rad);
  // u.d = sin(tau) |d| with u = (cos a, 0, -sin a), d = p - s: by symmetry u.d = -z' sin(a)
  const auto at = [&](double angle_rad) {
    return Vector3d(radius_m * std::sin(angle_rad), 0.0, radius_m * std::cos(angle_rad) - radius_m);
  };
  double angle_rad = 0.0;
  for (int i = 0; i < 100; ++i) {  // -z' sin(a) = sin(tau) |d(a)|: a contraction for short ranges
    const double next = std::asin(-sine * (point_m - at(angle_rad)).norm() / from_centre_m.z());
    if (next == angle_rad) break;
    angle_rad = next;
  }
  FixedPathLook look;
  look.antenna_m = at(angle_rad);
  look.velocity_mps = Vector3d(std::cos(angle_rad), 0.0, -std::sin(angle_rad));
  look.acceleration_mps2 = (centre_m - look.antenna_m) / (radius_m * radius_m);  // |v| = 1 m/s
  look.cone.squint_rad = squint_rad;
  look.side = point_m.y() > 0.0 ? +1 : -1;
  return look;
}

/// Look angle off nadir in the plane normal to the track.
double LookAngle(const FixedPathLook& look, const Vector3d& point_m) {
  const Vector3d along = look.velocity_mps.normalized();
  Vector3d sight_m = point_m - look.antenna_m;
  sight_m -= sight_m.dot(along) * along;
  return std::acos(-sight_m.z() / sight_m.norm());
}

/// Both looks fly along x at their closest approach, but the second of the cross-wise pair. `up` is
/// the vertical at the point.
FigureRow RowOf(std::string figure,
                std::string name,
                const Vector3d& point_m,
                const Vector3d& up,
                std::array<FixedPathLook, 2> looks,
                const FigureOptions& options) {
  FigureRow row;
  row.figure = std::move(figure);
  row.name = std::move(name);
  for (FixedPathLook& look : looks) {
    look.range_m = (point_m - look.antenna_m).norm();
    look.range_sigma_m = options.sigma_range_m;
    look.azimuth_sigma = options.sigma_azimuth_m;
  }
  if (looks[1].velocity_mps.y() == 0.0) {
    row.base_m = std::abs(looks[1].antenna_m.y() - looks[0].antenna_m.y());
  }
  row.first_look_rad = LookAngle(looks[0], point_m);
  row.second_look_rad = LookAngle(looks[1], point_m);
  row.intersection_rad = IntersectionAngle(point_m, looks[0], looks[1]);
  row.outcome = Intersect(looks, Frame::Local()).outcome;
  row.sigmas = SigmasOf(looks, Vector3d::UnitX(), up.cross(Vector3d::UnitX()), up);
  return row;
}

/// Eq. 10 for a pair on parallel lines.
void AddExaggeration(Arrangement arrangement, FigureRow* row) {
  row->exaggeration =
      leberl::ExaggerationFromAngles(row->first_look_rad, row->second_look_rad, arrangement);
}

void CheckFigures(const FigureOptions& options) {
  Validate(options.ground);
  if (options.ground.arrangement != Arrangement::kSameSide) {
    throw InputError("ground", "B, H and y of the same-side pair are allowed");
  }
  for (const auto& [name, value] : {std::pair{"sigma_range_m", options.sigma_range_m},
                                    std::pair{"sigma_azimuth_m", options.sigma_azimuth_m}}) {
    if (!(std::isfinite(value) && value > 0.0)) {
      throw InputError(name, fmt::format("{} is given, > 0 is allowed", value));
    }
  }
}

}  // namespace

std::vector<FigureRow> PaperFigures(const FigureOptions& options) {
  CheckFigures(options);
  const double base_m = options.ground.base_m, height_m = options.ground.height_m;
  const double y_m = options.ground.ground_range_m;
  const Vector3d point_m(0.0, y_m, 0.0);
  const Line first{.closest_m = {0.0, 0.0, height_m}};
  const Line second{.closest_m = {0.0, base_m, height_m}};
  const auto straight = [&](const Line& line) { return LookFrom(line, 0.0, point_m); };
  std::vector<FigureRow> rows;
  const auto add = [&](const char* figure,
                       const char* name,
                       const FixedPathLook& one,
                       const FixedPathLook& other) -> FigureRow* {
    return &rows.emplace_back(
        RowOf(figure, name, point_m, Vector3d::UnitZ(), {one, other}, options));
  };

  AddExaggeration(Arrangement::kSameSide,
                  add("3, 4", "same side", straight(first), straight(second)));
  const Line opposite{.closest_m = {0.0, y_m + (y_m - base_m), height_m}};
  AddExaggeration(Arrangement::kOppositeSide,
                  add("3, 4", "opposite side", straight(first), straight(opposite)));
  const Line across{.closest_m = {-y_m, y_m, height_m}, .track = Vector3d::UnitY()};
  add("3, 4", "cross-wise", straight(first), straight(across));
  const Line low{.closest_m = {0.0, 0.0, kLowRatio * height_m}};
  const Line high{.closest_m = {0.0, 0.0, kHighRatio * height_m}};
  AddExaggeration(Arrangement::kSameSide,
                  add("3, 4", "two heights", straight(low), straight(high)));
  AddExaggeration(Arrangement::kSameSide,
                  add("3, 4",
                      "convergent",
                      LookFrom(first, kConvergentSquint_rad, point_m),
                      LookFrom(second, -kConvergentSquint_rad, point_m)));
  add("5",
      "single flight",
      LookFrom(first, kSingleSquint_rad, point_m),
      LookFrom(first, -kSingleSquint_rad, point_m));

  // The orbit's point: where the look at 45 degrees meets the sphere, in a frame below the orbit.
  const double earth_m = NamedEllipsoid("WGS84").a_m, radius_m = earth_m + kOrbitHeight_m;
  const double foot_m = radius_m * std::cos(kOrbitLook_rad);
  const double range_m =
      foot_m - std::sqrt(foot_m * foot_m - (radius_m + earth_m) * kOrbitHeight_m);
  const Vector3d below_m(
      0.0, range_m * std::sin(kOrbitLook_rad), -range_m * std::cos(kOrbitLook_rad));
  rows.push_back(RowOf("5",
                       "single orbit",
                       below_m,
                       (below_m + Vector3d(0.0, 0.0, radius_m)).normalized(),
                       {LookFromOrbit(radius_m, kSingleSquint_rad, below_m),
                        LookFromOrbit(radius_m, -kSingleSquint_rad, below_m)},
                       options));

  for (const auto& [apollo_base_m, look_deg] :
       {std::pair{3e3, 14.0}, std::pair{3e3, 20.0}, std::pair{13e3, 17.0}}) {
    const double far_m = kApolloHeight_m * std::tan(look_deg * kRadPerDeg) + 0.5 * apollo_base_m;
    const Vector3d moon_m(0.0, far_m, 0.0);
    const Line inner{.closest_m = {0.0, apollo_base_m, kApolloHeight_m}};
    const Line outer{.closest_m = {0.0, 0.0, kApolloHeight_m}};
    rows.push_back(RowOf("8, 9",
                         fmt::format("Apollo radar, {:.0f} deg", look_deg),
                         moon_m,
                         Vector3d::UnitZ(),
                         {LookFrom(outer, 0.0, moon_m), LookFrom(inner, 0.0, moon_m)},
                         options));
    AddExaggeration(Arrangement::kSameSide, &rows.back());
  }
  return rows;
}

}  // namespace sarblock
