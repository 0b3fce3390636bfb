// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/path.h"

#include <cmath>
#include <optional>

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
  Eigen::RowVector3d drho_dp = Eigen::RowVector3d::Zero();  ///< unit line of sight d'/rho
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
/// d(rho)/dt = -v.d/rho and d(e_d)/dt along the path with acceleration a; and the speed at which
/// the look passes over the target, along the cone axis, -(d(e_d)/dt + d(rho)/dt sin(tau)): |v| on
/// a straight path, whatever the squint. docs/theory/observations.md, eq. (10a).
struct TimeRates {
  double range_mps = 0.0;
  double doppler_mps = 0.0;
  double along_mps = 0.0;
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
/// The same from sigma_R and the azimuth standard deviation in metres along track at the target,
/// sigma_t = sigma_a / along_mps. With r = 0 this is two divisions.
[[nodiscard]] Whitening WhitenAzimuth(double range_sigma_m,
                                      double azimuth_sigma_m,
                                      const TimeRates& rates);
/// Whitening where the time is exact and the Doppler is measured: the errors are independent,
/// azimuth_sigma_m is that of e_d.
[[nodiscard]] Whitening WhitenDoppler(double range_sigma_m, double azimuth_sigma_m);

/// An observation with fixed trajectory: everything that constrains the point.
struct FixedPathLook {
  Eigen::Vector3d antenna_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();
  double range_m = 0.0;
  Cone cone;
  int side = +1;  ///< +1 left of the flight direction, -1 right (the sign of (up x along).d)
  double range_sigma_m = 1.0;
  double azimuth_sigma = 1.0;  ///< [m] at the target or [s]
  bool azimuth_in_seconds = false;
  /// The azimuth error is one of the Doppler at an exact time, in [m]: it moves no range.
  bool exact_time = false;
};

enum class IntersectionOutcome {
  kDetermined,
  kTooFewLooks,
  kCirclesDoNotMeet,  ///< the two circles stay apart by more than the looks' noise explains
  kCirclesTouch,      ///< they meet tangentially: one direction is not determined
  kCirclesCoincide,   ///< same circle (single-flight squinted stereo, zero base)
  kWrongSide,         ///< they meet, but not on the side the antennas look to
  kAmbiguous,         ///< two solutions satisfy looks and sides equally well
  kNotConverged,
};
[[nodiscard]] const char* NameOf(IntersectionOutcome outcome);   ///< "circles-coincide", ...
[[nodiscard]] const char* Explain(IntersectionOutcome outcome);  ///< for people, no full stop

struct Intersection {
  IntersectionOutcome outcome = IntersectionOutcome::kNotConverged;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< (J'J)^-1: frame axes, paths fixed
  double weighted_square_sum = 0.0;                         ///< v'Pv of the 2 n equations
  double intersection_rad = 0.0;  ///< largest angle between the planes of two observations
  int iterations = 0;
};

struct IntersectionOptions {
  int max_iterations = 100;
  /// Below this reciprocal condition of the column-scaled whitened Jacobian the point counts as not
  /// determined (touching or coinciding circles).
  double min_reciprocal_condition = 1e-9;
  /// The solution is reached where a step changes the whitened equations by less than this part of
  /// a standard deviation. Above 1e-6 weights are those of the first approximation.
  double settled_sigmas = 1e-8;
  /// Whether covariance and intersection angle are computed; where not, they are NaN.
  bool with_covariance = true;
};

/// e_d of a look at fixed point as its time moves, and how fast it falls.
struct ConeValue {
  double doppler_error_m = 0.0;
  double rate_mps = 0.0;  ///< de_d/dt, about -|v| cos^2(tau)
};
[[nodiscard]] ConeValue EvaluateCone(const Motion& motion,
                                     const Eigen::Vector3d& p_m,
                                     const Cone& cone);

/// The explicit observation model's time: Newton's method on e_d(t) = 0 from `time_s` over any path
/// with At(t) -> optional<Motion>. Converges to the rounding of e_d (below 10 nm for |p| < 1e7 m);
/// nothing where an iterate leaves the path or 30 steps do not suffice.
template <typename Path>
[[nodiscard]] std::optional<double> SolveConeTime(const Path& path,
                                                  const Eigen::Vector3d& p_m,
                                                  const Cone& cone,
                                                  double time_s) {
  constexpr double kCloseEnough_m = 1e-7;  // one more step then reaches the rounding
  for (int iteration = 0; iteration < 30; ++iteration) {
    const std::optional<Motion> motion = path.At(time_s);
    if (!motion) return std::nullopt;
    const ConeValue at = EvaluateCone(*motion, p_m, cone);
    if (!(at.rate_mps < 0.0)) return std::nullopt;  // beyond the cone's turning point, or NaN
    time_s -= at.doppler_error_m / at.rate_mps;
    if (std::abs(at.doppler_error_m) < kCloseEnough_m) return time_s;
  }
  return std::nullopt;
}

/// The time in [start_s, end_s] at which p lies on the cone, or nothing: sign change between the
/// ends, then Newton kept inside the bracket by bisection.
[[nodiscard]] std::optional<double> FindConeTime(const FlightPath& path,
                                                 const Eigen::Vector3d& p_m,
                                                 const Cone& cone,
                                                 double start_s,
                                                 double end_s);

/// True where p lies on the side the antenna looks to and below it: a mirror solution does not.
[[nodiscard]] bool LiesWhereItLooks(const Frame& frame,
                                    const FixedPathLook& observation,
                                    const Eigen::Vector3d& p_m);

/// An antenna that was read at one time, and a point as it is seen from there.
struct LookGeometry {
  Eigen::Vector3d line_of_sight_m = Eigen::Vector3d::Zero();  ///< p - s at that time, frame axes
  Motion motion;  ///< at that time; velocity, acceleration and jerk are used, the position is not
  Cone cone;
  double squint_bias_rad = 0.0;  ///< b_tau
  /// Direction error of the cone axis, c in v + |v| c, and its rate [1/s], frame axes.
  Eigen::Vector3d axis_turn_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_turn_rad_per_s = Eigen::Vector3d::Zero();
};

/// What the look measures, predicted. Row 0 of a partial is that of the range, row 1 that of the
/// time. Partials by the antenna are for changes of its motion at the time it was read: a parameter
/// that moves it by f(t) has the partial d_position f + d_velocity f' + d_acceleration f''.
struct LookPrediction {
  double range_m = 0.0;                    ///< rho at t_p
  double delay_s = 0.0;                    ///< t_p less the time at which the antenna was read
  double cone_rate_mps = 0.0;              ///< |de_d/dt| at t_p
  double along_mps = 0.0;                  ///< metres along track at the target per second, at t_p
  Eigen::Matrix<double, 2, 3> d_point;     ///< [1], [s/m]
  Eigen::Matrix<double, 2, 3> d_position;  ///< [1], [s/m]
  Eigen::Matrix<double, 2, 3> d_velocity;  ///< [s], [s2/m]
  Eigen::Matrix<double, 2, 3> d_acceleration;  ///< [s2], [s3/m]
  Eigen::Matrix<double, 2, 3> d_axis;          ///< by c [m], [s]
  Eigen::Matrix<double, 2, 1> d_squint;        ///< by b_tau [m/rad], [s/rad]
  Eigen::Vector3d line_of_sight_m;             ///< p - s at t_p
  Eigen::Vector3d velocity_mps;                ///< of the antenna at t_p
};

/// Range and time that a look of a point measures: the explicit model of Adjust() without its
/// corrections of the range (docs/theory/observations.md, eqs. (9) to (11c)),
///
///     e_d(p, t_p) = u.d - rho sin(tau + b_tau) = 0,    R_p = rho(t_p),    d = p - s(t), rho = |d|,
///
/// the cone axis u along v + |v| c, the antenna moving on from where it was read with its velocity,
/// acceleration and jerk. t_p by Newton's method to 1e-12 of rho, as the last step leaves it; its
/// partials are those of the implicit function, dt_p = -de_d / (de_d/dt). The partials by
/// acceleration leave out the effect of the third derivative of f.
///
/// False where there is no value: rho below 1 mm, antenna at rest, |sin(tau)| not below 1, a cone
/// that never passes over the point or does so with less than a fiftieth of the speed, an argument
/// that is not finite. `out` is then left half written. Reads its arguments alone, never throws.
[[nodiscard]] bool PredictLook(const LookGeometry& at, LookPrediction* out);

}  // namespace sarblock
