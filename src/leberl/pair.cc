// SPDX-License-Identifier: Apache-2.0
#include "pair.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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

}  // namespace sarblock
