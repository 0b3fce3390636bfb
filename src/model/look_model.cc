// SPDX-License-Identifier: Apache-2.0
#include "look_model.h"

#include <cmath>

#include "geometry/look_equations_inline.h"
#include "look_model_inline.h"

namespace sarblock {
namespace {

constexpr std::size_t kMaxBasis = PositionCorrection::kMaxDegree + 1;

/// Values of one term's basis functions with derivatives by time.
struct TermBasis {
  std::array<double, kMaxBasis> value, first, second;
};

double SumOf(const std::vector<int>& columns, std::span<const double> x) {
  double sum = 0.0;
  for (const int column : columns) sum += x[static_cast<std::size_t>(column)];
  return sum;
}

void EvaluatePolynomial(const PassCorrections& pass, int degree, double t_s, TermBasis* out) {
  const double rate = 1.0 / pass.half_length_s;
  if (degree <= 1) {  // the usual offset and drift
    out->value[0] = 1.0;
    out->value[1] = (t_s - pass.middle_s) / pass.half_length_s;
    out->first[0] = 0.0;
    out->first[1] = rate;
    out->second[0] = out->second[1] = 0.0;
    return;
  }
  const std::size_t n = static_cast<std::size_t>(degree) + 1;
  LegendreValues((t_s - pass.middle_s) / pass.half_length_s,
                 {std::span(out->value).first(n),
                  std::span(out->first).first(n),
                  std::span(out->second).first(n)});
  for (std::size_t k = 0; k < n; ++k) {
    out->first[k] *= rate;
    out->second[k] *= rate * rate;
  }
}

/// The four spline functions of the piece that holds the measured time, at the path's time t.
void EvaluateSpline(const SplineTerm& term, double measured_s, double t_s, TermBasis* out) {
  term.spline.EvaluatePiece(term.spline.PieceOf(measured_s),
                            t_s,
                            {std::span(out->value).first(4),
                             std::span(out->first).first(4),
                             std::span(out->second).first(4)});
}

/// Sum of the corrections along three axes, with time derivatives.
struct AxisSums {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Vector3d second = Eigen::Vector3d::Zero();
  bool used = false;
  void Add(int axis, double coefficient, const TermBasis& basis, std::size_t k, bool accelerated) {
    value[axis] += coefficient * basis.value[k];
    first[axis] += coefficient * basis.first[k];
    if (accelerated) second[axis] += coefficient * basis.second[k];
  }
};

/// Calls f(axis, basis index, local column) for each parameter of a term, in column order.
template <typename F>
void ForEachColumn(const PolynomialTerm& term, F&& f) {
  int column = term.column;
  for (int axis = 0; axis < 3; ++axis) {
    if (!term.components[static_cast<std::size_t>(axis)]) continue;
    for (int k = 0; k <= term.degree; ++k) f(axis, static_cast<std::size_t>(k), column++);
  }
}

template <typename F>
void ForEachColumn(const SplineTerm& term, int first_column, F&& f) {
  int column = first_column;
  for (std::size_t k = 0; k < 4; ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      if (term.components[static_cast<std::size_t>(axis)]) f(axis, k, column++);
    }
  }
}

/// Everything about the corrected path that both observation equations need.
struct PathEvaluation {
  Motion motion;  // corrected; jerk unused
  bool turns = false;
  TrackAxes axes;  // of the nominal path where it `turns`: where a term needs them
  std::array<TermBasis, ParameterLayout::kMaxPolynomials> polynomial;
  std::array<TermBasis, ParameterLayout::kMaxSplines> spline;
};

/// `accelerated`: the corrected acceleration is wanted too. `held_axes_1`: where the track axes do
/// not turn, else null.
bool EvaluatePath(const Frame& frame_of_block,
                  const FlightPath& nominal,
                  const Eigen::Matrix3d* held_axes_1,
                  const PassCorrections& corrections,
                  double measured_s,
                  double path_s,
                  std::span<const double> x,
                  bool accelerated,
                  PathEvaluation* out) {
  if (!nominal.Evaluate(path_s, &out->motion)) return false;
  out->turns = corrections.NeedsTrackAxes();
  if (out->turns && held_axes_1 != nullptr) {
    out->axes = {.axes_1 = *held_axes_1};
  } else if (out->turns) {
    out->axes = accelerated ? TrackAxesOf(frame_of_block, out->motion)
                            : TrackAxesWithRate(frame_of_block, out->motion);
  }
  if (corrections.polynomials.empty() && corrections.splines.empty()) return true;

  AxisSums track, frame;
  const auto sums_of = [&](PositionCorrection::Axes axes) {
    AxisSums* sums = axes == PositionCorrection::Axes::kTrack ? &track : &frame;
    sums->used = true;
    return sums;
  };
  for (std::size_t q = 0; q < corrections.polynomials.size(); ++q) {
    const PolynomialTerm& term = corrections.polynomials[q];
    EvaluatePolynomial(corrections, term.degree, path_s, &out->polynomial[q]);
    AxisSums* sums = sums_of(term.axes);
    ForEachColumn(term, [&](int axis, std::size_t k, int column) {
      sums->Add(axis, x[static_cast<std::size_t>(column)], out->polynomial[q], k, accelerated);
    });
  }
  int column_begin = corrections.static_columns;
  for (std::size_t q = 0; q < corrections.splines.size(); ++q) {
    const SplineTerm& term = corrections.splines[q];
    EvaluateSpline(term, measured_s, path_s, &out->spline[q]);
    AxisSums* sums = sums_of(term.axes);
    ForEachColumn(term, column_begin, [&](int axis, std::size_t k, int column) {
      sums->Add(axis, x[static_cast<std::size_t>(column)], out->spline[q], k, accelerated);
    });
    column_begin += 4 * term.component_count;
  }
  // delta = A c + f and its time derivatives; A turns with the track (docs/theory/flight_path.md).
  Motion& motion = out->motion;
  if (track.used) {
    const TrackAxes& a = out->axes;
    motion.position_m += a.axes_1 * track.value;
    motion.velocity_mps += a.rate * track.value + a.axes_1 * track.first;
    if (accelerated) {
      motion.acceleration_mps2 +=
          a.acceleration * track.value + 2.0 * (a.rate * track.first) + a.axes_1 * track.second;
    }
  }
  if (frame.used) {
    motion.position_m += frame.value;
    motion.velocity_mps += frame.first;
    if (accelerated) motion.acceleration_mps2 += frame.second;
  }
  return out->motion.position_m.allFinite() && out->motion.velocity_mps.allFinite();
}

/// Slant delay mapping m(p) = exp(-h/H) / cos(incidence) and its partials; false where the sight
/// line does not come from above.
struct SlantMapping {
  double value;
  Eigen::RowVector3d by_p, by_s;
};

bool EvaluateMapping(const Vertical& vertical,
                     const Eigen::Vector3d& d_m,
                     double rho_m,
                     double scale_height_m,
                     SlantMapping* out) {
  const double drop_m = -vertical.up_1.dot(d_m);  // rho cos(incidence)
  if (!(drop_m > 1e-6 * rho_m)) return false;
  const double thinning = std::exp(-vertical.height_m / scale_height_m);
  const Eigen::RowVector3d sight = (d_m / rho_m).transpose();
  const Eigen::RowVector3d ddrop_dp =
      -vertical.up_1.transpose() - (vertical.dup_dp * d_m).transpose();
  const double m = thinning * rho_m / drop_m;
  out->value = m;
  out->by_p = (-m / scale_height_m) * vertical.up_1.transpose() + (thinning / drop_m) * sight -
              (m / drop_m) * ddrop_dp;
  out->by_s = (-thinning / drop_m) * sight - (m / drop_m) * vertical.up_1.transpose();
  return true;
}

/// What of a pass the straight route needs; not `applies` where anything else corrects it.
StraightPass StraightPassOf(const Block& block,
                            const FlightPath& path,
                            const Eigen::Matrix3d* held_axes_1,
                            const PassCorrections& corrections) {
  StraightPass out;
  out.curved = !path.IsStraight();
  const bool turns =
      held_axes_1 == nullptr && (block.frame.kind() != FrameKind::kLocal || out.curved);
  out.applies = !turns && corrections.splines.empty() && corrections.polynomials.size() <= 1 &&
                corrections.velocity_across.empty() && corrections.velocity_up.empty() &&
                corrections.time_bias.empty() && corrections.squint_bias.empty() &&
                corrections.troposphere.empty();
  if (!out.applies) return out;
  const StateVector& first = path.states().front();
  out.start_s = path.start_s();
  out.end_s = path.end_s();
  out.position_m = first.position_m;
  out.velocity_mps = first.velocity_mps;
  if (corrections.polynomials.empty()) return out;
  const PolynomialTerm& term = corrections.polynomials[0];
  if (term.axes == PositionCorrection::Axes::kTrack && held_axes_1 != nullptr) {
    out.axes_1 = *held_axes_1;
  } else if (term.axes == PositionCorrection::Axes::kTrack) {
    Motion motion;
    motion.position_m = first.position_m;
    motion.velocity_mps = first.velocity_mps;
    out.axes_1 = TrackAxesWithRate(block.frame, motion).axes_1;
  }
  out.applies = term.degree <= 1 && out.axes_1.allFinite();
  return out;
}

}  // namespace

