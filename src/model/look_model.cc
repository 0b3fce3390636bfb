// SPDX-License-Identifier: Apache-2.0
#include "look_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/look_equations_inline.h"

namespace sarblock {
namespace {

constexpr std::size_t kMaxBasis = PositionCorrection::kMaxDegree + 1;
/// A point this near its cone, as a part of the range, is on it: a step beyond moves neither error
/// nor partial by more than rounding does.
constexpr double kOnCone_1 = 1e-12;
/// The same where rounding of coordinates keeps it from coming nearer.
constexpr double kRoundingOnCone_1 = 1e-8;
constexpr int kMostConeSteps = 30;
/// Least rate, as a part of the speed, at which the cone passes over a point: flatter, a step would
/// go anywhere. At the solution flatter means that the cone turns with the point.
constexpr double kLeastConeRate_1 = 0.02;

/// Values of one term's basis functions with derivatives by time.
struct TermBasis {
  std::array<double, kMaxBasis> value, first, second;
};

double SumOf(const std::vector<int>& columns, const double* x) {
  double sum = 0.0;
  for (const int column : columns) sum += x[column];
  return sum;
}

void EvaluatePolynomial(const PassCorrections& pass, int degree, double t_s, TermBasis* out) {
  const double rate = 1.0 / pass.half_length_s;
  if (degree <= 1) {  // the usual offset and drift
    out->value[0] = 1.0;
    out->value[1] = (t_s - pass.middle_s) * rate;
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
  void Add(int axis, double coefficient, const TermBasis& basis, std::size_t k) {
    value[axis] += coefficient * basis.value[k];
    first[axis] += coefficient * basis.first[k];
    second[axis] += coefficient * basis.second[k];
  }
};

/// Calls f(axis, basis index, local column) for each parameter of a term, in column order.
template <typename F>
inline void ForEachColumn(const PolynomialTerm& term, F&& f) {
  int column = term.column;
  for (int axis = 0; axis < 3; ++axis) {
    if (!term.components[static_cast<std::size_t>(axis)]) continue;
    for (int k = 0; k <= term.degree; ++k) f(axis, static_cast<std::size_t>(k), column++);
  }
}

template <typename F>
inline void ForEachColumn(const SplineTerm& term, int first_column, F&& f) {
  int column = first_column;
  for (std::size_t k = 0; k < 4; ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      if (term.components[static_cast<std::size_t>(axis)]) f(axis, k, column++);
    }
  }
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

/// Partials of an error by position and velocity of the antenna, turned to axes A: by a parameter
/// that moves the path by A B it is by[0] B + by[1] B' + by[2] B''.
struct AxisPartials {
  std::array<Eigen::RowVector3d, 3> by;
};

/// The parameter moves the antenna by A B at the measured time, by (A B) + (A B)' dt + (A B)''
/// dt^2/2 a time dt later, and its velocity by the derivative of that.
AxisPartials TurnToAxes(const TrackAxes& axes,
                        bool constant,
                        const Eigen::RowVector3d& by_s,
                        const Eigen::RowVector3d& by_v,
                        double dt_s) {
  const double half_s2 = 0.5 * dt_s * dt_s;
  const Eigen::RowVector3d s0 = by_s * axes.axes_1, v0 = by_v * axes.axes_1;
  AxisPartials out;
  out.by[0] = s0;
  out.by[1] = dt_s * s0 + v0;
  out.by[2] = half_s2 * s0 + dt_s * v0;
  if (constant) return out;
  const Eigen::RowVector3d s1 = by_s * axes.rate, v1 = by_v * axes.rate;
  out.by[0] +=
      dt_s * s1 + v1 + half_s2 * (by_s * axes.acceleration) + dt_s * (by_v * axes.acceleration);
  out.by[1] += (2.0 * half_s2) * s1 + (2.0 * dt_s) * v1;
  return out;
}

AxisPartials InFrame(const Eigen::RowVector3d& by_s, const Eigen::RowVector3d& by_v, double dt_s) {
  return {{by_s, dt_s * by_s + by_v, (0.5 * dt_s * dt_s) * by_s + dt_s * by_v}};
}

}  // namespace

/// Everything about the corrected path at the measured time that both observation equations need.
struct LookModel::Reading {
  Motion motion;         // corrected; jerk of the nominal path
  bool turns = false;    // track axes are needed
  bool constant = true;  // and do not turn
  bool beyond_path = false;
  TrackAxes axes;
  std::array<TermBasis, ParameterLayout::kMaxPolynomials> polynomial;
  std::array<TermBasis, ParameterLayout::kMaxSplines> spline;
};

std::vector<double> LargestRanges_m(const Block& block) {
  std::vector<double> out(block.passes.size(), 0.0);
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    double& largest_m = out[block.looks.pass[i]];
    if (block.looks.range_m[i] > largest_m) largest_m = block.looks.range_m[i];  // NaN: no
  }
  return out;
}

std::vector<double> ConeTurning_1(const FlightPath& path, double range_m) {
  std::vector<double> out(path.piece_count());
  for (std::size_t k = 0; k < out.size(); ++k) {
    const double square = path.PieceVelocity_mps(k).squaredNorm();
    out[k] = path.AccelerationMisfit_mps2(k) * range_m / square;
  }
  return out;
}

LookModel::LookModel(const Block& block,
                     const ParameterLayout& layout,
                     const Simplified& simplified)
    : block_(block), layout_(layout), simplified_(simplified) {
  if (simplified.flat_frame) middle_ = block.frame.VerticalAt(simplified.middle_m);
  if (simplified.linear_velocity) {
    for (const Pass& pass : block.passes) straightened_.push_back(StraightenedPath(pass));
  }
  axes_.resize(block.passes.size());
  const std::vector<double> range_m = LargestRanges_m(block);
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    const std::vector<double> turning_1 = ConeTurning_1(PathOf(pass), range_m[pass]);
    const bool steady = std::all_of(
        turning_1.begin(), turning_1.end(), [](double turn) { return turn <= kMostTurn_1; });
    accelerations_.push_back(steady ? Acceleration::kOfCubic : Acceleration::kOfVelocities);
  }
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    if (!layout.passes[pass].NeedsTrackAxes()) continue;
    const FlightPath& path = PathOf(pass);
    PassAxes& axes = axes_[pass];
    axes.constant = simplified.fixed_track_axes ||
                    (block.frame.kind() == FrameKind::kLocal && path.IsStraight());
    if (axes.constant) {
      axes.axes_1 = AxesInTheMiddle(block.frame, path, block.passes[pass]);
    } else {
      axes.verticals = VerticalTable(block.frame, path);
    }
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

bool LookModel::ReadPath(
    std::size_t pass, double measured_s, double path_s, const double* x, Reading* out) const {
  const PassCorrections& c = layout_.passes[pass];
  const FlightPath& path = PathOf(pass);
  Motion& motion = out->motion;
  std::size_t piece = 0;
  if (!path.Read(path_s, accelerations_[pass], &motion, &piece)) return false;
  out->beyond_path = path_s < path.start_s() || path_s > path.end_s();
  out->turns = c.NeedsTrackAxes();
  if (out->turns) {
    const PassAxes& axes = axes_[pass];
    out->constant = axes.constant;
    if (axes.constant) {
      out->axes.axes_1 = axes.axes_1;
    } else {
      out->axes = TrackAxesOf(axes.verticals.At(piece, path_s), motion);
    }
  }
  if (c.polynomials.empty() && c.splines.empty()) return true;

  AxisSums track, frame;
  const auto sums_of = [&](PositionCorrection::Axes axes) {
    AxisSums* sums = axes == PositionCorrection::Axes::kTrack ? &track : &frame;
    sums->used = true;
    return sums;
  };
  for (std::size_t q = 0; q < c.polynomials.size(); ++q) {
    const PolynomialTerm& term = c.polynomials[q];
    EvaluatePolynomial(c, term.degree, path_s, &out->polynomial[q]);
    AxisSums* sums = sums_of(term.axes);
    ForEachColumn(term, [&](int axis, std::size_t k, int column) {
      sums->Add(axis, x[column], out->polynomial[q], k);
    });
  }
  int column_begin = c.static_columns;
  for (std::size_t q = 0; q < c.splines.size(); ++q) {
    const SplineTerm& term = c.splines[q];
    EvaluateSpline(term, measured_s, path_s, &out->spline[q]);
    AxisSums* sums = sums_of(term.axes);
    ForEachColumn(term, column_begin, [&](int axis, std::size_t k, int column) {
      sums->Add(axis, x[column], out->spline[q], k);
    });
    column_begin += 4 * term.component_count;
  }
  // delta = A c + f and its time derivatives; A turns with the track (docs/theory/flight_path.md).
  if (track.used) {
    const TrackAxes& a = out->axes;
    motion.position_m += a.axes_1 * track.value;
    motion.velocity_mps += a.axes_1 * track.first;
    motion.acceleration_mps2 += a.axes_1 * track.second;
    if (!out->constant) {
      motion.velocity_mps += a.rate * track.value;
      motion.acceleration_mps2 += a.acceleration * track.value + 2.0 * (a.rate * track.first);
    }
  }
  if (frame.used) {
    motion.position_m += frame.value;
    motion.velocity_mps += frame.first;
    motion.acceleration_mps2 += frame.second;
  }
  return motion.position_m.allFinite() && motion.velocity_mps.allFinite();
}

bool LookModel::Evaluate(const LookState& at,
                         const LookWeights& weights,
                         LookEvaluation* out) const {
  const Looks& looks = block_.looks;
  const std::size_t pass = looks.pass[at.look];
  const PassCorrections& c = layout_.passes[pass];
  const double* x = at.x;
  const double measured_s = looks.time_s[at.look];
  Reading path;
  if (!ReadPath(pass, measured_s, measured_s + SumOf(c.time_bias, x), x, &path)) return false;
  const Motion& motion = path.motion;
  // The direction errors of the cone axis: t = c_across across + c_up up, v_cone = v + |v| t.
  const bool turned = !c.velocity_across.empty() || !c.velocity_up.empty();
  Eigen::Vector3d turn_before = Eigen::Vector3d::Zero(), turn_rate = Eigen::Vector3d::Zero();
  if (turned) {
    const double across = SumOf(c.velocity_across, x), up = SumOf(c.velocity_up, x);
    turn_before = across * path.axes.axes_1.col(1) + up * path.axes.axes_1.col(2);
    if (!path.constant) turn_rate = across * path.axes.rate.col(1) + up * path.axes.rate.col(2);
  }
  const Cone cone = ConeOf(at.look);
  const double squint_bias_rad = SumOf(c.squint_bias, x);
  // d = (start - s) + displacement keeps the digits of a small displacement.
  const Eigen::Vector3d d_before = (at.start_m - motion.position_m) + at.displacement_m;

  // The time error: Newton's method on the cone. dt_s after the measured time the antenna is
  // moved_m farther on.
  LookEquations eq;
  Eigen::Vector3d d, v_mps, turn = Eigen::Vector3d::Zero();
  double dt_s = 0.0, speed = 0.0, cone_rate_mps = 0.0, last_off_m = 0.0;
  double first_s = -std::numeric_limits<double>::infinity(), last_s = -first_s;
  for (int step = 0;; ++step) {
    const Eigen::Vector3d turning_mps2 = motion.acceleration_mps2 + (0.5 * dt_s) * motion.jerk_mps3;
    v_mps = motion.velocity_mps + dt_s * turning_mps2;
    d = d_before - dt_s * (motion.velocity_mps + (0.5 * dt_s) * (motion.acceleration_mps2 +
                                                                 (dt_s / 3.0) * motion.jerk_mps3));
    const Eigen::Vector3d a_mps2 = motion.acceleration_mps2 + dt_s * motion.jerk_mps3;
    Eigen::Vector3d axis_mps = v_mps, axis_mps2 = a_mps2;
    if (turned) {
      speed = v_mps.norm();
      turn = turn_before + dt_s * turn_rate;
      axis_mps += speed * turn;
      axis_mps2 += (v_mps.dot(a_mps2) / speed) * turn + speed * turn_rate;
    }
    if (!EvaluateLookEquationsInline(d, axis_mps, cone, squint_bias_rad, &eq)) return false;
    cone_rate_mps = eq.ded_dv.dot(axis_mps2) - eq.ded_dp.dot(v_mps);
    const double off_m = eq.doppler_error_m, size_m = std::abs(off_m);
    if (size_m <= kOnCone_1 * eq.rho_m ||
        (size_m <= kRoundingOnCone_1 * eq.rho_m && step > 1 && size_m > 0.25 * last_off_m)) {
      break;
    }
    if (step == kMostConeSteps) return false;
    last_off_m = size_m;
    // The point is ahead of the cone while e_d > 0.
    (off_m > 0.0 ? first_s : last_s) = dt_s;
    const double least_mps = kLeastConeRate_1 * v_mps.norm();
    double next_s = dt_s + off_m / std::max(-cone_rate_mps, least_mps);
    if (!(next_s > first_s && next_s < last_s)) next_s = 0.5 * (first_s + last_s);
    if (!std::isfinite(next_s)) return false;
    dt_s = next_s;
  }
  if (!(cone_rate_mps < -kLeastConeRate_1 * v_mps.norm())) return false;
  const double slowness = -1.0 / cone_rate_mps;  // dt_p = slowness de_d

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
      if (!EvaluateMapping(vertical, d, eq.rho_m, term.scale_height_m, &mappings[q])) return false;
      const double zenith_m = x[term.column];
      range_error_m += zenith_m * mappings[q].value;
      range_by_p += zenith_m * mappings[q].by_p;
      range_by_s += zenith_m * mappings[q].by_s;
    }
  }
  // What is left of e_d moves the time, and the time the range.
  const double range_rate_mps = range_by_s.dot(v_mps);
  const double last_step_s = slowness * eq.doppler_error_m;
  const double wr = weights.range_per_m, wt = weights.time_per_s;
  out->error_1 = {wr * (range_error_m + range_rate_mps * last_step_s), wt * (dt_s + last_step_s)};
  out->azimuth_mps = -cone_rate_mps;
  out->beyond_path = path.beyond_path;
  // Of a partial of e_r and one of e_d: those of range and time.
  const double of_time = wt * slowness, of_range = wr * range_rate_mps * slowness;
  out->by_point.row(0) = wr * range_by_p + of_range * eq.ded_dp;
  out->by_point.row(1) = of_time * eq.ded_dp;
  if (at.columns.column_count == 0) return out->error_1.allFinite();

  double* range_row = out->row[0].data();
  double* time_row = out->row[1].data();
  const auto set = [&](int column, double range, double doppler) {
    range_row[column] = wr * range + of_range * doppler;
    time_row[column] = of_time * doppler;
  };
  // Cone axis v_cone by velocity: dv_cone = dv + (u.dv) t; so e_d by v is cone_by_v.
  Eigen::RowVector3d cone_by_v = eq.ded_dv;
  if (turned) cone_by_v += eq.ded_dv.dot(turn) / speed * v_mps.transpose();
  const Eigen::RowVector3d time_by_s = -of_time * eq.ded_dp, time_by_v = of_time * cone_by_v;
  const Eigen::RowVector3d both_by_s = wr * range_by_s - of_range * eq.ded_dp;
  const Eigen::RowVector3d both_by_v = of_range * cone_by_v;
  // A position parameter moves the path by its axis times B: three numbers an axis serve all its
  // degrees.
  std::array<AxisPartials, 2> track, frame;  // of range and time
  bool in_track = false, in_frame = false;
  const auto partials_of =
      [&](PositionCorrection::Axes axes) -> const std::array<AxisPartials, 2>& {
    if (axes == PositionCorrection::Axes::kTrack) {
      if (!in_track) {
        track = {TurnToAxes(path.axes, path.constant, both_by_s, both_by_v, dt_s),
                 TurnToAxes(path.axes, path.constant, time_by_s, time_by_v, dt_s)};
        in_track = true;
      }
      return track;
    }
    if (!in_frame) {
      frame = {InFrame(both_by_s, both_by_v, dt_s), InFrame(time_by_s, time_by_v, dt_s)};
      in_frame = true;
    }
    return frame;
  };
  const auto set_position = [&](const std::array<AxisPartials, 2>& by,
                                const TermBasis& basis,
                                int axis,
                                std::size_t k,
                                int column) {
    const double b0 = basis.value[k], b1 = basis.first[k], b2 = basis.second[k];
    range_row[column] = by[0].by[0][axis] * b0 + by[0].by[1][axis] * b1 + by[0].by[2][axis] * b2;
    time_row[column] = by[1].by[0][axis] * b0 + by[1].by[1][axis] * b1 + by[1].by[2][axis] * b2;
  };
  for (std::size_t q = 0; q < c.polynomials.size(); ++q) {
    const PolynomialTerm& term = c.polynomials[q];
    const std::array<AxisPartials, 2>& by = partials_of(term.axes);
    ForEachColumn(term, [&](int axis, std::size_t k, int column) {
      set_position(by, path.polynomial[q], axis, k, column);
    });
  }
  int column_begin = c.static_columns;
  for (std::size_t q = 0; q < c.splines.size(); ++q) {
    const SplineTerm& term = c.splines[q];
    const std::array<AxisPartials, 2>& by = partials_of(term.axes);
    ForEachColumn(term, column_begin, [&](int axis, std::size_t k, int column) {
      set_position(by, path.spline[q], axis, k, column);
    });
    column_begin += 4 * term.component_count;
  }
  if (turned) {
    const auto set_turn = [&](const std::vector<int>& columns, Eigen::Index axis) {
      Eigen::Vector3d direction = path.axes.axes_1.col(axis);
      if (!path.constant) direction += dt_s * path.axes.rate.col(axis);
      for (const int column : columns) set(column, 0.0, speed * eq.ded_dv.dot(direction));
    };
    set_turn(c.velocity_across, 1);
    set_turn(c.velocity_up, 2);
  }
  for (const int column : c.range_bias) set(column, 1.0, 0.0);
  for (const int column : c.range_scale) set(column, eq.rho_m, 0.0);
  for (const int column : c.time_bias) {  // a path read later is met earlier
    range_row[column] = 0.0;
    time_row[column] = -wt;
  }
  for (const int column : c.squint_bias) set(column, 0.0, eq.ded_dtau_m);
  for (std::size_t q = 0; q < c.troposphere.size(); ++q) {
    set(c.troposphere[q].column, mappings[q].value, 0.0);
  }
  return out->error_1.allFinite();
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
    path_s += SumOf(c.time_bias, local.data());
  }
  return CorrectedMotionAtPathTime(pass, time_s, path_s, x);
}

std::optional<CorrectedMotion> LookModel::CorrectedMotionAtPathTime(
    std::size_t pass, double measured_s, double path_s, const Eigen::VectorXd& x) const {
  LookColumns columns;
  ColumnsAt(pass, measured_s, &columns);
  std::array<double, ParameterLayout::kMaxLocalColumns> local;
  GatherColumns(layout_, columns, x, local.data());
  Reading path;
  if (!ReadPath(pass, measured_s, path_s, local.data(), &path) || path.beyond_path) {
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
  const bool geocentric = block_.frame.kind() == FrameKind::kGeocentric;
  double work = PathOf(pass).IsStraight() ? 100.0 : 105.0;
  if (c.NeedsTrackAxes() && !axes_[pass].constant) work += geocentric ? 60.0 : 45.0;
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
