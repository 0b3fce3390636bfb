// SPDX-License-Identifier: Apache-2.0
#include "look_evaluation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "geometry/look_equations_inline.h"

namespace sarblock {
namespace {

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

/// Partials by position and velocity of the antenna, turned to axes A: by a parameter that moves
/// the path by A B.
struct AxisPartials : MotionPartials {
  bool set = false;

  void SetInFrame(const TwoRows& by_s, const TwoRows& by_v, const TwoRows& by_a, double dt_s) {
    set = true;
    Set(by_s, by_v, dt_s);
    by[2] += by_a;
    by[3] += dt_s * by_a;
  }
  /// By value and rate alone: of terms that do not bend along axes that do not turn.
  void SetStraight(const TwoRows& by_position, const TwoRows& by_velocity, double dt_s) {
    set = true;
    by[0] = by_position;
    by[1] = dt_s * by_position + by_velocity;
  }
  void SetInTrack(const Eigen::Matrix3d& axes,
                  const std::optional<TrackAxes>& turning,
                  const TwoRows& by_s,
                  const TwoRows& by_v,
                  const TwoRows& by_a,
                  double dt_s) {
    const TwoRows s0 = by_s.lazyProduct(axes), v0 = by_v.lazyProduct(axes),
                  a0 = by_a.lazyProduct(axes);
    SetInFrame(s0, v0, a0, dt_s);
    if (!turning) return;
    // A B has the velocity A' B + A B', the acceleration A'' B + 2 A' B' + A B'' and, but for
    // A''' B, the jerk 3 A'' B' + 3 A' B'' + A B'''.
    MotionPartials at;
    at.Set(by_s, by_v, dt_s);
    const TwoRows later = at.by[2] + by_a, latest = 3.0 * (at.by[3] + dt_s * by_a);
    by[0] += at.by[1].lazyProduct(turning->rate) + later.lazyProduct(turning->acceleration);
    by[1] += (2.0 * later).lazyProduct(turning->rate) + latest.lazyProduct(turning->acceleration);
    by[2] += latest.lazyProduct(turning->rate);
  }
};

using LocalRow = std::array<double, ParameterLayout::kMaxLocalColumns>;

/// Sets the columns of a term in two rows.
void SetColumns(const TermAtTime& term, const AxisPartials& partials, LocalRow* rows) {
  int rank = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (!term.components[static_cast<std::size_t>(axis)]) continue;
    const Eigen::Vector2d by_value = partials.by[0].col(axis), by_first = partials.by[1].col(axis);
    auto column = static_cast<std::size_t>(term.column + term.by_axis * rank++);
    for (std::size_t k = 0; k < term.functions; ++k) {
      Eigen::Vector2d both = by_value * term.value[k] + by_first * term.first[k];
      if (term.bends) {
        both +=
            partials.by[2].col(axis) * term.second[k] + partials.by[3].col(axis) * term.third[k];
      }
      rows[0][column] = both[0];
      rows[1][column] = both[1];
      column += static_cast<std::size_t>(term.by_function);
    }
  }
}

/// Sets the columns of all corrections of the path, `by_s`, `by_v` and `by_a` partials by position,
/// velocity and acceleration of the antenna a time `dt_s` after the reading.
void SetPathColumns(const PathReading& path,
                    const TwoRows& by_s,
                    const TwoRows& by_v,
                    const TwoRows& by_a,
                    double dt_s,
                    LocalRow* rows) {
  AxisPartials track, frame;  // three numbers an axis serve all basis functions
  const bool straight = !path.turning && !path.Bends();
  for (std::size_t q = 0; q < path.term_count; ++q) {
    const bool in_track = path.terms[q].axes == PositionCorrection::Axes::kTrack;
    AxisPartials& partials = in_track ? track : frame;
    if (!partials.set) {
      if (straight) {
        partials.SetStraight(in_track ? by_s.lazyProduct(*path.axes).eval() : by_s,
                             in_track ? by_v.lazyProduct(*path.axes).eval() : by_v,
                             dt_s);
      } else if (in_track) {
        partials.SetInTrack(*path.axes, path.turning, by_s, by_v, by_a, dt_s);
      } else {
        partials.SetInFrame(by_s, by_v, by_a, dt_s);
      }
    }
    SetColumns(path.terms[q], partials, rows);
  }
}

/// The second derivatives of a look at its crossing. With t the time from there, the range
/// r(t, d, v, a) = |d - v t - a t^2/2| and the cone F(t, d, v, a) = u.d - rho sin(tau) of d - v t -
/// a t^2/2 and v + a t,
///
///     t' = -F'/F_t,   t'' = -(F'' + F_t' t' + t' F_t' + F_tt t' t')/F_t,
///     R'' = r'' + r_t' t' + t' r_t' + r_tt t' t' + r_t t''
///
/// where of all derivatives by a only that of F_t is not 0: F_v, so that a counts by F_v.a.
void SetCurvature(const Crossing& crossing,
                  const Eigen::Vector3d& a,
                  const Eigen::Vector3d& jerk,
                  LookCurvature* out) {
  using Matrix = LookCurvature::Matrix;
  using Vector = Eigen::Matrix<double, LookCurvature::kSize, 1>;
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
  const double f_tt =
      v.dot(f_dd * v) - 2.0 * v.dot(f_dv * a) + a.dot(f_vv * a) - f_d.dot(a) + f_v.dot(jerk);
  const double r_tt = v.dot(r_dd * v) - g.dot(a);
  Vector t1, f_t1, r_t1;
  t1 << f_d, f_v, 0.0;
  t1 /= -f_t;
  f_t1 << f_dv * a - f_dd * v, f_vv * a - f_dv * v - f_d, 1.0;
  r_t1 << -r_dd * v, -g, 0.0;
  Matrix f2 = Matrix::Zero();
  f2.topLeftCorner<6, 6>() << f_dd, f_dv, f_dv, f_vv;
  out->cone_by_velocity = f_v;
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
  out->azimuth.block<3, 3>(0, 3) = hz_per_mps * r_dd;
  out->azimuth.block<3, 3>(3, 0) = hz_per_mps * r_dd;
  out->cone_by_velocity.setZero();
}

/// Direction errors of the cone axis under corrections x, along the axes of a reading.
AxisTurn TurnAt(const PassCorrections& c, const PathReading& path, const double* x) {
  AxisTurn turn;
  turn.used = !c.velocity_across.empty() || !c.velocity_up.empty();
  if (!turn.used) return turn;
  const double across = SumOf(c.velocity_across, x), up = SumOf(c.velocity_up, x);
  turn.value = across * path.axes->col(1) + up * path.axes->col(2);
  if (path.turning) {
    turn.rate = across * path.turning->rate.col(1) + up * path.turning->rate.col(2);
  }
  return turn;
}

/// LookEvaluation::azimuth_unit_m. A cone of one angle turns by the acceleration across the flight,
/// one of one Doppler by all of it; that of a given path may turn with the point where that of the
/// corrected path does not, so that the rate has the least value that a crossing has.
double AzimuthUnit_m(const MeasuredLook& look, const PathReading& path, const Crossing& crossing) {
  const Eigen::Vector3d &v = path.given_mps, &a = path.given_mps2, &d = crossing.d_m;
  const double square = v.squaredNorm();
  switch (look.azimuth) {
    case MeasuredLook::Azimuth::kTime: {
      double turning = a.dot(d);
      if (look.cone.kind == Cone::Kind::kSquint) turning -= v.dot(a) * v.dot(d) / square;
      return std::max(square - turning, kMinConeRate * square) / std::sqrt(square);
    }
    case MeasuredLook::Azimuth::kDoppler:
      return -crossing.rate_m * std::sqrt(crossing.v_mps.squaredNorm() / square);
    case MeasuredLook::Azimuth::kNone:
      break;
  }
  return 1.0;
}

/// A crossing so near a reading is read exactly by one more.
constexpr double kNearCrossing_s = 0.05;
constexpr int kMaxReadings = 4;

/// When a look sees a point, read from read_s on as often as it takes to come near; read_s where
/// there is no crossing, or none within the path.
double CrossingTime_s(const CorrectedPath& corrected,
                      const MeasuredLook& look,
                      const Eigen::Vector3d& start_m,
                      const Eigen::Vector3d& displacement_m,
                      const double* x,
                      double read_s) {
  const double squint_bias_rad = SumOf(corrected.corrections().squint_bias, x);
  for (int reading = 0; reading < kMaxReadings; ++reading) {
    PathReading path;
    if (!corrected.Read(look.time_s, read_s, x, &path)) return read_s;
    const AxisTurn turn = TurnAt(corrected.corrections(), path, x);
    const Eigen::Vector3d d_before = (start_m - path.motion.position_m) + displacement_m;
    Crossing crossing;
    if (!FindCrossing(path.motion, d_before, turn, look.cone, squint_bias_rad, &crossing)) {
      return read_s;
    }
    const double crossing_s = read_s + crossing.dt_s;
    if (BeyondPath(corrected.path(), crossing_s) != Beyond::kInside) return read_s;
    read_s = crossing_s;
    if (std::abs(crossing.dt_s) <= kNearCrossing_s) break;
  }
  return read_s;
}

}  // namespace

