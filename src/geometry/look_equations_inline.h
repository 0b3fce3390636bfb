// SPDX-License-Identifier: Apache-2.0
// The definition of EvaluateLookEquations, for the loops that evaluate millions of looks: called
// across files it takes a third longer. Everything else includes look_equations.h.
#pragma once

#include "sarblock/geometry/look_equations.h"

#include <cmath>

namespace sarblock {

/// sin(tau) without the squint bias, and its derivative by |v| (Doppler input only).
struct SinTau {
  double value;
  double dsin_dspeed;
};

[[nodiscard]] inline SinTau SinTauOf(const Cone& cone, double speed_mps) {
  if (cone.kind == Cone::Kind::kSquint) {
    return {cone.squint_rad == 0.0 ? 0.0 : std::sin(cone.squint_rad), 0.0};
  }
  const double sine = cone.closing_mps / speed_mps;
  return {sine, -sine / speed_mps};
}

/// A line of sight shorter than this has no defined direction.
inline constexpr double kMinRange_m = 1e-3;

/// EvaluateLookEquations with d = p - s, the speed and the cone axis u given; `du_dv` is 1/|v|, the
/// turn of u by velocity across it.
[[nodiscard]] inline bool EvaluateLookEquationsAlong(const Eigen::Vector3d& d_m,
                                                     double rho_m,
                                                     double inverse_rho_per_m,
                                                     const Eigen::Vector3d& u,
                                                     double speed_mps,
                                                     double du_dv,
                                                     const Cone& cone,
                                                     double squint_bias_rad,
                                                     LookEquations* out) {
  const SinTau given = SinTauOf(cone, speed_mps);
  if (!(std::abs(given.value) < 1.0)) return false;

  // sin(tau + b) and its derivatives by b and by |v|.
  const double cos_given =
      given.value == 0.0 ? 1.0 : std::sqrt((1.0 - given.value) * (1.0 + given.value));
  const bool biased = squint_bias_rad != 0.0;  // most blocks have none: spare the sine
  const double sin_b = biased ? std::sin(squint_bias_rad) : 0.0;
  const double cos_b = biased ? std::cos(squint_bias_rad) : 1.0;
  const double sin_tau = given.value * cos_b + cos_given * sin_b;
  const double cos_tau = cos_given * cos_b - given.value * sin_b;
  const double dsin_dspeed =
      given.dsin_dspeed == 0.0 ? 0.0 : given.dsin_dspeed * cos_tau / cos_given;

  const double along_m = u.dot(d_m);
  out->rho_m = rho_m;
  out->sin_tau = sin_tau;
  out->doppler_error_m = along_m - rho_m * sin_tau;
  out->drho_dp = (d_m * inverse_rho_per_m).transpose();
  out->ded_dp = u.transpose() - sin_tau * out->drho_dp;
  out->ded_dv = ((d_m - along_m * u) * du_dv - (rho_m * dsin_dspeed) * u).transpose();
  out->ded_dtau_m = -rho_m * cos_tau;
  return std::isfinite(out->doppler_error_m);
}

/// EvaluateLookEquations with d = p - s given.
[[nodiscard]] inline bool EvaluateLookEquationsInline(const Eigen::Vector3d& d_m,
                                                      const Eigen::Vector3d& v_mps,
                                                      const Cone& cone,
                                                      double squint_bias_rad,
                                                      LookEquations* out) {
  // Two roots and two divisions side by side: nothing else here takes as long.
  const Eigen::Array2d lengths = Eigen::Array2d(d_m.squaredNorm(), v_mps.squaredNorm()).sqrt();
  const Eigen::Array2d inverses = lengths.inverse();
  const double rho_m = lengths[0], speed_mps = lengths[1];
  // Written so that NaN fails too.
  if (!(rho_m >= kMinRange_m) || !(speed_mps > 0.0) || !std::isfinite(rho_m) ||
      !std::isfinite(speed_mps)) {
    return false;
  }
  return EvaluateLookEquationsAlong(d_m,
                                    rho_m,
                                    inverses[0],
                                    v_mps * inverses[1],
                                    speed_mps,
                                    inverses[1],
                                    cone,
                                    squint_bias_rad,
                                    out);
}

}  // namespace sarblock
