// SPDX-License-Identifier: Apache-2.0
#include "cone_time.h"

namespace sarblock {

ConeValue EvaluateCone(const Motion& motion, const Eigen::Vector3d& p_m, const Cone& cone) {
  const Eigen::Vector3d sight_m = p_m - motion.position_m;
  const double speed_mps = motion.velocity_mps.norm();
  const double sin_tau = cone.Sine(speed_mps);
  return {motion.velocity_mps.dot(sight_m) / speed_mps - sight_m.norm() * sin_tau,
          LookTimeRates(p_m, motion.position_m, motion.velocity_mps, motion.acceleration_mps2, cone)
              .doppler_mps};
}

std::optional<double> FindConeTime(const FlightPath& path,
                                   const Eigen::Vector3d& p_m,
                                   const Cone& cone,
                                   double start_s,
                                   double end_s) {
  const std::optional<Motion> first = path.At(start_s);
  const std::optional<Motion> last = path.At(end_s);
  if (!first || !last) return std::nullopt;
  const double at_start_m = EvaluateCone(*first, p_m, cone).doppler_error_m;
  const double at_end_m = EvaluateCone(*last, p_m, cone).doppler_error_m;
  if (!(at_start_m >= 0.0 && at_end_m <= 0.0)) return std::nullopt;  // it falls along the path
  double low_s = start_s;
  double high_s = end_s;
  double time_s = start_s;
  if (at_start_m > at_end_m) time_s += (end_s - start_s) * at_start_m / (at_start_m - at_end_m);
  for (int iteration = 0; iteration < 100; ++iteration) {
    const std::optional<Motion> motion = path.At(time_s);
    if (!motion) return std::nullopt;
    const ConeValue at = EvaluateCone(*motion, p_m, cone);
    if (std::abs(at.doppler_error_m) < 1e-7) return time_s;
    (at.doppler_error_m > 0.0 ? low_s : high_s) = time_s;
    double next_s = time_s - at.doppler_error_m / at.rate_mps;
    if (!(at.rate_mps < 0.0) || !(next_s > low_s && next_s < high_s)) {
      next_s = 0.5 * (low_s + high_s);
    }
    if (next_s == time_s) return time_s;
    time_s = next_s;
  }
  return std::nullopt;
}

}  // namespace sarblock
