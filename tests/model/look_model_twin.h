// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

/// The explicit model of a look once more, for any scalar type: written from the text of the model
/// (look equations, corrected path, track axes), with other formulas than the library where there
/// are others. Velocity, acceleration and jerk of the corrected path are numerical derivatives of
/// its position, so that the turning of the track axes cannot be forgotten; the time at which the
/// cone holds the point is found by the secant method. Meant for 50 digits.
namespace sarblock::test {

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
T Norm(const Vec<T>& a) {
  using std::sqrt;
  return sqrt(Dot(a, a));
}
template <typename T>
Vec<T> Cross(const Vec<T>& a, const Vec<T>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <typename T>
Vec<T> Unit(const Vec<T>& a) {
  return (T(1) / Norm(a)) * a;
}
template <typename T>
Vec<T> Cast(const Eigen::Vector3d& a) {
  return {T(a[0]), T(a[1]), T(a[2])};
}

/// Foot of the normal on the ellipsoid by Newton's method on the Lagrange multiplier.
template <typename T>
struct TwinVertical {
  Vec<T> up;
  T height;
};
template <typename T>
TwinVertical<T> VerticalOf(const Frame& frame, const Vec<T>& p) {
  if (frame.kind() == FrameKind::kLocal) return {{T(0), T(0), T(1)}, p[2]};
  const T a = frame.ellipsoid().a_m, b = a * (T(1) - T(frame.ellipsoid().flattening));
  // q = p / (1 + mu / axis^2) lies on the ellipsoid; f(mu) = sum q^2 / axis^2 - 1 = 0.
  const Vec<T> axis2 = {a * a, a * a, b * b};
  T mu = a * (Norm(p) - a);
  for (int i = 0; i < 12; ++i) {
    T f = -1, slope = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const T g = axis2[k] + mu;
      f += p[k] * p[k] * axis2[k] / (g * g);
      slope -= T(2) * p[k] * p[k] * axis2[k] / (g * g * g);
    }
    mu -= f / slope;
  }
  Vec<T> q, normal;
  for (std::size_t k = 0; k < 3; ++k) {
    q[k] = p[k] * axis2[k] / (axis2[k] + mu);
    normal[k] = q[k] / axis2[k];
  }
  const Vec<T> up = Unit(normal);
  return {up, Dot(p - q, up)};
}

/// Predicted less measured.
template <typename T>
struct TwinErrors {
  T range;
  T azimuth;  ///< of the time, or of a measured Doppler
};

/// The model of one look. `Value(owner, name)` gives a parameter's value.
template <typename T>
class LookModelTwin {
 public:
  using Value = std::function<T(const std::string& owner, const std::string& name)>;
  LookModelTwin(const Block& block, const std::vector<CorrectionGroup>& groups)
      : block_(block), groups_(groups) {}

