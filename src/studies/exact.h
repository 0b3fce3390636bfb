// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "model/problem.h"
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <glog/logging.h>

namespace sarblock::exact {

/// Arithmetic of the exact adjustment: 50 decimal digits, vectors of any scalar, and two kinds of
/// numbers that carry derivatives, so that no partial of a path or of a vertical is written by
/// hand here.

using Digits = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>,
                                             boost::multiprecision::et_off>;

template <typename T>
using Vec = std::array<T, 3>;

template <typename T>
Vec<T> operator+(const Vec<T>& a, const Vec<T>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <typename T>
Vec<T> operator-(const Vec<T>& a, const Vec<T>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <typename T>
Vec<T> operator*(const T& k, const Vec<T>& a) {
  return {k * a[0], k * a[1], k * a[2]};
}
template <typename T>
T Dot(const Vec<T>& a, const Vec<T>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <typename T>
Vec<T> Cross(const Vec<T>& a, const Vec<T>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <typename T>
T Norm(const Vec<T>& a) {
  using std::sqrt;
  return sqrt(Dot(a, a));
}

/// A function of time at one time: value, first, second and third derivative.
template <typename T>
struct Series {
  T c0 = T(0), c1 = T(0), c2 = T(0), c3 = T(0);

  Series() = default;
  Series(const T& value) : c0(value) {}  // NOLINT: a constant is a series
  Series(const T& value, const T& first, const T& second, const T& third)
      : c0(value), c1(first), c2(second), c3(third) {}

  friend Series operator+(const Series& a, const Series& b) {
    return {a.c0 + b.c0, a.c1 + b.c1, a.c2 + b.c2, a.c3 + b.c3};
  }
  friend Series operator-(const Series& a, const Series& b) {
    return {a.c0 - b.c0, a.c1 - b.c1, a.c2 - b.c2, a.c3 - b.c3};
  }
  friend Series operator*(const Series& a, const Series& b) {
    return {a.c0 * b.c0,
            a.c1 * b.c0 + a.c0 * b.c1,
            a.c2 * b.c0 + T(2) * a.c1 * b.c1 + a.c0 * b.c2,
            a.c3 * b.c0 + T(3) * (a.c2 * b.c1 + a.c1 * b.c2) + a.c0 * b.c3};
  }
  friend Series operator/(const Series& a, const Series& b) {
    const T q0 = a.c0 / b.c0;
    const T q1 = (a.c1 - q0 * b.c1) / b.c0;
    const T q2 = (a.c2 - T(2) * q1 * b.c1 - q0 * b.c2) / b.c0;
    return {q0, q1, q2, (a.c3 - T(3) * (q2 * b.c1 + q1 * b.c2) - q0 * b.c3) / b.c0};
  }
  friend Series sqrt(const Series& a) {
    using std::sqrt;
    const T r0 = sqrt(a.c0);
    const T r1 = a.c1 / (T(2) * r0);
    const T r2 = (a.c2 - T(2) * r1 * r1) / (T(2) * r0);
    return {r0, r1, r2, (a.c3 - T(6) * r1 * r2) / (T(2) * r0)};
  }
};

/// A function of position at one position: value and gradient.
template <typename T>
struct Gradient {
  T value = T(0);
  Vec<T> by = {T(0), T(0), T(0)};

  Gradient() = default;
  Gradient(const T& constant) : value(constant) {}  // NOLINT: a constant is a function
  Gradient(const T& v, const Vec<T>& gradient) : value(v), by(gradient) {}

  friend Gradient operator+(const Gradient& a, const Gradient& b) {
    return {a.value + b.value, a.by + b.by};
  }
  friend Gradient operator-(const Gradient& a, const Gradient& b) {
    return {a.value - b.value, a.by - b.by};
  }
  friend Gradient operator*(const Gradient& a, const Gradient& b) {
    return {a.value * b.value, b.value * a.by + a.value * b.by};
  }
  friend Gradient operator/(const Gradient& a, const Gradient& b) {
    const T q = a.value / b.value;
    return {q, (T(1) / b.value) * (a.by - q * b.by)};
  }
  friend Gradient sqrt(const Gradient& a) {
    using std::sqrt;
    const T r = sqrt(a.value);
    return {r, (T(1) / (T(2) * r)) * a.by};
  }
  friend Gradient exp(const Gradient& a) {
    using std::exp;
    const T e = exp(a.value);
    return {e, e * a.by};
  }
};

/// The observation equations of model.md, sections 3 and 4, with their partials for any scalar
/// type. Paths, track axes and verticals are series in time, from which velocities, turning axes
/// and accelerations follow automatically; nothing is simplified by hand as in the production code.

/// Foot of the normal from p on the ellipsoid: q = p / (1 + mu / axis^2) lies on it.
template <typename S>
struct VerticalOf {
  Vec<S> up;
  S height;
};

template <typename T>
T FootParameter(const T& a, const Vec<T>& axis2, const Vec<T>& p) {
  using std::abs;
  T mu = a * (Norm(p) - a);
  for (int i = 0; i < 60; ++i) {
    T f = -1, slope = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const T g = axis2[k] + mu;
      const T q2 = p[k] * p[k] * axis2[k] / (g * g);
      f += q2;
      slope -= T(2) * q2 / g;
    }
    const T step = f / slope;
    mu -= step;
    if (abs(step) <= std::numeric_limits<T>::epsilon() * T(4) * (abs(mu) + a * a)) break;
  }
  return mu;
}

/// The vertical at a position p with derivatives; `value` is p without them. Each Newton step
/// doubles the order of the derivatives of mu.
template <typename S, typename T>
VerticalOf<S> Vertical(const Frame& frame, const Vec<S>& p, const Vec<T>& value) {
  using std::sqrt;
  if (frame.kind() == FrameKind::kLocal) return {{S(T(0)), S(T(0)), S(T(1))}, p[2]};
  const T a = frame.ellipsoid().a_m, b = a * (T(1) - T(frame.ellipsoid().flattening));
  const Vec<T> axis2 = {a * a, a * a, b * b};
  S mu(FootParameter(a, axis2, value));
  for (int i = 0; i < 2; ++i) {
    S f(T(-1)), slope(T(0));
    for (std::size_t k = 0; k < 3; ++k) {
      const S g = S(axis2[k]) + mu;
      const S q2 = p[k] * p[k] * S(axis2[k]) / (g * g);
      f = f + q2;
      slope = slope - S(T(2)) * q2 / g;
    }
    mu = mu - f / slope;
  }
  Vec<S> foot, normal;
  for (std::size_t k = 0; k < 3; ++k) {
    foot[k] = p[k] * S(axis2[k]) / (S(axis2[k]) + mu);
    normal[k] = foot[k] / S(axis2[k]);
  }
  const Vec<S> up = (S(T(1)) / Norm(normal)) * normal;
  return {up, Dot(p - foot, up)};
}

/// Rows east, north, up at p.
template <typename T>
std::array<Vec<T>, 3> EnuAxes(const Frame& frame, const Vec<T>& p) {
  using std::sqrt;
  if (frame.kind() == FrameKind::kLocal) {
    return {{{T(1), T(0), T(0)}, {T(0), T(1), T(0)}, {T(0), T(0), T(1)}}};
  }
  const Vec<T> up = Vertical<T, T>(frame, p, p).up;
  const T h = sqrt(p[0] * p[0] + p[1] * p[1]);
  const Vec<T> east = h > T(0) ? Vec<T>{-p[1] / h, p[0] / h, T(0)} : Vec<T>{T(0), T(1), T(0)};
  return {east, Cross(up, east), up};
}

template <typename T>
Vec<T> Cast(const Eigen::Vector3d& a) {
  return {T(a[0]), T(a[1]), T(a[2])};
}

/// One look at one state, not weighted. Row 0 is the range sphere, row 1 the Doppler cone.
template <typename T>
struct LookAt {
  std::array<T, 2> error;
  std::array<Vec<T>, 2> d_point;
  std::array<std::vector<T>, 2> by_column;  ///< the look's local columns (look_model.h)
  T range_rate, cone_rate;  ///< by the azimuth measurement, time or Doppler, at a fixed point
  T along_rate;  ///< of the target along the cone axis, by a measured time, as weights use it
};

template <typename T>
class LookModelOf {
 public:
  explicit LookModelOf(const AdjustmentProblem& problem) : problem_(problem) {}

  /// `x` are all corrections of the block. The path is read near the measured time and continued by
  /// its derivatives to that time, its time bias and `shift`, seconds, later; of a look whose
  /// Doppler is measured the time is exact and `shift`, hertz, is added to the Doppler.
  LookAt<T> Evaluate(std::size_t look,
                     const Vec<T>& p,
                     const std::vector<T>& x,
                     const T& shift) const;

  /// Standard deviations of range [m] and of azimuth time [s] or Doppler [Hz].
  std::array<T, 2> SigmasOf(std::size_t look, const LookAt<T>& at) const {
    using std::abs;
    const LookSigma sigma = problem_.model.SigmaOf(look);
    const T azimuth = sigma.azimuth;
    return {T(sigma.range_m),
            sigma.azimuth_unit == AzimuthUnit::kMetres ? T(azimuth / at.along_rate) : azimuth};
  }

 private:
  using Path = Vec<Series<T>>;
  struct Nominal {
    Path position, velocity;
  };
  /// The look's own share of a position correction: how a unit of it moves the antenna.
  struct Direction {
    int column;
    Path moves;
  };

  Nominal NominalAt(std::size_t pass_index, double measured_s, double read_s) const {
    const CorrectedPath& path = problem_.model.paths()[pass_index];
    Nominal out;
    if (path.IsNoisy()) {  // the motion without the noise of the states is given numbers
      Motion given;
      CHECK(path.ReadNominal(measured_s, read_s, &given));
      const Vec<T> p = Cast<T>(given.position_m), v = Cast<T>(given.velocity_mps);
      const Vec<T> a = Cast<T>(given.acceleration_mps2), jerk = Cast<T>(given.jerk_mps3);
      for (std::size_t i = 0; i < 3; ++i) {
        out.position[i] = {p[i], v[i], a[i], jerk[i]};
        out.velocity[i] = {v[i], a[i], jerk[i], T(0)};
      }
      return out;
    }
    const std::vector<StateVector>& states = path.path().states();
    std::size_t k = 0;
    while (k + 2 < states.size() && states[k + 1].time_s <= read_s) ++k;
    const Vec<T> p0 = Cast<T>(states[k].position_m), p1 = Cast<T>(states[k + 1].position_m);
    const Vec<T> v0 = Cast<T>(states[k].velocity_mps), v1 = Cast<T>(states[k + 1].velocity_mps);
    const T h = T(states[k + 1].time_s) - T(states[k].time_s);
    const T u = T(read_s) - T(states[k].time_s);
    for (std::size_t i = 0; i < 3; ++i) {
      const T mean = (p1[i] - p0[i]) / h;
      const T c2 = (T(3) * mean - T(2) * v0[i] - v1[i]) / h;
      const T c3 = (v0[i] + v1[i] - T(2) * mean) / (h * h);
      const T v = v0[i] + u * (T(2) * c2 + T(3) * u * c3);
      const T jerk = T(6) * c3, a = T(2) * c2 + u * jerk;
      out.position[i] = {p0[i] + u * (v0[i] + u * (c2 + u * c3)), v, a, jerk};
      out.velocity[i] = {v, a, jerk, T(0)};
    }
    return out;
  }

  std::array<Path, 3> AxesOf(const Nominal& nominal) const {
    const Vec<T> at = {nominal.position[0].c0, nominal.position[1].c0, nominal.position[2].c0};
    const Series<T> one(T(1));
    const Path vertical = Vertical(problem_.block.frame, nominal.position, at).up;
    const Path along = (one / Norm(nominal.velocity)) * nominal.velocity;
    const Path upright = vertical - Dot(vertical, along) * along;
    const Path up = (one / Norm(upright)) * upright;
    return {along, Cross(up, along), up};
  }

  static void Legendre(const Series<T>& x, int degree, std::vector<Series<T>>* out) {
    out->assign(1, Series<T>(T(1)));
    if (degree >= 1) out->push_back(x);
    for (int k = 2; k <= degree; ++k) {
      const auto i = static_cast<std::size_t>(k);
      out->push_back(Series<T>(T(2 * k - 1) / T(k)) * x * (*out)[i - 1] -
                     Series<T>(T(k - 1) / T(k)) * (*out)[i - 2]);
    }
  }

  /// The four functions of a spline's piece.
  std::array<Series<T>, 4> SplineAt(const SplineTerm& term, double measured_s, const T& t) const {
    double start_s = 0.0, end_s = 0.0;
    bool first = true;
    for (std::size_t i = 0; i < problem_.layout.passes.size(); ++i) {
      for (const SplineTerm& other : problem_.layout.passes[i].splines) {
        if (other.first_block != term.first_block) continue;
        const Pass& pass = problem_.block.passes[i];
        start_s = first ? pass.start_s : std::min(start_s, pass.start_s);
        end_s = first ? pass.end_s : std::max(end_s, pass.end_s);
        first = false;
      }
    }
    const T spacing = (T(end_s) - T(start_s)) / T(term.spline.count() - 3);
    const T u = (t - T(start_s)) / spacing - T(term.spline.PieceOf(measured_s));
    const Series<T> x(u, T(1) / spacing, T(0), T(0)), one(T(1)), y = one - x, six(T(6)), four(T(4));
    const Series<T> three(T(3));
    return {y * y * y / six,
            (four - six * x * x + three * x * x * x) / six,
            (four - six * y * y + three * y * y * y) / six,
            x * x * x / six};
  }

  const AdjustmentProblem& problem_;
};

template <typename T>
LookAt<T> LookModelOf<T>::Evaluate(std::size_t look,
                                   const Vec<T>& p,
                                   const std::vector<T>& x,
                                   const T& shift) const {
  using std::exp;
  using std::sin;
  using std::sqrt;
  const Block& block = problem_.block;
  const Looks& looks = block.looks;
  const std::size_t pass = looks.pass[look];
  const PassCorrections& c = problem_.layout.passes[pass];
  const double measured_s = looks.time_s[look];
  const bool exact_time = block.MeasuresDoppler(look);
  LookColumns columns;
  problem_.model.ColumnsOf(look, &columns);
  std::vector<T> local;
  for (int b = 0; b < columns.block_count; ++b) {
    const ParameterBlock& of =
        problem_.layout
            .blocks[static_cast<std::size_t>(columns.block[static_cast<std::size_t>(b)])];
    for (int i = 0; i < of.size; ++i) local.push_back(x[static_cast<std::size_t>(of.offset + i)]);
  }
  const auto sum = [&](const std::vector<int>& of) {
    T total = 0;
    for (const int column : of) total += local[static_cast<std::size_t>(column)];
    return total;
  };

  // The corrected path and what moves it.
  const T crossing_s = T(measured_s) + sum(c.time_bias) + (exact_time ? T(0) : shift);
  const CorrectedPath& path = problem_.model.paths()[pass];
  const double read_s = path.ReadingTime_s(measured_s, static_cast<double>(crossing_s));
  const T t = T(read_s);
  const T shift_s = crossing_s - t;
  const Nominal nominal = NominalAt(pass, measured_s, read_s);
  std::array<Path, 3> track;
  const double axes_s = path.ReadsAtCrossing() ? measured_s : read_s;
  if (c.NeedsTrackAxes()) track = AxesOf(NominalAt(pass, measured_s, axes_s));
  const T since_axes = t - T(axes_s);
  for (Path& axis : track) {
    for (Series<T>& of : axis) {  // their third derivative is left out of the model
      of = {of.c0 + since_axes * (of.c1 + since_axes / T(2) * of.c2),
            of.c1 + since_axes * of.c2,
            of.c2,
            T(0)};
    }
  }
  Path s = nominal.position;
  std::vector<Direction> directions;
  const auto moves = [&](PositionCorrection::Axes axes, std::size_t axis, const Series<T>& by) {
    if (axes == PositionCorrection::Axes::kTrack) return by * track[axis];
    Path out;
    out[axis] = by;
    return out;
  };
  std::vector<Series<T>> basis;
  for (const PolynomialTerm& term : c.polynomials) {
    const T start = block.passes[pass].start_s, end = block.passes[pass].end_s;
    const T half = (end - start) / T(2);
    Legendre({(t - (start + end) / T(2)) / half, T(1) / half, T(0), T(0)}, term.degree, &basis);
    int column = term.column;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!term.components[axis]) continue;
      for (const Series<T>& b : basis) {
        directions.push_back({column++, moves(term.axes, axis, b)});
      }
    }
  }
  int column_begin = c.static_columns;
  for (const SplineTerm& term : c.splines) {
    const std::array<Series<T>, 4> four = SplineAt(term, measured_s, t);
    int column = column_begin;
    for (const Series<T>& b : four) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (term.components[axis]) directions.push_back({column++, moves(term.axes, axis, b)});
      }
    }
    column_begin = column;
  }
  for (const Direction& d : directions) {
    s = s + Series<T>(local[static_cast<std::size_t>(d.column)]) * d.moves;
  }