LookModel::LookModel(const Block& block,
                     const ParameterLayout& layout,
                     const Simplified& simplified)
    : block_(block), layout_(layout), simplified_(simplified) {
  if (simplified.flat_frame) middle_ = block.frame.VerticalAt(simplified.middle_m);
  if (simplified.linear_velocity) {
    for (const Pass& pass : block.passes) straightened_.push_back(StraightenedPath(pass));
  }
  straight_.reserve(block.passes.size());
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    if (simplified.fixed_track_axes) {
      held_axes_1_.push_back(AxesInTheMiddle(block.frame, PathOf(pass), block.passes[pass]));
    }
    straight_.push_back(StraightPassOf(block, PathOf(pass), HeldAxesOf(pass), layout.passes[pass]));
  }
}

LookSigma LookModel::SigmaOf(std::size_t look) const {
  LookSigma sigma = block_.SigmaOf(look);
  if (!sigma_factor_1_.empty()) {
    const std::array<double, 2>& factor = sigma_factor_1_[block_.looks.pass[look]];
    sigma.range_m *= factor[0];
    sigma.azimuth *= factor[1];
  }
  return sigma;
}

Cone LookModel::ConeOf(std::size_t look) const {
  Cone cone;
  const Looks& looks = block_.looks;
  if (looks.cone.empty()) return cone;
  if ((looks.flags[look] & Looks::kDoppler) != 0) {
    cone.kind = Cone::Kind::kDoppler;
    cone.closing_mps = 0.5 * block_.passes[looks.pass[look]].wavelength_m * looks.cone[look];
  } else {
    cone.squint_rad = looks.cone[look];
  }
  return cone;
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

bool LookModel::Evaluate(std::size_t look,
                         const LookColumns& columns,
                         const Eigen::Vector3d& start_m,
                         const Eigen::Vector3d& displacement_m,
                         std::span<const double> x,
                         LookEvaluation* out) const {
  constexpr Whitening kMetres{1.0, 0.0, 1.0};
  return Evaluate(look,
                  columns,
                  start_m,
                  displacement_m,
                  x,
                  kMetres,
                  &out->error_m,
                  &out->by_point,
                  {out->by_columns.row(0).data(), out->by_columns.row(1).data()});
}

bool LookModel::EvaluateStraight(std::size_t look,
                                 const StraightPass& straight,
                                 const Eigen::Vector3d& start_m,
                                 const Eigen::Vector3d& displacement_m,
                                 std::span<const double> x,
                                 const Whitening& w,
                                 Eigen::Vector2d* error_m,
                                 Eigen::Matrix<double, 2, 3>* by_point,
                                 LookRows rows) const {
  const Looks& looks = block_.looks;
  const PassCorrections& c = layout_.passes[looks.pass[look]];
  const AdjustedTime adjusted = TimeOf(look);
  const double time_s = looks.time_s[look] + adjusted.shift_s;
  if (!(time_s >= straight.start_s && time_s <= straight.end_s)) return false;
  const double from_start_s = time_s - straight.start_s;
  Eigen::Vector3d s_m = straight.position_m + from_start_s * straight.velocity_mps;
  Eigen::Vector3d v_mps = straight.velocity_mps;
  if (straight.curved) {
    Motion nominal;
    if (!PathOf(looks.pass[look]).Evaluate(time_s, &nominal)) return false;
    s_m = nominal.position_m;
    v_mps = nominal.velocity_mps;
  }
  const PolynomialTerm* term = c.polynomials.empty() ? nullptr : c.polynomials.data();
  const double rate = 1.0 / c.half_length_s;
  const double basis_1 = (time_s - c.middle_s) * rate;
  if (term != nullptr) {
    const double* value = x.data() + term->column;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (!term->components[static_cast<std::size_t>(axis)]) continue;
      if (term->degree == 0) {
        s_m += straight.axes_1.col(axis) * *value++;
      } else {
        s_m += straight.axes_1.col(axis) * (value[0] + basis_1 * value[1]);
        v_mps += straight.axes_1.col(axis) * (rate * value[1]);
        value += 2;
      }
    }
  }
  LookEquations eq;
  const Eigen::Vector3d d_m = (start_m - s_m) + displacement_m;
  if (!EvaluateLookEquationsInline(d_m, v_mps, ConeOf(look), 0.0, &eq)) return false;
  const double kappa = SumOf(c.range_scale, x);
  const Eigen::RowVector3d range_by_p = (1.0 + kappa) * eq.drho_dp;
  *error_m = {(eq.rho_m - looks.range_m[look]) + SumOf(c.range_bias, x) + kappa * eq.rho_m -
                  adjusted.range_m(),
              eq.doppler_error_m - adjusted.doppler_m()};
  by_point->row(0) = w.w00 * range_by_p;
  by_point->row(1) = w.w10 * range_by_p + w.w11 * eq.ded_dp;
  if (rows.range != nullptr) {
    FillStraightRows(straight, c, time_s, eq, w, *by_point, rows);
  }
  return error_m->allFinite();
}