  /// The path is read at `read` and continued from there to the measured time and its bias.
  TwinErrors<T> Errors(std::size_t look, const Vec<T>& p, const Value& value, const T& read) const {
    using std::exp;
    using std::sin;
    const Pass& pass = block_.passes[block_.looks.pass[look]];
    const T measured = block_.looks.time_s[look];
    T path_time = measured, squint_bias = 0, range_bias = 0, range_scale = 0, delay = 0;
    T across = 0, up = 0;
    std::vector<std::pair<T, T>> airs;  // zenith delay and scale height
    const T step("1e-7");  // third differences: 1e-23 of rounding, 1e-14 of truncation
    const auto sum = [&](const CorrectionGroup& group, const std::string& name) {
      return value(group.shared ? group.name : pass.id, name);
    };
    ForEachGroup(pass, [&](const CorrectionGroup& group) {
      if (std::holds_alternative<TimeCorrection>(group.model)) path_time += sum(group, "time.bias");
    });
    const T after = path_time - read;
    const Reading at = Read(pass, read);
    const std::array<Vec<T>, 3> axes = Axes(at, T(0));
    const std::array<Vec<T>, 3> axes_later = Axes(at, step), axes_earlier = Axes(at, -step);
    const auto position = [&](const T& tau, const std::array<Vec<T>, 3>& track) {
      return Position(pass, measured, read, at, tau, track, value);
    };
    const Vec<T> s0 = position(T(0), axes);
    const Vec<T> later = position(step, axes_later), earlier = position(-step, axes_earlier);
    const Vec<T> s1 = (T(1) / (T(2) * step)) * (later - earlier);
    const Vec<T> s2 = (T(1) / (step * step)) * ((later - s0) - (s0 - earlier));
    // The third derivative, with axes that turn to second order.
    const auto near = [&](const T& tau) {
      std::array<Vec<T>, 3> track;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec<T> rate = (T(1) / (T(2) * step)) * (axes_later[k] - axes_earlier[k]);
        const Vec<T> bend =
            (T(1) / (step * step)) * ((axes_later[k] - axes[k]) - (axes[k] - axes_earlier[k]));
        track[k] = axes[k] + tau * (rate + (tau / T(2)) * bend);
      }
      return position(tau, track);
    };
    const Vec<T> s3 =
        (T(1) / (T(2) * step * step * step)) *
        ((near(T(2) * step) - near(-T(2) * step)) - T(2) * (near(step) - near(-step)));
    const TwinVertical<T> vertical = VerticalOf(block_.frame, p);
    ForEachGroup(pass, [&](const CorrectionGroup& group) {
      if (const auto* c = std::get_if<VelocityCorrection>(&group.model)) {
        if (c->components[0]) across += sum(group, "velocity.across");
        if (c->components[1]) up += sum(group, "velocity.up");
      } else if (const auto* r = std::get_if<RangeCorrection>(&group.model)) {
        if (r->bias) range_bias += sum(group, "range.bias");
        if (r->scale) range_scale += sum(group, "range.scale");
      } else if (std::holds_alternative<SquintCorrection>(group.model)) {
        squint_bias += sum(group, "squint.bias");
      } else if (const auto* air = std::get_if<TroposphereCorrection>(&group.model)) {
        airs.emplace_back(sum(group, "troposphere.zenith"), air->scale_height_m);
      }
    });
    const T cone = block_.looks.cone.empty() ? 0.0 : block_.looks.cone[look];
    const auto turned = [&](std::size_t axis, const T& dt) {
      return axes[axis] + (dt / (T(2) * step)) * (axes_later[axis] - axes_earlier[axis]);
    };
    Vec<T> d;
    const bool measures_doppler = block_.MeasuresDoppler(look);
    // e_d a time dt after the reading, with df added to a Doppler.
    const auto off_cone_at = [&](const T& dt, const T& df) {
      const Vec<T> v = s1 + dt * s2 + (dt * dt / T(2)) * s3;
      d = p - (s0 + dt * (s1 + (dt / T(2)) * (s2 + (dt / T(3)) * s3)));
      const Vec<T> cone_axis = v + Norm(v) * (across * turned(1, dt) + up * turned(2, dt));
      T tau = cone;
      if ((block_.looks.flags[look] & Looks::kDoppler) != 0) {
        using std::asin;
        // f_D = 2 v.d / (lambda rho), d along the cone
        tau = asin(T(pass.wavelength_m) * (cone + df) / (T(2) * Norm(cone_axis)));
      }
      return Dot(Unit(cone_axis), d) - Norm(d) * sin(tau + squint_bias);
    };
    // The time at which the cone holds the point, or the Doppler whose cone does at an exact time.
    const auto off_cone = [&](const T& error) {
      return measures_doppler ? off_cone_at(after, error) : off_cone_at(after + error, T(0));
    };
    using std::abs;
    T dt0 = 0, off0 = off_cone(dt0), dt = off0 / Norm(s1);
    for (int k = 0; k < 40; ++k) {
      const T off = off_cone(dt);
      if (abs(off) < T("1e-40") || off == off0) break;
      const T next = dt - off * (dt - dt0) / (off - off0);
      dt0 = dt;
      off0 = off;
      dt = next;
    }
    const T rho = Norm(d);
    for (const auto& [zenith, scale_height_m] : airs) {
      delay += zenith * exp(-vertical.height / scale_height_m) * rho / -Dot(vertical.up, d);
    }
    return {rho + range_bias + range_scale * rho + delay - T(block_.looks.range_m[look]), dt};
  }