  Vec<T> given_velocity, given_acceleration;
  for (std::size_t i = 0; i < 3; ++i) {
    given_velocity[i] = nominal.position[i].c1;
    given_acceleration[i] = nominal.position[i].c2;
  }

  // A time shift_s later: value, velocity and acceleration of the antenna and of what moves it.
  const T half = shift_s * shift_s / T(2);
  const auto later = [&](const Series<T>& at) {
    return Series<T>{at.c0 + shift_s * at.c1 + half * at.c2 + half * shift_s / T(3) * at.c3,
                     at.c1 + shift_s * at.c2 + half * at.c3,
                     at.c2 + shift_s * at.c3,
                     at.c3};
  };
  for (std::size_t i = 0; i < 3; ++i) s[i] = later(s[i]);
  for (Direction& direction : directions) {
    for (Series<T>& axis : direction.moves) axis = later(axis);
  }

  // The cone's axis: the direction of flight, turned by the velocity corrections.
  Path v;
  for (std::size_t i = 0; i < 3; ++i) v[i] = {s[i].c1, s[i].c2, T(0), T(0)};  // second never used
  const bool turned = !c.velocity_across.empty() || !c.velocity_up.empty();
  Path cone_axis = v;
  std::array<Path, 3> turning;  // track axes a time shift_s later, to first order
  Vec<T> w = {T(0), T(0), T(0)};
  if (turned) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < 3; ++i) {
        const Series<T>& of = track[axis][i];
        turning[axis][i] = {of.c0 + shift_s * of.c1, of.c1, T(0), T(0)};
      }
    }
    const Path turn =
        Series<T>(sum(c.velocity_across)) * turning[1] + Series<T>(sum(c.velocity_up)) * turning[2];
    cone_axis = v + Norm(v) * turn;
    for (std::size_t i = 0; i < 3; ++i) w[i] = turn[i].c0;
  }
  Vec<T> position, velocity, axis, axis_rate;
  for (std::size_t i = 0; i < 3; ++i) {
    position[i] = s[i].c0;
    velocity[i] = v[i].c0;
    axis[i] = cone_axis[i].c0;
    axis_rate[i] = cone_axis[i].c1;
  }
  const Vec<T> d = p - position;
  const T rho = Norm(d), speed = Norm(axis);
  const Vec<T> u = (T(1) / speed) * axis;

  // sin(tau + b_tau) and its derivatives.
  const bool doppler = (looks.flags[look] & Looks::kDoppler) != 0;
  const T measured = looks.cone.empty() ? T(0) : T(looks.cone[look]);
  const T given = exact_time ? T(measured + shift) : measured;
  const T half_wavelength = doppler ? T(block.passes[pass].wavelength_m) / T(2) : T(0);
  const T closing = half_wavelength * given;
  const T sin_given = doppler ? closing / speed : T(sin(given));
  const T cos_given = sqrt((T(1) - sin_given) * (T(1) + sin_given));
  const T bias = sum(c.squint_bias);
  using std::cos;
  const T sin_bias = sin(bias), cos_bias = cos(bias);
  const T sin_tau = sin_given * cos_bias + cos_given * sin_bias;
  const T cos_tau = cos_given * cos_bias - sin_given * sin_bias;
  const T by_speed = doppler ? -sin_given / speed * cos_tau / cos_given : T(0);

  LookAt<T> out;
  const T along = Dot(u, d), kappa = sum(c.range_scale);
  const Vec<T> observation = (T(1) / rho) * d;
  Vec<T> range_by_p = (T(1) + kappa) * observation;
  Vec<T> range_by_s = T(-1) * range_by_p;
  out.error = {rho + sum(c.range_bias) + kappa * rho - T(looks.range_m[look]),
               along - rho * sin_tau};
  std::vector<T> mappings;
  if (!c.troposphere.empty()) {
    using G = Gradient<T>;
    Vec<G> at, from;
    for (std::size_t i = 0; i < 3; ++i) {
      at[i].value = p[i];
      at[i].by[i] = T(1);
      from[i] = G(position[i]);
    }
    const VerticalOf<G> vertical = Vertical(block.frame, at, p);
    const Vec<G> line = at - from;
    const G drop = G(T(-1)) * Dot(vertical.up, line);
    for (const TroposphereTerm& term : c.troposphere) {
      const G thin = exp(G(T(-1) / T(term.scale_height_m)) * vertical.height);
      const G m = thin * Norm(line) / drop;
      const T zenith = local[static_cast<std::size_t>(term.column)];
      out.error[0] += zenith * m.value;
      range_by_p = range_by_p + zenith * m.by;
      Vec<T> up;
      for (std::size_t i = 0; i < 3; ++i) up[i] = vertical.up[i].value;
      const Vec<T> by_s =
          T(-1) * ((thin.value / drop.value) * observation + (m.value / drop.value) * up);
      range_by_s = range_by_s + zenith * by_s;
      mappings.push_back(m.value);
    }
  }
  const Vec<T> cone_by_p = u - sin_tau * observation;
  const Vec<T> cone_by_axis = (T(1) / speed) * (d - along * u) - (rho * by_speed) * u;
  out.d_point = {range_by_p, cone_by_p};

  const auto count = static_cast<std::size_t>(columns.column_count);
  out.by_column[0].assign(count, T(0));
  out.by_column[1].assign(count, T(0));
  const auto set = [&](int column, const T& range, const T& cone) {
    out.by_column[0][static_cast<std::size_t>(column)] = range;
    out.by_column[1][static_cast<std::size_t>(column)] = cone;
  };
  const T nominal_speed = Norm(velocity);
  const Vec<T> direction = (T(1) / nominal_speed) * velocity;
  for (const Direction& move : directions) {
    Vec<T> ds, dv;
    for (std::size_t i = 0; i < 3; ++i) {
      ds[i] = move.moves[i].c0;
      dv[i] = move.moves[i].c1;
    }
    const Vec<T> daxis = dv + Dot(direction, dv) * w;
    set(move.column, Dot(range_by_s, ds), Dot(cone_by_axis, daxis) - Dot(cone_by_p, ds));
  }
  const auto turn_by = [&](const Path& of) {
    Vec<T> at;
    for (std::size_t i = 0; i < 3; ++i) at[i] = of[i].c0;
    return nominal_speed * Dot(cone_by_axis, at);
  };
  for (const int column : c.velocity_across) set(column, T(0), turn_by(turning[1]));
  for (const int column : c.velocity_up) set(column, T(0), turn_by(turning[2]));
  for (const int column : c.range_bias) set(column, T(1), T(0));
  for (const int column : c.range_scale) set(column, rho, T(0));
  for (const int column : c.time_bias) {
    set(column, Dot(range_by_s, velocity), Dot(cone_by_axis, axis_rate) - Dot(cone_by_p, velocity));
  }
  for (const int column : c.squint_bias) set(column, T(0), T(-1) * rho * cos_tau);
  for (std::size_t q = 0; q < c.troposphere.size(); ++q) {
    set(c.troposphere[q].column, mappings[q], T(0));
  }

  out.range_rate = Dot(range_by_s, velocity);
  out.cone_rate = Dot(cone_by_axis, axis_rate) - Dot(cone_by_p, velocity);
  // Metres become seconds on the given path: the target moves at the speed that keeps it in the
  // sphere and in the cone, along the cone's axis (docs/theory/observations.md, eq. (10a)).
  const T given_speed = Norm(given_velocity);
  if (exact_time) {
    out.range_rate = T(0);
    out.cone_rate = T(-1) * rho * half_wavelength / speed * cos_tau / cos_given;
    out.along_rate = T(-1) * out.cone_rate * nominal_speed / given_speed;
  } else {
    const Vec<T> axis_of_given = (T(1) / given_speed) * given_velocity;
    const T sin_of_given = Dot(axis_of_given, observation);
    const Vec<T> by_d = axis_of_given - sin_of_given * observation;
    const T by_angle = doppler ? T(rho * sin_of_given / given_speed) : T(0);
    const Vec<T> by_axis = (T(1) / given_speed) * (d - Dot(axis_of_given, d) * axis_of_given) +
                           by_angle * axis_of_given;
    const T rate = Dot(by_axis, given_acceleration) - Dot(by_d, given_velocity);
    out.along_rate = sin_of_given * Dot(observation, given_velocity) - rate;
  }
  return out;
}

}  // namespace sarblock::exact

