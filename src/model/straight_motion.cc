// SPDX-License-Identifier: Apache-2.0
#include "straight_motion.h"

#include <array>
#include <cmath>
#include <span>

#include "geometry/look_equations_inline.h"
#include "look_model_inline.h"

namespace sarblock {
namespace {

/// Offset, drift, range bias and scale of a pass in a vector of all corrections; linear in it.
StraightStep CorrectionOf(const LookModel& model, std::size_t pass, const Eigen::VectorXd& x) {
  const StraightPass& straight = model.straight(pass);
  const PassCorrections& c = model.layout().passes[pass];
  LookColumns columns;
  model.ColumnsAt(pass, straight.start_s, &columns);
  std::array<double, ParameterLayout::kMaxLocalColumns> local;
  GatherColumns(model.layout(), columns, x, local.data());
  StraightStep out;
  if (!c.polynomials.empty()) {
    const PolynomialTerm& term = c.polynomials[0];
    const double rate = 1.0 / c.half_length_s;
    const double basis_1 = (straight.start_s - c.middle_s) * rate;
    const double* value = local.data() + term.column;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (!term.components[static_cast<std::size_t>(axis)]) continue;
      out.position_m += straight.axes_1.col(axis) * *value;
      if (term.degree == 1) {
        out.position_m += straight.axes_1.col(axis) * (basis_1 * value[1]);
        out.velocity_mps += straight.axes_1.col(axis) * (rate * value[1]);
      }
      value += term.degree + 1;
    }
  }
  for (const int column : c.range_bias) out.range_bias_m += local[static_cast<std::size_t>(column)];
  for (const int column : c.range_scale) {
    out.range_scale_1 += local[static_cast<std::size_t>(column)];
  }
  return out;
}

/// FillStraightRows for a usual pass: every partial is made of the sight line in the track axes.
inline void FillUsualRows(const StraightMotion& motion,
                          double time_s,
                          const LookEquations& eq,
                          const Whitening& w,
                          LookRows rows) {
  const double basis_1 = (time_s - motion.middle_s) * motion.rate;
  const double by_rate = w.w11 * motion.rate;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto axis = motion.axes_1.col(k);
    const double sight_1 = eq.drho_dp.dot(axis);
    const double cone_1 = motion.axis_by_axes_1[k] - eq.sin_tau * sight_1;
    const double range = -w.w00 * sight_1, doppler = -(w.w10 * sight_1 + w.w11 * cone_1);
    rows.range[2 * k] = range;
    rows.range[2 * k + 1] = range * basis_1;
    rows.doppler[2 * k] = doppler;
    rows.doppler[2 * k + 1] = doppler * basis_1 + by_rate * eq.ded_dv.dot(axis);
  }
}

}  // namespace

StraightMotions::StraightMotions(const LookModel& model, const Eigen::VectorXd& corrections)
    : model_(model), motions_(model.layout().passes.size()) {
  for (std::size_t pass = 0; pass < motions_.size(); ++pass) {
    const StraightPass& straight = model.straight(pass);
    if (!straight.applies || straight.curved) continue;
    const StraightStep correction = CorrectionOf(model, pass, corrections);
    StraightMotion& out = motions_[pass];
    out.start_s = straight.start_s;
    out.end_s = straight.end_s;
    out.position_m = straight.position_m + correction.position_m;
    out.velocity_mps = straight.velocity_mps + correction.velocity_mps;
    out.range_bias_m = correction.range_bias_m;
    out.range_scale_1 = correction.range_scale_1;
    const PassCorrections& c = model.layout().passes[pass];
    if (c.blocks.size() == 1) out.only_block = c.blocks[0];
    out.columns = c.static_columns;
    out.speed_mps = out.velocity_mps.norm();
    out.inverse_speed = 1.0 / out.speed_mps;
    out.axis_1 = out.velocity_mps * out.inverse_speed;
    if (out.only_block >= 0 && c.static_columns == 6 && c.polynomials.size() == 1 &&
        c.polynomials[0].degree == 1 && c.range_bias.empty() && c.range_scale.empty()) {
      out.usual = true;
      out.axes_1 = straight.axes_1;
      out.axis_by_axes_1 = out.axes_1.transpose() * out.axis_1;
      out.middle_s = c.middle_s;
      out.rate = 1.0 / c.half_length_s;
    }
    out.applies = out.speed_mps > 0.0 && std::isfinite(out.speed_mps) && out.position_m.allFinite();
  }
}

