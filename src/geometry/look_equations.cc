// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/look_equations.h"

#include <cmath>

namespace sarblock {
namespace {

constexpr double kLeastRange_m = 1e-3;

/// sin(tau) without the squint bias, and its derivative by |v| (Doppler input only).
struct SinTau {
  double value;
  double by_speed;
};

SinTau SinTauOf(const Cone& cone, double speed_mps) {
  if (cone.kind == Cone::Kind::kSquint) {
    return {cone.squint_rad == 0.0 ? 0.0 : std::sin(cone.squint_rad), 0.0};
  }
  const double s = cone.closing_mps / speed_mps;
  return {s, -s / speed_mps};
}

}  // namespace

bool EvaluateLookEquations(const Eigen::Vector3d& p_m,
                           const Eigen::Vector3d& s_m,
                           const Eigen::Vector3d& v_mps,
                           const Cone& cone,
                           double squint_bias_rad,
                           LookEquations* out) {
  const Eigen::Vector3d d = p_m - s_m;
  const double rho = d.norm();
  const double speed = v_mps.norm();
  // Written so that NaN fails too.
  if (!(rho >= kLeastRange_m) || !(speed > 0.0) || !std::isfinite(rho) || !std::isfinite(speed)) {
    return false;
  }
  const SinTau given = SinTauOf(cone, speed);
  if (!(std::abs(given.value) < 1.0)) return false;

  // sin(tau + b) and its derivatives by b and by |v|.
  const double cos_given = std::sqrt((1.0 - given.value) * (1.0 + given.value));
  const bool biased = squint_bias_rad != 0.0;  // most blocks have none: spare the sine
  const double sin_b = biased ? std::sin(squint_bias_rad) : 0.0;
  const double cos_b = biased ? std::cos(squint_bias_rad) : 1.0;
  const double sin_tau = given.value * cos_b + cos_given * sin_b;
  const double cos_tau = cos_given * cos_b - given.value * sin_b;
  const double by_speed = given.by_speed == 0.0 ? 0.0 : given.by_speed * cos_tau / cos_given;

  const double per_speed = 1.0 / speed;  // one division, not one a component
  const Eigen::Vector3d u = v_mps * per_speed;
  const double along = u.dot(d);
  out->rho_m = rho;
  out->sin_tau = sin_tau;
  out->doppler_error_m = along - rho * sin_tau;
  out->drho_dp = (d * (1.0 / rho)).transpose();
  out->ded_dp = u.transpose() - sin_tau * out->drho_dp;
  out->ded_dv = ((d - along * u) * per_speed - (rho * by_speed) * u).transpose();
  out->ded_dtau_m = -rho * cos_tau;
  return std::isfinite(out->doppler_error_m);
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
      u_rate.dot(d) - speed - rho_rate * tau.value - rho * tau.by_speed * speed_rate;
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

}  // namespace sarblock