Beyond BeyondPath(const FlightPath& path, double path_s) {
  const double start_s = path.start_s(), end_s = path.end_s(), most_s = end_s - start_s;
  if (path_s >= start_s && path_s <= end_s) return Beyond::kInside;
  return path_s >= start_s - most_s && path_s <= end_s + most_s ? Beyond::kNear : Beyond::kFar;
}

LookValue EvaluateMeasuredLook(const CorrectedPath& corrected,
                               const MeasuredLook& look,
                               const Eigen::Vector3d& start_m,
                               const Eigen::Vector3d& displacement_m,
                               const double* x,
                               int columns,
                               const LookWeights& weights,
                               LookEvaluation* out,
                               LookCurvature* curvature) {
  using Azimuth = MeasuredLook::Azimuth;
  const PassCorrections& c = corrected.corrections();
  const double measured_s = look.time_s;
  const double path_s = measured_s + SumOf(c.time_bias, x);
  const Beyond beyond = BeyondPath(corrected.path(), path_s);
  if (beyond == Beyond::kFar) return LookValue::kBeyondPath;
  const bool exact_time = look.azimuth != Azimuth::kTime;
  double read_s = corrected.ReadingTime_s(measured_s, path_s);
  if (corrected.ReadsAtCrossing() && !exact_time) {
    read_s = CrossingTime_s(corrected, look, start_m, displacement_m, x, read_s);
  }
  const double biased_s = path_s - read_s;
  PathReading path;
  if (!corrected.Read(measured_s, read_s, x, &path)) return LookValue::kNotFinite;
  AxisTurn turn = TurnAt(c, path, x);
  // An exact time has no error to be found: the path is continued to it.
  const double exact_s = exact_time ? biased_s : 0.0;
  if (exact_s != 0.0) {
    path.motion = path.motion.After(exact_s);
    turn.value += exact_s * turn.rate;
  }
  // d = (start - s) + displacement keeps the digits of a small displacement.
  const Eigen::Vector3d d_before = (start_m - path.motion.position_m) + displacement_m;
  Crossing crossing;
  const double squint_bias_rad = SumOf(c.squint_bias, x);
  const bool found =
      look.azimuth == Azimuth::kTime
          ? FindCrossing(path.motion, d_before, turn, look.cone, squint_bias_rad, &crossing)
      : look.azimuth == Azimuth::kDoppler ? FindDoppler(path.motion,
                                                        d_before,
                                                        turn,
                                                        look.cone,
                                                        look.wavelength_m,
                                                        squint_bias_rad,
                                                        &crossing)
                                          : FindRange(path.motion, d_before, &crossing);
  if (!found) return LookValue::kNoCrossing;
  if (!exact_time) crossing.error -= biased_s;
  const LookEquations& eq = crossing.eq;
  const double dt_s = crossing.dt_s + exact_s;     // after the reading
  const double slowness = -1.0 / crossing.rate_m;  // dt_p or df_p = slowness de_d

  const double kappa = SumOf(c.range_scale, x);
  Eigen::RowVector3d range_by_p = (1.0 + kappa) * eq.drho_dp;
  Eigen::RowVector3d range_by_s = -range_by_p;
  double range_error_m = (eq.rho_m - look.range_m) + SumOf(c.range_bias, x) + kappa * eq.rho_m;
  std::array<SlantMapping, ParameterLayout::kMaxTroposphere> mappings;
  if (!c.troposphere.empty()) {
    const Vertical vertical = corrected.DelayVerticalAt(start_m + displacement_m);
    for (std::size_t q = 0; q < c.troposphere.size(); ++q) {
      const TroposphereTerm& term = c.troposphere[q];
      SlantMapping& mapping = mappings[q];
      if (!EvaluateMapping(vertical, crossing.d_m, eq.rho_m, term.scale_height_m, &mapping)) {
        return LookValue::kNotAbove;
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
  out->azimuth_unit_m = AzimuthUnit_m(look, path, crossing);
  out->beyond_path = beyond == Beyond::kNear;
  // Factors that turn a partial of e_d into those of the range and of the time or Doppler.
  const double of_azimuth = wt * slowness, of_range = wr * range_rate * slowness;
  out->d_point.row(0) = wr * range_by_p + of_range * eq.ded_dp;
  out->d_point.row(1) = of_azimuth * eq.ded_dp;
  if (curvature != nullptr) {
    if (exact_time) {
      SetCurvatureOfDoppler(crossing, look.wavelength_m, curvature);
    } else {
      const Motion& motion = path.motion;
      SetCurvature(crossing,
                   motion.acceleration_mps2 + crossing.dt_s * motion.jerk_mps3,
                   motion.jerk_mps3,
                   curvature);
    }
    for (auto& row : curvature->row) {
      std::fill_n(row.begin(), static_cast<std::size_t>(columns), 0.0);
    }
  }
  const LookValue value =
      out->whitened_error.allFinite() ? LookValue::kGiven : LookValue::kNotFinite;
  if (columns == 0) return value;

  if (path.term_count > 0) {
    const Eigen::RowVector3d cone_by_v = crossing.ConeByVelocity(turn.used);
    TwoRows by_s, by_v, by_a = TwoRows::Zero();
    by_s << wr * range_by_s - of_range * eq.ded_dp, -of_azimuth * eq.ded_dp;
    by_v << of_range * cone_by_v, of_azimuth * cone_by_v;
    SetPathColumns(path, by_s, by_v, by_a, dt_s, out->row.data());
    for (std::size_t pair = 0; curvature != nullptr && pair < 4; ++pair) {
      by_s.setZero();
      by_v.setZero();
      for (std::size_t k = 0; k < 2; ++k) {
        const auto axis = static_cast<Eigen::Index>(2 * pair + k);
        if (axis < 3) {
          by_s(static_cast<Eigen::Index>(k), axis) = -1.0;
        } else if (axis < 6) {
          by_v(static_cast<Eigen::Index>(k), axis - 3) = 1.0;
        } else if (axis == 6) {
          by_a.row(static_cast<Eigen::Index>(k)) = curvature->cone_by_velocity.transpose();
        }
      }
      SetPathColumns(path, by_s, by_v, by_a, dt_s, &curvature->row[2 * pair]);
    }
  }
  const auto set = [&](int column, double range, double doppler) {
    const auto i = static_cast<std::size_t>(column);
    out->row[0][i] = wr * range + of_range * doppler;
    out->row[1][i] = of_azimuth * doppler;
  };
  if (turn.used) {
    const auto set_turn = [&](const std::vector<int>& of_axis, Eigen::Index axis) {
      Eigen::Vector3d direction = path.axes->col(axis);
      if (path.turning) direction += dt_s * path.turning->rate.col(axis);
      for (const int column : of_axis) {
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
  return value;
}

}  // namespace sarblock
