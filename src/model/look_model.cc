// SPDX-License-Identifier: Apache-2.0
#include "look_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/look_equations_inline.h"

namespace sarblock {
namespace {

/// A point this near its cone, as a part of the range, is on it: a step beyond moves no error by
/// more than rounding does, and no partial by more than 1e-10 of its size.
constexpr double kOnCone = 1e-12;
/// The same where rounding of coordinates keeps it from coming nearer.
constexpr double kRoundingOnCone = 1e-8;
constexpr int kMaxConeSteps = 30;
/// Least rate, as a part of the speed, at which the cone passes over a point: flatter, a step would
/// go anywhere. At the solution flatter means that the cone turns with the point.
constexpr double kMinConeRate = 0.02;

double SumOf(const std::vector<int>& columns, const double* x) {
  double sum = 0.0;
  for (const int column : columns) sum += x[column];
  return sum;
}

/// Slant delay mapping m(p) = exp(-h/H) / cos(incidence) and its partials; false where the line of
/// sight does not come from above.
struct SlantMapping {
  double value;
  Eigen::RowVector3d by_p, by_s;
};

bool EvaluateMapping(const Vertical& vertical,
                     const Eigen::Vector3d& d_m,
                     double rho_m,
                     double scale_height_m,
                     SlantMapping* out) {
  const double drop_m = -vertical.up.dot(d_m);  // rho cos(incidence)
  if (!(drop_m > 1e-6 * rho_m)) return false;
  const double thinning = std::exp(-vertical.height_m / scale_height_m);
  const Eigen::RowVector3d observation = (d_m / rho_m).transpose();
  const Eigen::RowVector3d ddrop_dp =
      -vertical.up.transpose() - (vertical.dup_dp * d_m).transpose();
  const double m = thinning * rho_m / drop_m;
  out->value = m;
  out->by_p = (-m / scale_height_m) * vertical.up.transpose() + (thinning / drop_m) * observation -
              (m / drop_m) * ddrop_dp;
  out->by_s = (-thinning / drop_m) * observation - (m / drop_m) * vertical.up.transpose();
  return true;
}

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
};

/// The time of the crossing, by Newton's method on the cone. `d_before_m`: from the antenna at the
/// measured time to the point.
bool FindCrossing(const Motion& motion,
                  const Eigen::Vector3d& d_before_m,
                  const AxisTurn& turn,
                  const Cone& cone,
                  double squint_bias_rad,
                  Crossing* out) {
  const Eigen::Vector3d &v0 = motion.velocity_mps, &a0 = motion.acceleration_mps2,
                        &jerk = motion.jerk_mps3;
  double dt_s = 0.0, last_off_m = 0.0;
  // Of a zero-Doppler cone e_d |v| = v.d, so that the first step needs no root.
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
bool FindDoppler(const Motion& motion,
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

/// Partials of range (row 0) and of the azimuth measurement (row 1), weighted.
using TwoRows = Eigen::Matrix<double, 2, 3>;

/// Partials by position and velocity of the antenna, turned to axes A: by a parameter that moves
/// the path by A B they are by[0] B + by[1] B' + by[2] B''.
struct AxisPartials {
  bool set = false;
  std::array<TwoRows, 3> by;

  /// The parameter moves the antenna by A B at the measured time, by (A B) + (A B)' dt + (A B)''
  /// dt^2/2 a time dt later, and its velocity by the derivative of that.
  void SetInFrame(const TwoRows& by_s, const TwoRows& by_v, double dt_s) {
    set = true;
    by[0] = by_s;
    by[1] = dt_s * by_s + by_v;
    by[2] = (0.5 * dt_s * dt_s) * by_s + dt_s * by_v;
  }
  void SetInTrack(const Eigen::Matrix3d& axes,
                  const std::optional<TrackAxes>& turning,
                  const TwoRows& by_s,
                  const TwoRows& by_v,
                  double dt_s) {
    const TwoRows s0 = by_s.lazyProduct(axes), v0 = by_v.lazyProduct(axes);
    SetInFrame(s0, v0, dt_s);
    if (!turning) return;
    const TwoRows later = (0.5 * dt_s * dt_s) * by_s + dt_s * by_v;
    const TwoRows now = dt_s * by_s + by_v;
    by[0] += now.lazyProduct(turning->rate) + later.lazyProduct(turning->acceleration);
    by[1] += (2.0 * later).lazyProduct(turning->rate);
  }
};

using LocalRow = std::array<double, ParameterLayout::kMaxLocalColumns>;

/// Sets the columns of a term in two rows.
void SetColumns(const TermAtTime& term, const AxisPartials& partials, LocalRow* rows) {
  int rank = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (!term.components[static_cast<std::size_t>(axis)]) continue;
    const Eigen::Vector2d by_value = partials.by[0].col(axis), by_first = partials.by[1].col(axis),
                          by_second = partials.by[2].col(axis);
    auto column = static_cast<std::size_t>(term.column + term.by_axis * rank++);
    for (std::size_t k = 0; k < term.functions; ++k) {
      const Eigen::Vector2d both =
          by_value * term.value[k] + by_first * term.first[k] + by_second * term.second[k];
      rows[0][column] = both[0];
      rows[1][column] = both[1];
      column += static_cast<std::size_t>(term.by_function);
    }
  }
}

/// Sets the columns of all corrections of the path, `by_s` and `by_v` partials by position and
/// velocity of the antenna a time `dt_s` after the reading.
void SetPathColumns(const PathReading& path,
                    const TwoRows& by_s,
                    const TwoRows& by_v,
                    double dt_s,
                    LocalRow* rows) {
  AxisPartials track, frame;  // three numbers an axis serve all basis functions
  for (std::size_t q = 0; q < path.term_count; ++q) {
    const bool in_track = path.terms[q].axes == PositionCorrection::Axes::kTrack;
    AxisPartials& partials = in_track ? track : frame;
    if (in_track && !partials.set) {
      partials.SetInTrack(*path.axes, path.turning, by_s, by_v, dt_s);
    } else if (!partials.set) {
      partials.SetInFrame(by_s, by_v, dt_s);
    }
    SetColumns(path.terms[q], partials, rows);
  }
}

/// The second derivatives of a look at its crossing. With t the time from there, the range
/// r(t, d, v) = |d - v t - a t^2/2| and the cone F(t, d, v) = u.d - rho sin(tau) of d and v at t,
///
///     t' = -F'/F_t,   t'' = -(F'' + F_t' t' + t' F_t' + F_tt t' t')/F_t,
///     R'' = r'' + r_t' t' + t' r_t' + r_tt t' t' + r_t t''
void SetCurvature(const Crossing& crossing, const Eigen::Vector3d& a, LookCurvature* out) {
  using Matrix6 = LookCurvature::Matrix6;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const Eigen::Vector3d &d = crossing.d_m, &v = crossing.v_mps;
  const double rho = crossing.eq.rho_m, speed = v.norm();
  const Eigen::Vector3d g = d / rho, u = v / speed;
  const double along = u.dot(d), sine = along / rho;
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d r_dd = (identity - g * g.transpose()) / rho;
  const Eigen::Matrix3d f_dd = -sine * r_dd, f_dv = (identity - u * u.transpose()) / speed;
  const Eigen::Matrix3d f_vv =
      (3.0 * along * u * u.transpose() - along * identity - d * u.transpose() - u * d.transpose()) /
      (speed * speed);
  const Eigen::Vector3d f_d = u - sine * g, f_v = f_dv * d;
  const double f_t = f_v.dot(a) - f_d.dot(v), r_t = -g.dot(v);
  const double f_tt = v.dot(f_dd * v) - 2.0 * v.dot(f_dv * a) + a.dot(f_vv * a) - f_d.dot(a);
  const double r_tt = v.dot(r_dd * v) - g.dot(a);
  Vector6 t1, f_t1, r_t1;
  t1 << f_d, f_v;
  t1 /= -f_t;
  f_t1 << f_dv * a - f_dd * v, f_vv * a - f_dv * v - f_d;
  r_t1 << -r_dd * v, -g;
  Matrix6 f2;
  f2 << f_dd, f_dv, f_dv, f_vv;
  out->azimuth =
      -(f2 + f_t1 * t1.transpose() + t1 * f_t1.transpose() + f_tt * t1 * t1.transpose()) / f_t;
  out->range = r_t1 * t1.transpose() + t1 * r_t1.transpose() + r_tt * t1 * t1.transpose() +
               r_t * out->azimuth;
  out->range.topLeftCorner<3, 3>() += r_dd;
}

/// The same where the time is exact: of rho and of f = 2 v.d / (lambda rho).
void SetCurvatureOfDoppler(const Crossing& crossing, double wavelength_m, LookCurvature* out) {
  const Eigen::Vector3d &d = crossing.d_m, &v = crossing.v_mps;
  const double rho = crossing.eq.rho_m;
  const Eigen::Vector3d g = d / rho;
  const Eigen::Matrix3d r_dd = (Eigen::Matrix3d::Identity() - g * g.transpose()) / rho;
  const Eigen::Vector3d across = r_dd * v;
  out->range.setZero();
  out->range.topLeftCorner<3, 3>() = r_dd;
  const double hz_per_mps = 2.0 / wavelength_m;
  out->azimuth.setZero();
  out->azimuth.topLeftCorner<3, 3>() =
      -hz_per_mps / rho * (across * g.transpose() + g * across.transpose() + v.dot(g) * r_dd);
  out->azimuth.topRightCorner<3, 3>() = hz_per_mps * r_dd;
  out->azimuth.bottomLeftCorner<3, 3>() = hz_per_mps * r_dd;
}

}  // namespace

LookModel::LookModel(const Block& block,
                     const ParameterLayout& layout,
                     const Simplified& simplified)
    : block_(block), layout_(layout), simplified_(simplified), paths_(block, layout, simplified) {
  if (simplified.flat_frame) middle_ = block.frame.VerticalAt(simplified.middle_m);
}

LookSigma LookModel::SigmaOf(std::size_t look) const {
  LookSigma sigma = block_.SigmaOf(look);
  if (!sigma_factors_.empty()) {
    const std::array<double, 2>& factor = sigma_factors_[block_.looks.pass[look]];
    sigma.range_m *= factor[0];
    sigma.azimuth *= factor[1];
  }
  return sigma;
}

void LookModel::ColumnsOf(std::size_t look, LookColumns* columns) const {
  ColumnsAt(block_.looks.pass[look], block_.looks.time_s[look], columns);
}

void LookModel::ColumnsAt(std::size_t pass, double time_s, LookColumns* columns) const {
  const PassCorrections& corrections = layout_.passes[pass];
  columns->column_count = corrections.static_columns;
  if (corrections.blocks.size() == 1 && corrections.splines.empty()) {  // the usual pass
    columns->block_count = 1;
    columns->block[0] = corrections.blocks[0];
    return;
  }
  columns->block_count = 0;
  const auto add = [&](int block) {
    columns->block[static_cast<std::size_t>(columns->block_count++)] = block;
  };
  for (const int block : corrections.blocks) add(block);
  for (const SplineTerm& term : corrections.splines) {
    const int first = static_cast<int>(term.spline.PieceOf(time_s));
    for (int k = 0; k < 4; ++k) add(term.first_block + first + k);
    columns->column_count += 4 * term.component_count;
  }
}

void GatherColumns(const ParameterLayout& layout,
                   const LookColumns& columns,
                   const Eigen::VectorXd& x,
                   double* local) {
  for (int b = 0; b < columns.block_count; ++b) {
    const ParameterBlock& block =
        layout.blocks[static_cast<std::size_t>(columns.block[static_cast<std::size_t>(b)])];
    for (int i = 0; i < block.size; ++i) *local++ = x[block.offset + i];
  }
}

bool LookModel::Evaluate(const LookState& at,
                         const LookWeights& weights,
                         LookEvaluation* out,
                         LookCurvature* curvature) const {
  const Looks& looks = block_.looks;
  const std::size_t pass = looks.pass[at.look];
  const PassCorrections& c = layout_.passes[pass];
  const double* x = at.x;
  const double measured_s = looks.time_s[at.look];
  const double read_s = paths_.ReadingTime_s(pass, measured_s);
  const double path_s = measured_s + SumOf(c.time_bias, x);
  const double biased_s = path_s - read_s;
  const Beyond beyond = BeyondPath(pass, path_s);
  PathReading path;
  if (beyond == Beyond::kFar || !paths_.Read(pass, measured_s, read_s, x, &path)) return false;
  AxisTurn turn;
  turn.used = !c.velocity_across.empty() || !c.velocity_up.empty();
  if (turn.used) {
    const double across = SumOf(c.velocity_across, x), up = SumOf(c.velocity_up, x);
    turn.value = across * path.axes->col(1) + up * path.axes->col(2);
    if (path.turning) {
      turn.rate = across * path.turning->rate.col(1) + up * path.turning->rate.col(2);
    }
  }
  // An exact time has no error to be found: the path is continued to it.
  const bool exact_time = block_.MeasuresDoppler(at.look);
  const double exact_s = exact_time ? biased_s : 0.0;
  if (exact_s != 0.0) {
    path.motion = path.motion.After(exact_s);
    turn.value += exact_s * turn.rate;
  }
  // d = (start - s) + displacement keeps the digits of a small displacement.
  const Eigen::Vector3d d_before = (at.start_m - path.motion.position_m) + at.displacement_m;
  Crossing crossing;
  const Cone cone = block_.ConeOf(at.look);
  const double squint_bias_rad = SumOf(c.squint_bias, x);
  const bool found =
      exact_time ? FindDoppler(path.motion,
                               d_before,
                               turn,
                               cone,
                               block_.passes[pass].wavelength_m,
                               squint_bias_rad,
                               &crossing)
                 : FindCrossing(path.motion, d_before, turn, cone, squint_bias_rad, &crossing);
  if (!found) return false;
  if (!exact_time) crossing.error -= biased_s;
  const LookEquations& eq = crossing.eq;
  const double dt_s = crossing.dt_s + exact_s;     // after the reading
  const double slowness = -1.0 / crossing.rate_m;  // dt_p or df_p = slowness de_d

  const double kappa = SumOf(c.range_scale, x);
  Eigen::RowVector3d range_by_p = (1.0 + kappa) * eq.drho_dp;
  Eigen::RowVector3d range_by_s = -range_by_p;
  double range_error_m =
      (eq.rho_m - looks.range_m[at.look]) + SumOf(c.range_bias, x) + kappa * eq.rho_m;
  std::array<SlantMapping, ParameterLayout::kMaxTroposphere> mappings;
  if (!c.troposphere.empty()) {
    const Vertical vertical = DelayVerticalAt(at.start_m + at.displacement_m);
    for (std::size_t q = 0; q < c.troposphere.size(); ++q) {
      const TroposphereTerm& term = c.troposphere[q];
      SlantMapping& mapping = mappings[q];
      if (!EvaluateMapping(vertical, crossing.d_m, eq.rho_m, term.scale_height_m, &mapping)) {
        return false;
      }
      const double zenith_m = x[term.column];
      range_error_m += zenith_m * mapping.value;
      range_by_p += zenith_m * mapping.by_p;
      range_by_s += zenith_m * mapping.by_s;
    }
  }
  // What is left of e_d moves the time, and the time the range; or the Doppler, which moves
  // nothing.
  const double range_rate = exact_time ? 0.0 : range_by_s.dot(crossing.v_mps);
  const double last_step = slowness * eq.doppler_error_m;
  const double wr = weights.range_per_m, wt = weights.azimuth_per_unit;
  out->whitened_error = {wr * (range_error_m + range_rate * last_step),
                         wt * (crossing.error + last_step)};
  out->azimuth_unit_m = -crossing.rate_m;
  out->beyond_path = beyond == Beyond::kNear;
  // Of a partial of e_r and one of e_d: those of range and of time or Doppler.
  const double of_azimuth = wt * slowness, of_range = wr * range_rate * slowness;
  out->d_point.row(0) = wr * range_by_p + of_range * eq.ded_dp;
  out->d_point.row(1) = of_azimuth * eq.ded_dp;
  if (curvature != nullptr) {
    if (exact_time) {
      SetCurvatureOfDoppler(crossing, block_.passes[pass].wavelength_m, curvature);
    } else {
      const Motion& motion = path.motion;
      SetCurvature(
          crossing, motion.acceleration_mps2 + crossing.dt_s * motion.jerk_mps3, curvature);
    }
    for (auto& row : curvature->row) {
      std::fill_n(row.begin(), static_cast<std::size_t>(at.columns.column_count), 0.0);
    }
  }
  if (at.columns.column_count == 0) return out->whitened_error.allFinite();

  if (path.term_count > 0) {
    // Cone axis v_cone by velocity: dv_cone = dv + (u.dv) t; so e_d by v is cone_by_v.
    Eigen::RowVector3d cone_by_v = eq.ded_dv;
    if (turn.used) {
      cone_by_v += eq.ded_dv.dot(crossing.turn) / crossing.speed_mps * crossing.v_mps.transpose();
    }
    TwoRows by_s, by_v;
    by_s << wr * range_by_s - of_range * eq.ded_dp, -of_azimuth * eq.ded_dp;
    by_v << of_range * cone_by_v, of_azimuth * cone_by_v;
    SetPathColumns(path, by_s, by_v, dt_s, out->row.data());
    for (std::size_t pair = 0; curvature != nullptr && pair < 3; ++pair) {
      by_s.setZero();
      by_v.setZero();
      for (std::size_t k = 0; k < 2; ++k) {
        const auto axis = static_cast<Eigen::Index>(2 * pair + k);
        if (axis < 3) {
          by_s(static_cast<Eigen::Index>(k), axis) = -1.0;
        } else {
          by_v(static_cast<Eigen::Index>(k), axis - 3) = 1.0;
        }
      }
      SetPathColumns(path, by_s, by_v, dt_s, &curvature->row[2 * pair]);
    }
  }
  const auto set = [&](int column, double range, double doppler) {
    const auto i = static_cast<std::size_t>(column);
    out->row[0][i] = wr * range + of_range * doppler;
    out->row[1][i] = of_azimuth * doppler;
  };
  if (turn.used) {
    const auto set_turn = [&](const std::vector<int>& columns, Eigen::Index axis) {
      Eigen::Vector3d direction = path.axes->col(axis);
      if (path.turning) direction += dt_s * path.turning->rate.col(axis);
      for (const int column : columns) {
        set(column, 0.0, crossing.speed_mps * eq.ded_dv.dot(direction));
        if (curvature != nullptr) {
          for (std::size_t k = 0; k < 3; ++k) {
            curvature->row[3 + k][static_cast<std::size_t>(column)] =
                crossing.speed_mps * direction[static_cast<Eigen::Index>(k)];
          }
        }
      }
    };
    set_turn(c.velocity_across, 1);
    set_turn(c.velocity_up, 2);
  }
  for (const int column : c.range_bias) set(column, 1.0, 0.0);
  for (const int column : c.range_scale) set(column, eq.rho_m, 0.0);
  for (const int column : c.time_bias) {
    if (exact_time) {
      set(column, range_by_s.dot(crossing.v_mps), crossing.path_rate_mps);
      continue;
    }
    out->row[0][static_cast<std::size_t>(column)] = 0.0;  // a path read later is met earlier
    out->row[1][static_cast<std::size_t>(column)] = -wt;
  }
  for (const int column : c.squint_bias) set(column, 0.0, eq.ded_dtau_m);
  for (std::size_t q = 0; q < c.troposphere.size(); ++q) {
    set(c.troposphere[q].column, mappings[q].value, 0.0);
  }
  return out->whitened_error.allFinite();
}

LookModel::Beyond LookModel::BeyondPath(std::size_t pass, double path_s) const {
  const FlightPath& path = paths_.PathOf(pass);
  const double start_s = path.start_s(), end_s = path.end_s(), most_s = end_s - start_s;
  if (path_s >= start_s && path_s <= end_s) return Beyond::kInside;
  return path_s >= start_s - most_s && path_s <= end_s + most_s ? Beyond::kNear : Beyond::kFar;
}

std::optional<CorrectedMotion> LookModel::ReadMotion(std::size_t pass,
                                                     double measured_s,
                                                     double read_s,
                                                     double path_s,
                                                     const Eigen::VectorXd& x) const {
  if (BeyondPath(pass, path_s) != Beyond::kInside) return std::nullopt;
  LookColumns columns;
  ColumnsAt(pass, measured_s, &columns);
  std::array<double, ParameterLayout::kMaxLocalColumns> local;
  GatherColumns(layout_, columns, x, local.data());
  PathReading path;
  if (!paths_.Read(pass, measured_s, read_s, local.data(), &path)) return std::nullopt;
  const double later_s = path_s - read_s;
  return CorrectedMotion{later_s == 0.0 ? path.motion : path.motion.After(later_s), path_s};
}

std::optional<CorrectedMotion> LookModel::CorrectedMotionAt(std::size_t pass,
                                                            double time_s,
                                                            const Eigen::VectorXd& x) const {
  const double path_s = time_s + layout_.TimeBias_s(pass, x);
  return ReadMotion(pass, time_s, paths_.ReadingTime_s(pass, time_s), path_s, x);
}

std::optional<CorrectedMotion> LookModel::CorrectedMotionAtPathTime(
    std::size_t pass, double measured_s, double path_s, const Eigen::VectorXd& x) const {
  return ReadMotion(pass, measured_s, path_s, path_s, x);
}

std::optional<FixedPathLook> LookModel::FixPath(std::size_t look, const Eigen::VectorXd& x) const {
  const Looks& looks = block_.looks;
  const std::size_t pass = looks.pass[look];
  const std::optional<CorrectedMotion> corrected = CorrectedMotionAt(pass, looks.time_s[look], x);
  if (!corrected) return std::nullopt;
  const LookSigma sigma = SigmaOf(look);
  FixedPathLook observation;
  observation.antenna_m = corrected->motion.position_m;
  observation.velocity_mps = corrected->motion.velocity_mps;
  observation.acceleration_mps2 = corrected->motion.acceleration_mps2;
  observation.range_m = looks.range_m[look];
  observation.cone = block_.ConeOf(look);
  observation.side = static_cast<int>(block_.passes[pass].side);
  observation.range_sigma_m = sigma.range_m;
  observation.azimuth_sigma = sigma.azimuth;
  observation.azimuth_in_seconds = sigma.azimuth_unit == AzimuthUnit::kSeconds;
  observation.exact_time = block_.MeasuresDoppler(look);
  if (observation.exact_time) {
    observation.azimuth_sigma *=
        block_.ApproximateAzimuthUnit_m(look, observation.velocity_mps.norm());
  }
  return observation;
}

double LookModel::WorkOf(std::size_t pass) const {
  const PassCorrections& c = layout_.passes[pass];
  const bool geocentric = block_.frame.kind() == FrameKind::kGeocentric;
  double work = paths_.PathOf(pass).IsStraight() ? 100.0 : 105.0;
  if (paths_.AxesTurn(pass)) work += geocentric ? 60.0 : 45.0;
  if (!c.troposphere.empty()) work += geocentric && !simplified_.flat_frame ? 120.0 : 40.0;
  return work;
}

Vertical LookModel::DelayVerticalAt(const Eigen::Vector3d& p_m) const {
  if (!simplified_.flat_frame) return block_.frame.VerticalAt(p_m);
  Vertical plane = middle_;
  plane.height_m += middle_.up.dot(p_m - simplified_.middle_m);
  plane.dup_dp.setZero();
  return plane;
}

}  // namespace sarblock
