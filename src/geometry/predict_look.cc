// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/predict_look.h"

#include <cmath>

#include "geometry/predict_look_inline.h"

namespace sarblock {

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