// In the loops over all looks; a call would pass its results through memory.
__attribute__((always_inline)) inline bool StraightMotions::EvaluateByPoint(
    std::size_t look,
    const StraightMotion& motion,
    const AdjustedTime& adjusted,
    const Eigen::Vector3d& start_m,
    const Eigen::Vector3d& displacement_m,
    const Whitening& w,
    LookEquations* eq,
    Eigen::Vector2d* error_m,
    Eigen::Matrix<double, 2, 3>* by_point) const {
  const Looks& looks = model_.block().looks;
  const double time_s = looks.time_s[look] + adjusted.shift_s;
  if (!(time_s >= motion.start_s && time_s <= motion.end_s)) return false;
  const Eigen::Vector3d s_m = motion.position_m + (time_s - motion.start_s) * motion.velocity_mps;
  const Eigen::Vector3d d_m = (start_m - s_m) + displacement_m;
  const double rho_m = std::sqrt(d_m.squaredNorm());
  if (!(rho_m >= kLeastRange_m) || !std::isfinite(rho_m)) return false;
  if (!EvaluateLookEquationsAlong(d_m,
                                  rho_m,
                                  1.0 / rho_m,
                                  motion.axis_1,
                                  motion.speed_mps,
                                  motion.inverse_speed,
                                  looks.cone.empty() ? Cone{} : model_.ConeOf(look),
                                  0.0,
                                  eq)) {
    return false;
  }
  const double kappa = motion.range_scale_1;
  *error_m = {(eq->rho_m - looks.range_m[look]) + motion.range_bias_m + kappa * eq->rho_m -
                  adjusted.range_m(),
              eq->doppler_error_m - adjusted.doppler_m()};
  const Eigen::RowVector3d range_by_p = (1.0 + kappa) * eq->drho_dp;
  by_point->row(0) = w.w00 * range_by_p;
  by_point->row(1) = w.w10 * range_by_p + w.w11 * eq->ded_dp;
  return error_m->allFinite();
}

bool StraightMotions::Evaluate(std::size_t look,
                               const Eigen::Vector3d& start_m,
                               const Eigen::Vector3d& displacement_m,
                               const Whitening& w,
                               Eigen::Vector2d* error_m,
                               Eigen::Matrix<double, 2, 3>* by_point,
                               LookRows rows) const {
  const Looks& looks = model_.block().looks;
  const std::size_t pass = looks.pass[look];
  LookEquations eq;
  const AdjustedTime adjusted = model_.TimeOf(look);
  if (!EvaluateByPoint(
          look, motions_[pass], adjusted, start_m, displacement_m, w, &eq, error_m, by_point)) {
    return false;
  }
  const double time_s = looks.time_s[look] + adjusted.shift_s;
  if (motions_[pass].usual) {
    FillUsualRows(motions_[pass], time_s, eq, w, rows);
  } else {
    FillStraightRows(
        model_.straight(pass), model_.layout().passes[pass], time_s, eq, w, *by_point, rows);
  }
  return true;
}

std::vector<StraightStep> StraightMotions::StepsFor(const Eigen::VectorXd& dx) const {
  std::vector<StraightStep> steps(motions_.size());
  for (std::size_t pass = 0; pass < motions_.size(); ++pass) {
    if (motions_[pass].applies) steps[pass] = CorrectionOf(model_, pass, dx);
  }
  return steps;
}

bool StraightMotions::EvaluateAlong(std::size_t look,
                                    const Eigen::Vector3d& start_m,
                                    const Eigen::Vector3d& displacement_m,
                                    const StraightStep& step,
                                    const Whitening& w,
                                    Eigen::Vector2d* error_m,
                                    Eigen::Matrix<double, 2, 3>* by_point,
                                    Eigen::Vector2d* along_1) const {
  const Looks& looks = model_.block().looks;
  const StraightMotion& motion = motions_[looks.pass[look]];
  LookEquations eq;
  const AdjustedTime adjusted = model_.TimeOf(look);
  if (!EvaluateByPoint(
          look, motion, adjusted, start_m, displacement_m, w, &eq, error_m, by_point)) {
    return false;
  }
  const double from_start_s = looks.time_s[look] + adjusted.shift_s - motion.start_s;
  const Eigen::Vector3d moved_m = step.position_m + from_start_s * step.velocity_mps;
  const double range_m = step.range_bias_m + step.range_scale_1 * eq.rho_m;
  *along_1 = Eigen::Vector2d(w.w00, w.w10) * range_m - *by_point * moved_m;
  (*along_1)[1] += w.w11 * eq.ded_dv.dot(step.velocity_mps);
  return true;
}

}  // namespace sarblock
