// SPDX-License-Identifier: Apache-2.0
// The turning of the vertical along a path against 50-digit finite differences.
#include "sarblock/geometry/frame.h"

#include <vector>

#include "geometry/fifty_digits.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::Vector3d;
using test::Exact;
using test::Real;
using test::RealVector;
using test::Rounded;
using test::Scaled;
using test::Sum;

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
      const RealVector place = Sum(Exact(c.p_m), t, Exact(c.v_mps));
      return test::ExactUp(c.ellipsoid, Sum(place, t * t / 2, Exact(c.a_mps2)));
    };
    const Real h("1e-10");
    const RealVector before = up_at(-h);
    const RealVector here = up_at(Real(0));
    const RealVector after = up_at(h);
    const Vector3d rate = Rounded(Scaled(1 / (2 * h), Sum(after, -1, before)));
    const Vector3d acceleration =
        Rounded(Scaled(1 / (h * h), Sum(Sum(after, -2, here), 1, before)));
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
