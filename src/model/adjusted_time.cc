// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "look_model.h"

namespace sarblock {
namespace {

/// Nearer than this to an end of the path, in standard deviations of the time, the measured time
/// stays: a time bias may still move, and beyond the end there is no path.
constexpr double kEnd_sigmas = 10.0;

/// Up to this many standard deviations of the time the jerk does not count.
constexpr double kMoment_sigmas = 1e-2;

/// A rate in single precision; the former one where it would only be rounded the other way, so that
/// a state that stands has rates that stand.
float Settled(double rate_mps, float before_mps) {
  const double change_mps = std::abs(rate_mps - static_cast<double>(before_mps));
  constexpr double kRounding_1 = 1.0 / (1 << 23);
  return change_mps <= kRounding_1 * std::abs(rate_mps) ? before_mps : static_cast<float>(rate_mps);
}

/// A motion a moment later.
Motion Later(const Motion& motion, double by_s) {
  Motion out = motion;
  out.position_m += by_s * (motion.velocity_mps + (0.5 * by_s) * motion.acceleration_mps2);
  out.velocity_mps += by_s * motion.acceleration_mps2;
  return out;
}

}  // namespace

std::optional<LookLinearisation> LookModel::Linearise(std::size_t look,
                                                      const Eigen::Vector3d& start_m,
                                                      const Eigen::Vector3d& displacement_m,
                                                      const Eigen::VectorXd& x) const {
  const std::size_t pass = block_.looks.pass[look];
  const double measured_s = block_.looks.time_s[look];
  LookColumns columns;
  ColumnsOf(look, &columns);
  std::array<double, ParameterLayout::kMaxLocalColumns> local;
  GatherColumns(layout_, columns, x, local.data());
  double path_s = measured_s;
  for (const int column : layout_.passes[pass].time_bias) {
    path_s += local[static_cast<std::size_t>(column)];
  }
  const AdjustedTime before = TimeOf(look);
  auto corrected = CorrectedMotionAtPathTime(pass, measured_s, path_s + before.shift_s, x);
  constexpr Whitening kMetres{1.0, 0.0, 1.0};
  Eigen::Vector2d error_m;
  Eigen::Matrix<double, 2, 3> by_point;
  if (!corrected ||
      !Evaluate(look, columns, start_m, displacement_m, local, kMetres, &error_m, &by_point, {})) {
    return std::nullopt;
  }
  const Eigen::Vector3d p_m = start_m + displacement_m;
  const Cone cone = ConeOf(look);
  const auto rates_of = [&](const Motion& motion) {
    return LookTimeRates(
        p_m, motion.position_m, motion.velocity_mps, motion.acceleration_mps2, cone);
  };
  const LookSigma sigma = SigmaOf(look);
  TimeRates rates = rates_of(corrected->motion);
  const double sigma_s = sigma.azimuth_unit == AzimuthUnit::kSeconds
                             ? sigma.azimuth
                             : sigma.azimuth / std::abs(rates.doppler_mps);
  // One Newton step on the cone: error_m has the former shift taken out.
  double shift_s = before.shift_s - (error_m[1] + before.doppler_m()) / rates.doppler_mps;
  const FlightPath& path = PathOf(pass);
  const double first_s = path.start_s() + kEnd_sigmas * sigma_s;
  const double last_s = path.end_s() - kEnd_sigmas * sigma_s;
  if (!(path_s >= first_s && path_s <= last_s && path_s + shift_s >= first_s &&
        path_s + shift_s <= last_s)) {
    shift_s = 0.0;
  }
  shift_s = (measured_s + shift_s) - measured_s;  // as times far from zero are rounded
  const double by_s = shift_s - before.shift_s;
  LookLinearisation out;
  out.moved_1 = std::abs(by_s) / sigma_s;
  if (out.moved_1 > kMoment_sigmas) {
    corrected = CorrectedMotionAtPathTime(pass, measured_s, path_s + shift_s, x);
    if (!corrected) return std::nullopt;
    rates = rates_of(corrected->motion);
  } else {
    rates = rates_of(Later(corrected->motion, by_s));
  }
  out.whitening = sigma.azimuth_unit == AzimuthUnit::kSeconds
                      ? WhitenTime(sigma.range_m, sigma.azimuth, rates)
                      : WhitenAzimuth(sigma.range_m, sigma.azimuth, rates);
  out.time = {shift_s,
              Settled(rates.range_mps, before.range_mps),
              Settled(rates.doppler_mps, before.doppler_mps)};
  return out;
}

}  // namespace sarblock
