// SPDX-License-Identifier: Apache-2.0
// The turning of the vertical along a path against 50-digit finite differences.
#include "sarblock/geometry/frame.h"

#include <vector>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::Vector3d;
using Real = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>,
                                           boost::multiprecision::et_off>;

struct RealVector {
  Real x, y, z;
};
RealVector operator+(const RealVector& a, const RealVector& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
RealVector operator*(const Real& s, const RealVector& a) { return {s * a.x, s * a.y, s * a.z}; }
RealVector ToReal(const Vector3d& a) { return {Real(a.x()), Real(a.y()), Real(a.z())}; }
Vector3d Rounded(const RealVector& a) {
  return {static_cast<double>(a.x), static_cast<double>(a.y), static_cast<double>(a.z)};
}

// The vertical at p in 50 digits, sharing nothing with the library: the foot point is found from
// Lagrange's condition p = q + k grad(q)/2, one unknown k, by Newton's iteration on the equation
// of the ellipsoid: sum p_i^2 a_i^2/(a_i^2 + k)^2 = 1.
RealVector RealVertical(const Ellipsoid& ellipsoid, const RealVector& p) {
  const Real a = ellipsoid.a_m;
  const Real b = a * (Real(1) - Real(ellipsoid.flattening));
  const Real a2 = a * a;
  const Real b2 = b * b;
  const Real rho2 = p.x * p.x + p.y * p.y;
  Real k = 0;
  for (int i = 0; i < 60; ++i) {
    const Real ka = a2 + k;
    const Real kb = b2 + k;
    const Real value = rho2 * a2 / (ka * ka) + p.z * p.z * b2 / (kb * kb) - 1;
    const Real slope = -2 * (rho2 * a2 / (ka * ka * ka) + p.z * p.z * b2 / (kb * kb * kb));
    k -= value / slope;
  }
  // q_i = p_i a_i^2/(a_i^2 + k), so the gradient q_i/a_i^2 is p_i/(a_i^2 + k).
  const RealVector gradient = {p.x / (a2 + k), p.y / (a2 + k), p.z / (b2 + k)};
  const Real length =
      sqrt(gradient.x * gradient.x + gradient.y * gradient.y + gradient.z * gradient.z);
  return (Real(1) / length) * gradient;
}

struct MovingPoint {
  Ellipsoid ellipsoid;
  Vector3d p_m, v_mps, a_mps2;
};

std::vector<MovingPoint> MovingPoints() {
  const Ellipsoid flat{"very flat", 3.1e6, 0.11};
  return {
      {NamedEllipsoid("WGS84"),
       {4690113.37, 1310207.11, 5120331.73},
       {-5213.7, -1107.3, 5413.9},
       {-5.31, -1.47, -5.87}},
      {NamedEllipsoid("WGS84"), {-311.7, 217.9, 6371003.3}, {213.1, 97.7, 3.3}, {0.7, -0.3, 0.9}},
      {NamedEllipsoid("Mars"), {1.1e6 + 0.7, -3.4e6, 0.3}, {317.1, 91.3, 3400.7}, {0.1, 3.1, 0.2}},
      {flat, {2.13e6, -1.07e6, 2.31e6}, {-3711.3, 2909.1, 1717.7}, {3.7, 91.3, -17.9}},
      {flat, {1.3e6, 2.7e6, -0.9e6}, {171.3, -33.7, 711.1}, {-39.7, 11.3, 27.1}},
  };
}

// Path p + v t + a t^2/2, central differences with steps of 1e-10 s: truncation and rounding in 50
// digits stay below 1e-20 of the values, so the tolerance of 1e-12 of the largest term is the
// library's. The largest terms of the second derivative are (|v|/|p|)^2 and |a|/|p|.
TEST(VerticalAlongTest, AgreesWithFiftyDigitFiniteDifferences) {
  for (const MovingPoint& c : MovingPoints()) {
    const VerticalMotion motion =
        Frame::Geocentric(c.ellipsoid).VerticalAlong(c.p_m, c.v_mps, c.a_mps2);
    const auto up_at = [&c](const Real& t) {
      return RealVertical(c.ellipsoid,
                          ToReal(c.p_m) + t * ToReal(c.v_mps) + (t * t / 2) * ToReal(c.a_mps2));
    };
    const Real h("1e-10");
    const RealVector before = up_at(-h);
    const RealVector here = up_at(Real(0));
    const RealVector after = up_at(h);
    const Vector3d rate = Rounded((Real(1) / (2 * h)) * (after + Real(-1) * before));
    const Vector3d acceleration = Rounded((Real(1) / (h * h)) * (after + Real(-2) * here + before));
    const double turn = c.v_mps.norm() / c.p_m.norm();
    EXPECT_LE((motion.up - Rounded(here)).norm(), 1e-15);
    EXPECT_LE((motion.rate - rate).norm(), 1e-14 * turn);
    EXPECT_LE((motion.acceleration - acceleration).norm(),
              1e-13 * (turn * turn + c.a_mps2.norm() / c.p_m.norm()));
    EXPECT_GT(acceleration.norm(), 1e-3 * turn * turn);  // the comparison is not of zeros
  }
}

// Closed form: on a circle about the axis of a sphere the vertical turns with the circle.
TEST(VerticalAlongTest, TurnsWithACircleAroundASphere) {
  const double r_m = 1.8374e6;
  const double rate_radps = 9.173e-4;
  const VerticalMotion motion = Frame::Geocentric(NamedEllipsoid("Moon"))
                                    .VerticalAlong({r_m, 0.0, 0.0},
                                                   {0.0, r_m * rate_radps, 0.0},
                                                   {-r_m * rate_radps * rate_radps, 0.0, 0.0});
  EXPECT_LE((motion.up - Vector3d::UnitX()).norm(), 1e-15);
  EXPECT_LE((motion.rate - rate_radps * Vector3d::UnitY()).norm(), 1e-18);
  EXPECT_LE((motion.acceleration + rate_radps * rate_radps * Vector3d::UnitX()).norm(), 1e-20);
}

}  // namespace
}  // namespace sarblock