 private:
  template <typename F>
  void ForEachGroup(const Pass& pass, F&& f) const {
    for (const CorrectionGroup& group : groups_) {
      bool member = group.passes.empty();
      for (const std::string& id : group.passes) member = member || id == pass.id;
      if (member) f(group);
    }
  }

  /// Cubic Hermite in its cardinal functions, and its derivative.
  static std::array<Vec<T>, 2> Nominal(const Pass& pass, const T& t) {
    const std::vector<StateVector>& states = pass.path.states();
    std::size_t k = 0;
    while (k + 2 < states.size() && T(states[k + 1].time_s) <= t) ++k;
    const Vec<T> p0 = Cast<T>(states[k].position_m), p1 = Cast<T>(states[k + 1].position_m);
    const Vec<T> v0 = Cast<T>(states[k].velocity_mps), v1 = Cast<T>(states[k + 1].velocity_mps);
    const T h = T(states[k + 1].time_s) - T(states[k].time_s);
    const T u = (t - T(states[k].time_s)) / h;
    const T h00 = (T(1) + T(2) * u) * (T(1) - u) * (T(1) - u);
    const T h10 = u * (T(1) - u) * (T(1) - u);
    const T h01 = u * u * (T(3) - T(2) * u);
    const T h11 = u * u * (u - T(1));
    const T d00 = T(6) * u * (u - T(1)), d01 = -d00;
    const T d10 = T(1) - T(4) * u + T(3) * u * u, d11 = T(3) * u * u - T(2) * u;
    const T per_h = T(1) / h;
    return {h00 * p0 + (h10 * h) * v0 + h01 * p1 + (h11 * h) * v1,
            (d00 * per_h) * p0 + d10 * v0 + (d01 * per_h) * p1 + d11 * v1};
  }

  /// The nominal motion at a path time: the cubic and its derivatives, by differences that are
  /// exact for a cubic.
  struct Reading {
    Vec<T> position, velocity, acceleration, jerk;
  };
  static Reading Read(const Pass& pass, const T& t) {
    const std::vector<StateVector>& states = pass.path.states();
    std::size_t k = 0;
    while (k + 2 < states.size() && T(states[k + 1].time_s) <= t) ++k;
    const T t0 = states[k].time_s, h = T(states[k + 1].time_s) - t0;
    const auto velocity = [&](const T& part) { return Nominal(pass, t0 + part * h)[1]; };
    // A parabola through three places of the piece.
    const Vec<T> v0 = velocity(T("0.25")), v1 = velocity(T("0.5")), v2 = velocity(T("0.75"));
    const T d = h / T(4);
    const Vec<T> jerk = (T(1) / (d * d)) * ((v2 - v1) - (v1 - v0));
    const Vec<T> middle = (T(1) / (T(2) * d)) * (v2 - v0);
    const auto [s, v] = Nominal(pass, t);
    return {s, v, middle + (t - t0 - T(2) * d) * jerk, jerk};
  }

  /// Track axes a time `tau` after a reading.
  std::array<Vec<T>, 3> Axes(const Reading& at, const T& tau) const {
    const Vec<T> v = at.velocity + tau * at.acceleration + (tau * tau / T(2)) * at.jerk;
    const Vec<T> along = Unit(v);
    const Vec<T> vertical = VerticalOf(block_.frame, Moved(at, tau)).up;
    const Vec<T> up = Unit(vertical - Dot(vertical, along) * along);
    return {along, Cross(up, along), up};
  }
  static Vec<T> Moved(const Reading& at, const T& tau) {
    return at.position +
           tau * (at.velocity + (tau / T(2)) * (at.acceleration + (tau / T(3)) * at.jerk));
  }

