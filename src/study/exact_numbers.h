// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include <boost/multiprecision/cpp_bin_float.hpp>

/// Arithmetic of the exact adjustment: 50 decimal digits, vectors of any scalar, and two kinds of
/// numbers that carry derivatives, so that no partial of a path or of a vertical is written by
/// hand here.
namespace sarblock::exact {

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

/// A function of time at one time: value, first and second derivative.
template <typename T>
struct Series {
  T c0 = T(0), c1 = T(0), c2 = T(0);

  Series() = default;
  Series(const T& value) : c0(value) {}  // NOLINT: a constant is a series
  Series(const T& value, const T& first, const T& second) : c0(value), c1(first), c2(second) {}

  friend Series operator+(const Series& a, const Series& b) {
    return {a.c0 + b.c0, a.c1 + b.c1, a.c2 + b.c2};
  }
  friend Series operator-(const Series& a, const Series& b) {
    return {a.c0 - b.c0, a.c1 - b.c1, a.c2 - b.c2};
  }
  friend Series operator*(const Series& a, const Series& b) {
    return {a.c0 * b.c0, a.c1 * b.c0 + a.c0 * b.c1, a.c2 * b.c0 + T(2) * a.c1 * b.c1 + a.c0 * b.c2};
  }
  friend Series operator/(const Series& a, const Series& b) {
    const T q0 = a.c0 / b.c0;
    const T q1 = (a.c1 - q0 * b.c1) / b.c0;
    return {q0, q1, (a.c2 - T(2) * q1 * b.c1 - q0 * b.c2) / b.c0};
  }
  friend Series sqrt(const Series& a) {
    using std::sqrt;
    const T r0 = sqrt(a.c0);
    const T r1 = a.c1 / (T(2) * r0);
    return {r0, r1, (a.c2 - T(2) * r1 * r1) / (T(2) * r0)};
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

}  // namespace sarblock::exact
