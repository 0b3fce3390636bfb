// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/look_equations.h"

#include <cmath>

#include "look_equations_inline.h"
#include <Eigen/Geometry>

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
      u_rate.dot(d) - speed - rho_rate * tau.value - rho * tau.dsin_dspeed * speed_rate;
  return {rho_rate, doppler_rate, -(doppler_rate + rho_rate * tau.value)};
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
  return WhitenTime(range_sigma_m, azimuth_sigma_m / std::abs(rates.along_mps), rates);
}

Whitening WhitenDoppler(double range_sigma_m, double azimuth_sigma_m) {
  return {1.0 / range_sigma_m, 0.0, 1.0 / azimuth_sigma_m};
}

const char* NameOf(IntersectionOutcome outcome) {
  switch (outcome) {
    case IntersectionOutcome::kDetermined:
      return "determined";
    case IntersectionOutcome::kTooFewLooks:
      return "too-few-looks";
    case IntersectionOutcome::kCirclesDoNotMeet:
      return "circles-do-not-meet";
    case IntersectionOutcome::kCirclesTouch:
      return "circles-touch";
    case IntersectionOutcome::kCirclesCoincide:
      return "circles-coincide";
    case IntersectionOutcome::kWrongSide:
      return "wrong-side";
    case IntersectionOutcome::kAmbiguous:
      return "ambiguous";
    case IntersectionOutcome::kNotConverged:
      return "not-converged";
  }
  return "unknown";
}

const char* Explain(IntersectionOutcome outcome) {
  switch (outcome) {
    case IntersectionOutcome::kDetermined:
      return "The looks determine one point";
    case IntersectionOutcome::kTooFewLooks:
      return "Fewer than two looks: one look confines the point to a circle only";
    case IntersectionOutcome::kCirclesDoNotMeet:
      return "The circles of the looks stay apart by more than their standard deviations explain: "
             "look for a blunder, a path error or standard deviations that are too small";
    case IntersectionOutcome::kCirclesTouch:
      return "The circles of the looks meet tangentially: one direction is not determined";
    case IntersectionOutcome::kCirclesCoincide:
      return "The circles of the looks are the same within the noise (zero base, or squinted "
             "stereo "
             "from a single flight line): the direction around the flight axis is not determined";
    case IntersectionOutcome::kWrongSide:
      return "The circles meet, but not on the side the antennas look to: check the look sides";
    case IntersectionOutcome::kAmbiguous:
      return "Two points satisfy the looks and their sides equally well: a third look or control "
             "has to decide";
    case IntersectionOutcome::kNotConverged:
      return "The iteration did not converge";
  }
  return "";
}

ConeValue EvaluateCone(const Motion& motion, const Eigen::Vector3d& p_m, const Cone& cone) {
  const Eigen::Vector3d los_m = p_m - motion.position_m;
  const double speed_mps = motion.velocity_mps.norm();
  const double sin_tau = cone.Sine(speed_mps);
  return {motion.velocity_mps.dot(los_m) / speed_mps - los_m.norm() * sin_tau,
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

bool LiesWhereItLooks(const Frame& frame,
                      const FixedPathLook& observation,
                      const Eigen::Vector3d& p_m) {
  // The signs of the track components of d (model.md, section 2) need no axes of unit length.
  const Eigen::Vector3d vertical = frame.UpAt(observation.antenna_m);
  const Eigen::Vector3d& v = observation.velocity_mps;
  const Eigen::Vector3d d = p_m - observation.antenna_m;
  const double across = vertical.cross(v).dot(d) * observation.side;
  const double up = vertical.dot(d) * v.squaredNorm() - vertical.dot(v) * v.dot(d);
  return across > 0.0 && up < 0.0;
}

bool PredictLook(const LookGeometry& at, LookPrediction* out) {
  AxisTurn turn;
  turn.value = at.axis_turn_rad;
  turn.rate = at.axis_turn_rad_per_s;
  // Written so that NaN counts as a turn, and is refused.
  turn.used = !(at.axis_turn_rad.squaredNorm() + at.axis_turn_rad_per_s.squaredNorm() == 0.0);
  Crossing crossing;
  if (!FindCrossing(at.motion, at.line_of_sight_m, turn, at.cone, at.squint_bias_rad, &crossing)) {
    return false;
  }
  const LookEquations& eq = crossing.eq;
  const double slowness = -1.0 / crossing.rate_m;  // dt_p = slowness de_d
  const double range_rate_mps = -eq.drho_dp.dot(crossing.v_mps);
  const double last_step_s = slowness * eq.doppler_error_m;
  out->delay_s = crossing.dt_s + last_step_s;
  out->range_m = eq.rho_m + range_rate_mps * last_step_s;
  out->cone_rate_mps = -crossing.rate_m;
  out->along_mps = eq.sin_tau * eq.drho_dp.dot(crossing.v_mps) - crossing.rate_m;
  out->line_of_sight_m = crossing.d_m;
  out->velocity_mps = crossing.v_mps;
  // A partial of e_d moves the time, and the time the range.
  const Eigen::Vector2d by_cone(range_rate_mps * slowness, slowness);
  out->d_point = by_cone * eq.ded_dp;
  out->d_point.row(0) += eq.drho_dp;
  MotionPartials partials;
  partials.Set(-out->d_point, by_cone * crossing.ConeByVelocity(turn.used), crossing.dt_s);
  out->d_position = partials.by[0];
  out->d_velocity = partials.by[1];
  out->d_acceleration = partials.by[2];
  out->d_axis = crossing.v_mps.norm() * (by_cone * eq.ded_dv);
  out->d_squint = eq.ded_dtau_m * by_cone;
  return std::isfinite(out->delay_s) && std::isfinite(out->range_m);
}

}  // namespace sarblock