namespace sarblock {

/// Compares an adjustment with the same one in 50 decimal digits: the equations of exact.h,
/// Gauss-Newton from the result to a step of 1e-14 sigmas, weights formed anew in each iteration,
/// all normal equations at once, a Cholesky factor and its inverse. What the files say (times,
/// ranges, states, standard deviations) counts as exact; points and looks that the result left out
/// are left out here too.
struct ExactComparison {
  std::string failure;  ///< empty, or why there is nothing to compare with
  int iterations = 0;
  double condition = std::numeric_limits<double>::quiet_NaN();  ///< of J with unit columns
  /// Largest sqrt(e' Q^-1 e) of a point, e its error and Q its exact 3 x 3 covariance, or
  /// |error| / sigma of a correction.
  double error_sigma = 0.0;
  double position_error = 0.0;    ///< largest |e| of a point over its shortest range
  double covariance_error = 0.0;  ///< largest relative error of a 3 x 3 block, Frobenius
  double sigma_error = 0.0;       ///< largest relative error of a sigma, points and corrections
  std::vector<SymmetricEnu> covariance_m2;  ///< exact, by point; NaN where not solved
};

/// `problem` is the result's own: points and looks in use as it left them.
[[nodiscard]] ExactComparison CompareWithExact(const AdjustmentProblem& problem,
                                               const AdjustResult& result);

}  // namespace sarblock