  static T Legendre(int degree, const T& x) {
    const T x2 = x * x;
    switch (degree) {
      case 0:
        return 1;
      case 1:
        return x;
      case 2:
        return (T(3) * x2 - T(1)) / T(2);
      case 3:
        return (T(5) * x2 - T(3)) * x / T(2);
      case 4:
        return (T(35) * x2 * x2 - T(30) * x2 + T(3)) / T(8);
      default:
        return (T(63) * x2 * x2 - T(70) * x2 + T(15)) * x / T(8);  // degree 5
    }
  }

  /// Corrected position a time `tau` after a reading at path time `read`, `track` the axes then;
  /// the measured time chooses the piece of a spline.
  Vec<T> Position(const Pass& pass,
                  const T& measured,
                  const T& read,
                  const Reading& at,
                  const T& tau,
                  const std::array<Vec<T>, 3>& track,
                  const Value& value) const {
    const T t = read + tau;
    Vec<T> s = Moved(at, tau);
    static const std::array<std::array<const char*, 3>, 2> kNames = {
        {{"along", "across", "up"}, {"x", "y", "z"}}};
    ForEachGroup(pass, [&](const CorrectionGroup& group) {
      const auto* c = std::get_if<PositionCorrection>(&group.model);
      if (c == nullptr) return;
      const bool in_track = c->axes == PositionCorrection::Axes::kTrack;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!c->components[axis]) continue;
        const std::string name = std::string("position.") + kNames[in_track ? 0 : 1][axis] + ".";
        const std::string owner = group.shared ? group.name : pass.id;
        const T shift = c->basis == PositionCorrection::Basis::kSpline
                            ? SplineSum(group, *c, pass, measured, t, owner, name, value)
                            : LegendreSum(*c, pass, t, owner, name, value);
        Vec<T> e = {T(0), T(0), T(0)};
        e[axis] = T(1);
        s = s + shift * (in_track ? track[axis] : e);
      }
    });
    return s;
  }

  static T LegendreSum(const PositionCorrection& c,
                       const Pass& pass,
                       const T& t,
                       const std::string& owner,
                       const std::string& name,
                       const Value& value) {
    const T start = pass.start_s, end = pass.end_s;
    const T x = (T(2) * t - start - end) / (end - start);
    T out = 0;
    for (int k = 0; k <= c.degree; ++k) {
      out += value(owner, name + std::to_string(k)) * Legendre(k, x);
    }
    return out;
  }

  T SplineSum(const CorrectionGroup& group,
              const PositionCorrection& c,
              const Pass& pass,
              const T& measured,
              const T& t,
              const std::string& owner,
              const std::string& name,
              const Value& value) const {
    using std::floor;
    double start_s = pass.start_s, end_s = pass.end_s;
    if (group.shared) {
      for (const Pass& other : block_.passes) {
        bool member = group.passes.empty();
        for (const std::string& id : group.passes) member = member || id == other.id;
        if (!member) continue;
        start_s = std::min(start_s, other.start_s);
        end_s = std::max(end_s, other.end_s);
      }
    }
    const double pieces = std::ceil((end_s - start_s) / c.knot_spacing_s);
    const T spacing = (T(end_s) - T(start_s)) / T(pieces);
    const int piece = static_cast<int>(floor((measured - T(start_s)) / spacing));
    const T u = (t - T(start_s)) / spacing - T(piece), w = T(1) - u;
    const std::array<T, 4> b = {w * w * w / T(6),
                                (T(4) - T(6) * u * u + T(3) * u * u * u) / T(6),
                                (T(4) - T(6) * w * w + T(3) * w * w * w) / T(6),
                                u * u * u / T(6)};
    T out = 0;
    for (int k = 0; k < 4; ++k) {
      out += value(owner, name + std::to_string(piece + k)) * b[static_cast<std::size_t>(k)];
    }
    return out;
  }

  const Block& block_;
  const std::vector<CorrectionGroup>& groups_;
};

}  // namespace sarblock::test
