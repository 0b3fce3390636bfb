// SPDX-License-Identifier: Apache-2.0
// The equations of a look and what it measures, predicted: the one implementation, for
// EvaluateLookEquations(), PredictLook() and the model of the adjustment, which adds its
// corrections of the range. Inline for the loops that evaluate millions of looks: called across
// files it takes a third longer. Everything else includes look_equations.h.
#pragma once

#include "sarblock/geometry/look_equations.h"
#include "sarblock/geometry/path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Core>

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

/// A point this near its cone, as a part of the range, is on it: a step beyond moves no error by
/// more than rounding does, and no partial by more than 1e-10 of its size.
inline constexpr double kOnCone = 1e-12;
/// The same where rounding of coordinates keeps it from coming nearer.
inline constexpr double kRoundingOnCone = 1e-8;
inline constexpr int kMaxConeSteps = 30;
/// Least rate, as a part of the speed, at which the cone passes over a point: flatter, a step would
/// go anywhere. At the solution flatter means that the cone turns with the point.
inline constexpr double kMinConeRate = 0.02;

/// Direction errors of the cone axis, t = c_across across + c_up up and its rate:
/// v_cone = v + |v| t.
struct AxisTurn {
  bool used = false;
  Eigen::Vector3d value = Eigen::Vector3d::Zero(), rate = Eigen::Vector3d::Zero();
};

/// Where the cone of a look, moved on from its measured time or opened to another Doppler, holds
/// the point.
struct Crossing {
  LookEquations eq;       ///< there, e_d but for rounding 0
  double dt_s = 0.0;      ///< after the reading; 0 where the time is exact
  double error = 0.0;     ///< of the azimuth measurement, predicted less measured [s] or [Hz]
  Eigen::Vector3d d_m;    ///< from the antenna to the point
  Eigen::Vector3d v_mps;  ///< of the antenna
  Eigen::Vector3d turn;   ///< where the cone axis has direction errors; with |v|
  double speed_mps = 0.0;
  double rate_m = 0.0;         ///< de_d by a unit of that measurement: q = de_d/dt, or de_d/df
  double path_rate_mps = 0.0;  ///< de_d by the time that is exact

  /// Partial of e_d by the velocity of the antenna. Cone axis v_cone by velocity: dv_cone = dv +
  /// (u.dv) t.
  [[nodiscard]] Eigen::RowVector3d ConeByVelocity(bool turned) const {
    Eigen::RowVector3d by_v = eq.ded_dv;
    if (turned) by_v += eq.ded_dv.dot(turn) / speed_mps * v_mps.transpose();
    return by_v;
  }
};

/// The time of the crossing, by Newton's method on the cone. `d_before_m`: from the antenna at the
/// measured time to the point.
[[nodiscard]] inline bool FindCrossing(const Motion& motion,
                                       const Eigen::Vector3d& d_before_m,
                                       const AxisTurn& turn,
                                       const Cone& cone,
                                       double squint_bias_rad,
                                       Crossing* out) {
  const Eigen::Vector3d &v0 = motion.velocity_mps, &a0 = motion.acceleration_mps2,
                        &jerk = motion.jerk_mps3;
  double dt_s = 0.0, last_off_m = 0.0;
  // A zero-Doppler cone has e_d |v| = v.d, so its first step needs no square root.
  if (cone.kind == Cone::Kind::kSquint && cone.squint_rad == 0.0 && squint_bias_rad == 0.0 &&
      !turn.used) {
    const double square = v0.squaredNorm(), closing = square - a0.dot(d_before_m);
    if (closing > kMinConeRate * square) dt_s = v0.dot(d_before_m) / closing;
  }
  double first_s = -std::numeric_limits<double>::infinity(), last_s = -first_s;
  for (int step = 0;; ++step) {
    const Eigen::Vector3d a = a0 + dt_s * jerk;
    out->v_mps = v0 + dt_s * (a0 + (0.5 * dt_s) * jerk);
    out->d_m = d_before_m - dt_s * (v0 + (0.5 * dt_s) * (a0 + (dt_s / 3.0) * jerk));
    const Eigen::Vector3d& v = out->v_mps;
    LookEquations& eq = out->eq;
    if (turn.used) {
      out->speed_mps = v.norm();
      out->turn = turn.value + dt_s * turn.rate;
      const Eigen::Vector3d axis = v + out->speed_mps * out->turn;
      const Eigen::Vector3d axis_rate =
          a + (v.dot(a) / out->speed_mps) * out->turn + out->speed_mps * turn.rate;
      if (!EvaluateLookEquationsInline(out->d_m, axis, cone, squint_bias_rad, &eq)) return false;
      out->rate_m = eq.ded_dv.dot(axis_rate) - eq.ded_dp.dot(v);
    } else {
      if (!EvaluateLookEquationsInline(out->d_m, v, cone, squint_bias_rad, &eq)) return false;
      out->rate_m = eq.ded_dv.dot(a) - eq.ded_dp.dot(v);
    }
    const double off_m = eq.doppler_error_m, size_m = std::abs(off_m);
    if (size_m <= kOnCone * eq.rho_m ||
        (size_m <= kRoundingOnCone * eq.rho_m && step > 1 && size_m > 0.25 * last_off_m)) {
      break;
    }
    if (step == kMaxConeSteps) return false;
    last_off_m = size_m;
    // The point is ahead of the cone while e_d > 0.
    (off_m > 0.0 ? first_s : last_s) = dt_s;
    double next_s = dt_s + off_m / std::max(-out->rate_m, kMinConeRate * v.norm());
    if (!(next_s > first_s && next_s < last_s)) next_s = 0.5 * (first_s + last_s);
    if (!std::isfinite(next_s)) return false;
    dt_s = next_s;
  }
  out->dt_s = out->error = dt_s;
  const double least_square = kMinConeRate * kMinConeRate * out->v_mps.squaredNorm();
  return out->rate_m < 0.0 && out->rate_m * out->rate_m > least_square;
}

