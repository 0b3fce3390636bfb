// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace sarblock {

/// Which cone a look confines its point to.
///     squint:   sin(tau) given;                     Doppler:  v.d / rho = lambda f_D / 2 given,
/// so that sin(tau) = (lambda f_D / 2) / |v|. squint 0 is a zero-Doppler product.
struct Cone {
  enum class Kind { kSquint, kDoppler };
  Kind kind = Kind::kSquint;
  double squint_rad = 0.0;   ///< kSquint; |squint| < pi/2
  double closing_mps = 0.0;  ///< kDoppler: lambda f_D / 2 = v.d / rho
  /// sin(tau) for an antenna of this speed |v|.
  [[nodiscard]] double Sine(double speed_mps) const {
    return kind == Kind::kSquint ? std::sin(squint_rad) : closing_mps / speed_mps;
  }
};

/// Errors of the range sphere and the Doppler cone and their partials (model.md, section 4).
///
///     e_r = rho - R + (corrections added by the caller)         [m]
///     e_d = u.d - rho sin(tau + b_tau)                           [m]
///
/// with d = p - s, rho = |d|, u = v/|v| the cone axis. Partials by s are the negatives of those by
/// p. docs/theory/observations.md, eq. (1)-(8).
struct LookEquations {
  double rho_m = 0.0;
  double sin_tau = 0.0;
  double doppler_error_m = 0.0;                             ///< e_d
  Eigen::RowVector3d drho_dp = Eigen::RowVector3d::Zero();  ///< unit sight line d'/rho [1]
  Eigen::RowVector3d ded_dp = Eigen::RowVector3d::Zero();   ///< [1]
  Eigen::RowVector3d ded_dv = Eigen::RowVector3d::Zero();   ///< by the cone axis vector v [s]
  double ded_dtau_m = 0.0;                                  ///< by b_tau [m/rad]
};

/// Evaluates both at a point p and an antenna (position s, cone axis vector v: the velocity, plus
/// corrections of its direction). `squint_bias_rad` is b_tau. Returns false where rho < 1 mm,
/// |v| = 0, |sin tau| >= 1 or an input is not finite.
[[nodiscard]] bool EvaluateLookEquations(const Eigen::Vector3d& p_m,
                                         const Eigen::Vector3d& s_m,
                                         const Eigen::Vector3d& v_mps,
                                         const Cone& cone,
                                         double squint_bias_rad,
                                         LookEquations* out);

/// How an azimuth time error moves both errors, at fixed point (model.md, section 4):
/// d(rho)/dt = -v.d/rho and d(e_d)/dt along the path with acceleration a.
struct TimeRates {
  double range_mps = 0.0;
  double doppler_mps = 0.0;
};
[[nodiscard]] TimeRates LookTimeRates(const Eigen::Vector3d& p_m,
                                      const Eigen::Vector3d& s_m,
                                      const Eigen::Vector3d& v_mps,
                                      const Eigen::Vector3d& acceleration_mps2,
                                      const Cone& cone);

/// Lower Cholesky factor of the 2 x 2 covariance of (e_r, e_d), inverted: whitened = W (e_r, e_d).
struct Whitening {
  double w00 = 0.0, w10 = 0.0, w11 = 0.0;
  [[nodiscard]] Eigen::Vector2d Apply(double range_error_m, double doppler_error_m) const {
    return {w00 * range_error_m, w10 * range_error_m + w11 * doppler_error_m};
  }
};

/// Whitening from sigma_R [m] and sigma_t [s]. With rates (r, d): covariance
/// [[sR^2 + r^2 st^2, r d st^2], [., d^2 st^2]]; docs/theory/observations.md, eq. (11a).
[[nodiscard]] Whitening WhitenTime(double range_sigma_m,
                                   double time_sigma_s,
                                   const TimeRates& rates);
/// The same from sigma_R and the azimuth standard deviation in metres at the target,
/// sigma_t = sigma_a / |d|. With r = 0 this is two divisions.
[[nodiscard]] Whitening WhitenAzimuth(double range_sigma_m,
                                      double azimuth_sigma_m,
                                      const TimeRates& rates);
/// Whitening where the time is exact and the Doppler is measured: the errors are independent,
/// azimuth_sigma_m is that of e_d.
[[nodiscard]] Whitening WhitenDoppler(double range_sigma_m, double azimuth_sigma_m);

}  // namespace sarblock
