// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"

#include <array>

#include <Eigen/Core>
#include <boost/multiprecision/cpp_bin_float.hpp>

namespace sarblock::test {

/// 50 digits without expression templates, so that `auto` and ?: behave.
using Real = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>,
                                           boost::multiprecision::et_off>;
using RealVector = std::array<Real, 3>;

inline RealVector Exact(const Eigen::Vector3d& a) { return {Real(a[0]), Real(a[1]), Real(a[2])}; }
inline Eigen::Vector3d Rounded(const RealVector& a) {
  return {static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])};
}

/// a + s b
inline RealVector Sum(const RealVector& a, const Real& s, const RealVector& b) {
  return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
}
inline RealVector Scaled(const Real& s, const RealVector& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
inline Real InnerProduct(const RealVector& a, const RealVector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline RealVector Unit(const RealVector& a) { return Scaled(1 / sqrt(InnerProduct(a, a)), a); }

/// The ellipsoidal vertical at p, sharing nothing with the library: the foot point is found from
/// Lagrange's condition p = q + k grad(q)/2, one unknown k, by Newton's iteration on the equation
/// of the ellipsoid: sum p_i^2 a_i^2/(a_i^2 + k)^2 = 1.
inline RealVector ExactUp(const Ellipsoid& ellipsoid, const RealVector& p) {
  const Real a = ellipsoid.a_m;
  const Real b = a * (1 - Real(ellipsoid.flattening));
  const RealVector squares = {a * a, a * a, b * b};
  Real k = 0;
  for (int i = 0; i < 60; ++i) {
    Real value = -1, slope = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      const Real d = squares[j] + k;
      value += p[j] * p[j] * squares[j] / (d * d);
      slope -= 2 * p[j] * p[j] * squares[j] / (d * d * d);
    }
    k -= value / slope;
  }
  // q_i = p_i a_i^2/(a_i^2 + k), so the gradient q_i/a_i^2 is p_i/(a_i^2 + k).
  return Unit({p[0] / (squares[0] + k), p[1] / (squares[1] + k), p[2] / (squares[2] + k)});
}

}  // namespace sarblock::test