/// The Doppler whose cone holds the point at the measured time, which is exact. `cone` is the
/// measured one.
[[nodiscard]] inline bool FindDoppler(const Motion& motion,
                                      const Eigen::Vector3d& d_m,
                                      const AxisTurn& turn,
                                      const Cone& cone,
                                      double wavelength_m,
                                      double squint_bias_rad,
                                      Crossing* out) {
  out->d_m = d_m;
  out->v_mps = motion.velocity_mps;
  const Eigen::Vector3d &v = motion.velocity_mps, &a = motion.acceleration_mps2;
  Eigen::Vector3d axis = v, axis_rate = a;
  if (turn.used) {
    out->speed_mps = v.norm();
    out->turn = turn.value;
    axis += out->speed_mps * turn.value;
    axis_rate += (v.dot(a) / out->speed_mps) * turn.value + out->speed_mps * turn.rate;
  }
  const double axis_mps = axis.norm(), rho_m = d_m.norm();
  // The point is seen at the angle tau + b_tau, its Doppler is that of tau.
  const double sin_seen = axis.dot(d_m) / (axis_mps * rho_m);
  if (!(std::abs(sin_seen) < 1.0)) return false;
  const double cos_seen = std::sqrt((1.0 - sin_seen) * (1.0 + sin_seen));
  const double sin_b = std::sin(squint_bias_rad), cos_b = std::cos(squint_bias_rad);
  const double sin_tau = sin_seen * cos_b - cos_seen * sin_b;
  const double cos_tau = cos_seen * cos_b + sin_seen * sin_b;
  if (!(cos_tau > 0.0)) return false;
  const Cone predicted{Cone::Kind::kDoppler, 0.0, axis_mps * sin_tau};
  if (!EvaluateLookEquationsInline(d_m, axis, predicted, squint_bias_rad, &out->eq)) return false;
  const double hz_per_mps = 2.0 / wavelength_m;
  out->error = hz_per_mps * (predicted.closing_mps - cone.closing_mps);
  out->rate_m = -rho_m * (cos_seen / cos_tau) / (axis_mps * hz_per_mps);
  out->path_rate_mps = out->eq.ded_dv.dot(axis_rate) - out->eq.ded_dp.dot(v);
  return out->rate_m < 0.0;
}

/// The range at the measured time, which is exact, where nothing of the cone is measured.
[[nodiscard]] inline bool FindRange(const Motion& motion,
                                    const Eigen::Vector3d& d_m,
                                    Crossing* out) {
  out->d_m = d_m;
  out->v_mps = motion.velocity_mps;
  out->speed_mps = out->v_mps.norm();
  out->turn.setZero();
  LookEquations& eq = out->eq;
  eq = {};
  eq.rho_m = d_m.norm();
  if (!(eq.rho_m >= kMinRange_m) || !std::isfinite(eq.rho_m)) return false;
  eq.drho_dp = (d_m / eq.rho_m).transpose();
  out->rate_m = -1.0;
  return true;
}

/// Partials of range (row 0) and of the azimuth measurement (row 1).
using TwoRows = Eigen::Matrix<double, 2, 3>;

/// Partials by what moves the antenna by B(t): by[0] B + by[1] B' + by[2] B'' + by[3] B''' at the
/// reading. A time dt later that is B + B' dt + B'' dt^2/2 + B''' dt^3/6, and the velocity moves by
/// the derivative of that.
struct MotionPartials {
  std::array<TwoRows, 4> by;

  void Set(const TwoRows& by_position, const TwoRows& by_velocity, double dt_s) {
    by[0] = by_position;
    by[1] = dt_s * by_position + by_velocity;
    by[2] = (0.5 * dt_s * dt_s) * by_position + dt_s * by_velocity;
    by[3] = (dt_s * dt_s * dt_s / 6.0) * by_position + (0.5 * dt_s * dt_s) * by_velocity;
  }
};

}  // namespace sarblock
