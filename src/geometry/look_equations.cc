// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/look_equations.h"

#include <cmath>

#include "look_equations_inline.h"

namespace sarblock {

bool EvaluateLookEquations(const Eigen::Vector3d& p_m,
                           const Eigen::Vector3d& s_m,
                           const Eigen::Vector3d& v_mps,
                           const Cone& cone,
                           double squint_bias_rad,
                           LookEquations* out) {
  return EvaluateLookEquationsInline(p_m - s_m, v_mps, cone, squint_bias_rad, out);
}

TimeRates LookTimeRates(const Eigen::Vector3d& p_m,
                        const Eigen::Vector3d& s_m,
                        const Eigen::Vector3d& v_mps,
                        const Eigen::Vector3d& acceleration_mps2,
                        const Cone& cone) {
  const Eigen::Vector3d d = p_m - s_m;
  const double rho = d.norm(), speed = v_mps.norm();
  const Eigen::Vector3d u = v_mps / speed;
  const double speed_rate = u.dot(acceleration_mps2);
  const Eigen::Vector3d u_rate = (acceleration_mps2 - speed_rate * u) / speed;
  const SinTau tau = SinTauOf(cone, speed);
  const double rho_rate = -v_mps.dot(d) / rho;
  const double doppler_rate =
      u_rate.dot(d) - speed - rho_rate * tau.value_1 - rho * tau.dsin_dspeed * speed_rate;
  return {rho_rate, doppler_rate};
}

Whitening WhitenTime(double range_sigma_m, double time_sigma_s, const TimeRates& rates) {
  // Lower Cholesky factor [[l00, 0], [l10, l11]] of the covariance, written so that nothing
  // cancels: l11 = |d| sigma_t sigma_R / l00.
  const double r = rates.range_mps * time_sigma_s, d = rates.doppler_mps * time_sigma_s;
  const double l00 = std::sqrt(range_sigma_m * range_sigma_m + r * r);
  const double l10 = r * d / l00;
  const double l11 = std::abs(d) * (range_sigma_m / l00);
  Whitening w;
  w.w00 = 1.0 / l00;
  w.w11 = 1.0 / l11;
  w.w10 = -l10 * w.w00 * w.w11;
  return w;
}

Whitening WhitenAzimuth(double range_sigma_m, double azimuth_sigma_m, const TimeRates& rates) {
  return WhitenTime(range_sigma_m, azimuth_sigma_m / std::abs(rates.doppler_mps), rates);
}

Whitening WhitenDoppler(double range_sigma_m, double azimuth_sigma_m) {
  return {1.0 / range_sigma_m, 0.0, 1.0 / azimuth_sigma_m};
}

}  // namespace sarblock