bool LookModel::Evaluate(std::size_t look,
                         const LookColumns& columns,
                         const Eigen::Vector3d& start_m,
                         const Eigen::Vector3d& displacement_m,
                         std::span<const double> x,
                         const Whitening& w,
                         Eigen::Vector2d* error_m,
                         Eigen::Matrix<double, 2, 3>* by_point,
                         LookRows rows) const {
  const Looks& looks = block_.looks;
  const std::size_t pass = looks.pass[look];
  if (straight_[pass].applies) {
    return EvaluateStraight(
        look, straight_[pass], start_m, displacement_m, x, w, error_m, by_point, rows);
  }
  const PassCorrections& c = layout_.passes[pass];
  const double measured_s = looks.time_s[look];
  const AdjustedTime adjusted = TimeOf(look);
  PathEvaluation path;
  if (!EvaluatePath(block_.frame,
                    PathOf(pass),
                    HeldAxesOf(pass),
                    c,
                    measured_s,
                    measured_s + adjusted.shift_s + SumOf(c.time_bias, x),
                    x,
                    !c.time_bias.empty(),
                    &path)) {
    return false;
  }
  const Motion& motion = path.motion;
  // The direction errors of the cone axis: t = c_across across + c_up up, v_cone = v + |v| t.
  const bool turned = !c.velocity_across.empty() || !c.velocity_up.empty();
  const double speed = motion.velocity_mps.norm();
  const Eigen::Vector3d u = motion.velocity_mps * (1.0 / speed);
  Eigen::Vector3d turn = Eigen::Vector3d::Zero(), turn_rate = Eigen::Vector3d::Zero();
  if (turned) {
    const double across = SumOf(c.velocity_across, x), up = SumOf(c.velocity_up, x);
    turn = across * path.axes.axes_1.col(1) + up * path.axes.axes_1.col(2);
    turn_rate = across * path.axes.rate.col(1) + up * path.axes.rate.col(2);
  }
  // d = (start - s) + displacement keeps the digits of a small displacement.
  const Eigen::Vector3d to_start = start_m - motion.position_m;
  LookEquations eq;
  const Eigen::Vector3d d = to_start + displacement_m;
  if (!EvaluateLookEquationsInline(
          d, motion.velocity_mps + speed * turn, ConeOf(look), SumOf(c.squint_bias, x), &eq)) {
    return false;
  }
  const double kappa = SumOf(c.range_scale, x);
  Eigen::RowVector3d range_by_p = (1.0 + kappa) * eq.drho_dp;
  Eigen::RowVector3d range_by_s = -range_by_p;
  double range_error_m =
      (eq.rho_m - looks.range_m[look]) + SumOf(c.range_bias, x) + kappa * eq.rho_m;
  std::array<SlantMapping, ParameterLayout::kMaxTroposphere> mappings;
  if (!c.troposphere.empty()) {
    const Vertical vertical = DelayVerticalAt(start_m + displacement_m);
    for (std::size_t q = 0; q < c.troposphere.size(); ++q) {
      const TroposphereTerm& term = c.troposphere[q];
      if (!EvaluateMapping(vertical, d, eq.rho_m, term.scale_height_m, &mappings[q])) return false;
      const double zenith_m = x[static_cast<std::size_t>(term.column)];
      range_error_m += zenith_m * mappings[q].value;
      range_by_p += zenith_m * mappings[q].by_p;
      range_by_s += zenith_m * mappings[q].by_s;
    }
  }
  *error_m = {range_error_m - adjusted.range_m(), eq.doppler_error_m - adjusted.doppler_m()};
  by_point->row(0) = w.w00 * range_by_p;
  by_point->row(1) = w.w10 * range_by_p + w.w11 * eq.ded_dp;
  if (columns.column_count == 0 || rows.range == nullptr) return error_m->allFinite();

  // Cone axis v_cone by velocity: dv_cone = dv + (u.dv) t; so e_d by v is cone_by_v.
  const Eigen::RowVector3d cone_by_v = eq.ded_dv + eq.ded_dv.dot(turn) * u.transpose();
  const auto set = [&](int column, double range, double doppler) {
    rows.range[column] = w.w00 * range;
    rows.doppler[column] = w.w10 * range + w.w11 * doppler;
  };
  // A position parameter moves s by its axis times B and v by (axis B)': three numbers an axis
  // serve all its degrees.
  struct AxisPartials {
    Eigen::RowVector3d range_by_s, doppler_by_value, doppler_by_rate;
  };
  const Eigen::RowVector3d doppler_by_s = -eq.ded_dp;
  const AxisPartials frame{range_by_s, doppler_by_s, cone_by_v};
  AxisPartials track;
  if (path.turns) {
    track = {range_by_s * path.axes.axes_1,
             doppler_by_s * path.axes.axes_1 + cone_by_v * path.axes.rate,
             cone_by_v * path.axes.axes_1};
  }
  const auto set_position = [&](PositionCorrection::Axes axes,
                                const TermBasis& basis,
                                int axis,
                                std::size_t k,
                                int column) {
    const AxisPartials& by = axes == PositionCorrection::Axes::kFrame ? frame : track;
    set(column,
        by.range_by_s[axis] * basis.value[k],
        by.doppler_by_value[axis] * basis.value[k] + by.doppler_by_rate[axis] * basis.first[k]);
  };
  for (std::size_t q = 0; q < c.polynomials.size(); ++q) {
    const PolynomialTerm& term = c.polynomials[q];
    ForEachColumn(term, [&](int axis, std::size_t k, int column) {
      set_position(term.axes, path.polynomial[q], axis, k, column);
    });
  }
  int column_begin = c.static_columns;
  for (std::size_t q = 0; q < c.splines.size(); ++q) {
    const SplineTerm& term = c.splines[q];
    ForEachColumn(term, column_begin, [&](int axis, std::size_t k, int column) {
      set_position(term.axes, path.spline[q], axis, k, column);
    });
    column_begin += 4 * term.component_count;
  }
  for (const int column : c.velocity_across) {
    set(column, 0.0, speed * eq.ded_dv.dot(path.axes.axes_1.col(1)));
  }
  for (const int column : c.velocity_up) {
    set(column, 0.0, speed * eq.ded_dv.dot(path.axes.axes_1.col(2)));
  }
  for (const int column : c.range_bias) set(column, 1.0, 0.0);
  for (const int column : c.range_scale) set(column, eq.rho_m, 0.0);
  for (const int column : c.time_bias) {
    const Eigen::Vector3d& a = motion.acceleration_mps2;
    const Eigen::Vector3d cone_rate = a + u.dot(a) * turn + speed * turn_rate;
    set(column,
        range_by_s.dot(motion.velocity_mps),
        -eq.ded_dp.dot(motion.velocity_mps) + eq.ded_dv.dot(cone_rate));
  }
  for (const int column : c.squint_bias) set(column, 0.0, eq.ded_dtau_m);
  for (std::size_t q = 0; q < c.troposphere.size(); ++q) {
    set(c.troposphere[q].column, mappings[q].value, 0.0);
  }
  return error_m->allFinite();
}

