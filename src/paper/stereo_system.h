// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/leberl/point_errors.h"

#include <array>
#include <cmath>

// The four equations of a stereo pair in any scalar type, used by stereo_errors.cc.
namespace sarblock::stereo {

/// A number with its derivative along one direction (forward mode).
struct Dual {
  long double value = 0.0L;
  long double slope = 0.0L;
};
inline Dual operator+(Dual a, Dual b) { return {a.value + b.value, a.slope + b.slope}; }
inline Dual operator-(Dual a, Dual b) { return {a.value - b.value, a.slope - b.slope}; }
inline Dual operator-(Dual a) { return {-a.value, -a.slope}; }
inline Dual operator*(Dual a, Dual b) {
  return {a.value * b.value, a.slope * b.value + a.value * b.slope};
}
inline Dual operator/(Dual a, Dual b) {
  const long double ratio = a.value / b.value;
  return {ratio, (a.slope - ratio * b.slope) / b.value};
}
inline Dual sqrt(Dual a) {
  const long double root = std::sqrt(a.value);
  return {root, a.slope / (2.0L * root)};
}

template <typename T>
using Vector = std::array<T, 3>;

template <typename T>
T Dot(const Vector<T>& a, const Vector<T>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <typename T>
T Norm(const Vector<T>& a) {
  using std::sqrt;  // a Dual finds its own by argument-dependent lookup
  return sqrt(Dot(a, a));
}

/// Solves the symmetric 3 x 3 normal equations sum(row row') p = sum(row right side) by cofactors.
/// The condition is that of a stereo pair squared; the 64-bit mantissa keeps 12 digits of it.
template <typename T>
Vector<T> LeastSquares(const std::array<Vector<T>, 4>& rows, const std::array<T, 4>& right) {
  std::array<Vector<T>, 3> n{};
  Vector<T> b{};
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      b[i] = b[i] + rows[k][i] * right[k];
      for (std::size_t j = 0; j < 3; ++j) n[i][j] = n[i][j] + rows[k][i] * rows[k][j];
    }
  }
  const auto cofactor = [&n](std::size_t i, std::size_t j) {
    const std::size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    return n[i1][j1] * n[i2][j2] - n[i1][j2] * n[i2][j1];
  };
  const T determinant =
      n[0][0] * cofactor(0, 0) + n[0][1] * cofactor(0, 1) + n[0][2] * cofactor(0, 2);
  Vector<T> p{};
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = (cofactor(i, 0) * b[0] + cofactor(i, 1) * b[1] + cofactor(i, 2) * b[2]) / determinant;
  }
  return p;
}

/// A station as the reconstruction uses it, relative to the true point's along-track coordinate.
template <typename T>
struct Station {
  Vector<T> antenna{};
  Vector<T> axis{};  ///< unit velocity direction
  T range{};
};

/// Errors (left minus measured side) and partials by p of Eq. 1-4: spheres first, then planes.
template <typename T>
struct Equations {
  std::array<T, 4> error{};
  std::array<Vector<T>, 4> row{};
};

template <typename T>
Equations<T> Evaluate(const Vector<T>& p, const std::array<Station<T>, 2>& stations) {
  Equations<T> out;
  for (std::size_t k = 0; k < 2; ++k) {
    const Station<T>& station = stations[k];
    Vector<T> sight{};
    for (std::size_t i = 0; i < 3; ++i) sight[i] = p[i] - station.antenna[i];
    const T rho = Norm(sight);
    out.error[k] = rho - station.range;
    out.error[k + 2] = Dot(station.axis, sight);
    for (std::size_t i = 0; i < 3; ++i) out.row[k][i] = sight[i] / rho;
    out.row[k + 2] = station.axis;
  }
  return out;
}

/// Derivative of Eq. 1-4's errors by the stations' errors, times `errors`, at the true point.
template <typename T>
std::array<T, 4> ErrorDirection(const Equations<T>& at_truth,
                                const std::array<Vector<T>, 2>& sights,
                                const std::array<leberl::StationErrors, 2>& errors) {
  const auto constant = [](double value) { return T{static_cast<long double>(value)}; };
  std::array<T, 4> direction{};
  for (std::size_t k = 0; k < 2; ++k) {
    const leberl::StationErrors& e = errors[k];
    const Vector<T> shift{constant(e.dx0_m), constant(e.dy0_m), constant(e.dz0_m)};
    const Vector<T> turn{constant(0.0), constant(e.dydot0_1), constant(e.dzdot0_1)};
    direction[k] = -Dot(at_truth.row[k], shift) - constant(e.dr_m);
    direction[k + 2] = Dot(turn, sights[k]) - Dot(at_truth.row[k + 2], shift);
  }
  return direction;
}

}  // namespace sarblock::stereo