std::optional<CorrectedMotion> LookModel::CorrectedMotionAt(std::size_t pass,
                                                            double time_s,
                                                            const Eigen::VectorXd& x) const {
  double path_s = time_s;
  const PassCorrections& c = layout_.passes[pass];
  if (!c.time_bias.empty()) {
    LookColumns columns;
    ColumnsAt(pass, time_s, &columns);
    std::array<double, ParameterLayout::kMaxLocalColumns> local;
    GatherColumns(layout_, columns, x, local.data());
    path_s += SumOf(c.time_bias, local);
  }
  return CorrectedMotionAtPathTime(pass, time_s, path_s, x);
}

std::optional<CorrectedMotion> LookModel::CorrectedMotionAtPathTime(
    std::size_t pass, double measured_s, double path_s, const Eigen::VectorXd& x) const {
  LookColumns columns;
  ColumnsAt(pass, measured_s, &columns);
  std::array<double, ParameterLayout::kMaxLocalColumns> local;
  GatherColumns(layout_, columns, x, local.data());
  PathEvaluation path;
  if (!EvaluatePath(block_.frame,
                    PathOf(pass),
                    HeldAxesOf(pass),
                    layout_.passes[pass],
                    measured_s,
                    path_s,
                    local,
                    true,
                    &path)) {
    return std::nullopt;
  }
  return CorrectedMotion{path.motion, path_s};
}

std::optional<Sight> LookModel::SightOf(std::size_t look, const Eigen::VectorXd& x) const {
  const Looks& looks = block_.looks;
  const std::size_t pass = looks.pass[look];
  const std::optional<CorrectedMotion> corrected = CorrectedMotionAt(pass, looks.time_s[look], x);
  if (!corrected) return std::nullopt;
  const LookSigma sigma = SigmaOf(look);
  Sight sight;
  sight.antenna_m = corrected->motion.position_m;
  sight.velocity_mps = corrected->motion.velocity_mps;
  sight.acceleration_mps2 = corrected->motion.acceleration_mps2;
  sight.range_m = looks.range_m[look];
  sight.cone = ConeOf(look);
  sight.side = static_cast<int>(block_.passes[pass].side);
  sight.range_sigma_m = sigma.range_m;
  sight.azimuth_sigma = sigma.azimuth;
  sight.azimuth_in_seconds = sigma.azimuth_unit == AzimuthUnit::kSeconds;
  return sight;
}

double LookModel::WorkOf(std::size_t pass) const {
  const PassCorrections& c = layout_.passes[pass];
  if (straight_[pass].applies) return straight_[pass].curved ? 75.0 : 60.0;
  const bool geocentric = block_.frame.kind() == FrameKind::kGeocentric;
  double work = 120.0;
  if (c.NeedsTrackAxes()) {
    const bool turns = held_axes_1_.empty() && (geocentric || !PathOf(pass).IsStraight());
    const double axes = !turns ? 10.0 : geocentric ? 150.0 : 50.0;
    work += c.time_bias.empty() ? axes : 1.5 * axes;
  }
  if (!c.troposphere.empty()) work += geocentric && !simplified_.flat_frame ? 120.0 : 40.0;
  return work;
}

Vertical LookModel::DelayVerticalAt(const Eigen::Vector3d& p_m) const {
  if (!simplified_.flat_frame) return block_.frame.VerticalAt(p_m);
  Vertical plane = middle_;
  plane.height_m += middle_.up_1.dot(p_m - simplified_.middle_m);
  plane.dup_dp.setZero();
  return plane;
}

}  // namespace sarblock
