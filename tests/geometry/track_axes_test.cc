// SPDX-License-Identifier: Apache-2.0
#include "geometry/track_axes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/fifty_digits.h"
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::Exact;
using test::InnerProduct;
using test::Real;
using test::RealVector;
using test::Sum;
using test::Unit;

// Hand value: flight along +x of a flat frame has the axes x, y, z, and they stay.
TEST(TrackAxesTest, AreTheAxesOfLeberlsFrame) {
  const TrackAxes axes = TrackAxesOf(
      Frame::Local(), {.position_m = {17.3, 5.1, 3007.9}, .velocity_mps = {71.3, 0.0, 0.0}});
  EXPECT_EQ(axes.axes, Matrix3d::Identity());
  EXPECT_EQ(axes.rate, Matrix3d::Zero());
  EXPECT_EQ(axes.acceleration, Matrix3d::Zero());
}

// Hand value: climbing with slope 3 in 4 towards +y; up leans back, across points to -x.
TEST(TrackAxesTest, UpIsOrthogonalToAClimbingTrack) {
  const TrackAxes axes = TrackAxesOf(Frame::Local(), {.velocity_mps = {0.0, 80.0, 60.0}});
  Matrix3d expected;
  expected.col(0) << 0.0, 0.8, 0.6;
  expected.col(1) << -1.0, 0.0, 0.0;
  expected.col(2) << 0.0, -0.6, 0.8;
  EXPECT_LE((axes.axes - expected).norm(), 1e-15);
}

// Closed form: on a circular orbit about a sphere all axes turn with the orbit, at the rate w about
// the orbit normal m: axes' = w m x axes, axes'' = w^2 m x (m x axes).
TEST(TrackAxesTest, TurnWithACircularOrbit) {
  const double w = 9.173e-4;
  const double r_m = 1.8374e6;
  const Vector3d m = Vector3d(0.31, -0.77, 0.53).normalized();
  const Vector3d radial = m.cross(Vector3d(0.7, 0.2, -0.4)).normalized();
  const Vector3d forward = m.cross(radial);
  const Motion motion{.position_m = r_m * radial,
                      .velocity_mps = r_m * w * forward,
                      .acceleration_mps2 = -r_m * w * w * radial,
                      .jerk_mps3 = -r_m * w * w * w * forward};
  const TrackAxes axes = TrackAxesOf(Frame::Geocentric(NamedEllipsoid("Moon")), motion);
  Matrix3d expected;
  expected << forward, radial.cross(forward), radial;
  EXPECT_LE((axes.axes - expected).norm(), 1e-15);
  EXPECT_LE((expected.col(1) - m).norm(), 1e-15);  // across is the orbit normal: left of track
  for (int k = 0; k < 3; ++k) {
    const Vector3d turned = m.cross(expected.col(k));
    EXPECT_LE((axes.rate.col(k) - w * turned).norm(), 1e-14 * w);
    EXPECT_LE((axes.acceleration.col(k) - w * w * m.cross(turned)).norm(), 1e-14 * w * w);
  }
}

// The nine numbers of the axes at t, from the path s + v t + a t^2/2 + j t^3/6.
std::array<RealVector, 3> ExactAxes(const Ellipsoid* ellipsoid,
                                    const Motion& motion,
                                    const Real& t) {
  const RealVector s = Exact(motion.position_m), v = Exact(motion.velocity_mps);
  const RealVector a = Exact(motion.acceleration_mps2), j = Exact(motion.jerk_mps3);
  const RealVector place = Sum(Sum(Sum(s, t, v), t * t / 2, a), t * t * t / 6, j);
  const RealVector along = Unit(Sum(Sum(v, t, a), t * t / 2, j));
  const RealVector vertical =
      ellipsoid == nullptr ? RealVector{0, 0, 1} : test::ExactUp(*ellipsoid, place);
  const RealVector up = Unit(Sum(vertical, -InnerProduct(vertical, along), along));
  const RealVector across = {up[1] * along[2] - up[2] * along[1],
                             up[2] * along[0] - up[0] * along[2],
                             up[0] * along[1] - up[1] * along[0]};
  return {along, across, up};
}

void ExpectTrackAxesOf(const Ellipsoid* ellipsoid, const Motion& motion, double turn_radps) {
  const Frame frame = ellipsoid == nullptr ? Frame::Local() : Frame::Geocentric(*ellipsoid);
  const TrackAxes axes = TrackAxesOf(frame, motion);
  const Real h("1e-10");
  const auto before = ExactAxes(ellipsoid, motion, -h);
  const auto here = ExactAxes(ellipsoid, motion, Real(0));
  const auto after = ExactAxes(ellipsoid, motion, h);
  double largest = 0.0;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) {
      const auto c = static_cast<std::size_t>(k);
      const auto r = static_cast<std::size_t>(i);
      const Real first = (after[c][r] - before[c][r]) / (2 * h);
      const Real second = (after[c][r] - 2 * here[c][r] + before[c][r]) / (h * h);
      EXPECT_NEAR(axes.axes(i, k), static_cast<double>(here[c][r]), 1e-15);
      EXPECT_NEAR(axes.rate(i, k), static_cast<double>(first), 1e-14 * turn_radps);
      EXPECT_NEAR(
          axes.acceleration(i, k), static_cast<double>(second), 1e-13 * turn_radps * turn_radps);
      largest = std::max(largest, std::abs(axes.acceleration(i, k)));
    }
  }
  EXPECT_GT(largest, 1e-2 * turn_radps * turn_radps);  // the comparison is not of zeros
}

// 50-digit central differences, step 1e-10 s (truncation and rounding below 1e-19). `turn` is about
// the rate at which the axes turn: |v|/|p| for an orbit, |a|/|v| for an aircraft in a curve.
TEST(TrackAxesTest, AgreeWithFiftyDigitFiniteDifferences) {
  const Ellipsoid wgs84 = NamedEllipsoid("WGS84");
  const Ellipsoid flat{"very flat", 3.1e6, 0.11};
  ExpectTrackAxesOf(&wgs84,
                    {.position_m = {4690113.37, 1310207.11, 5120331.73},
                     .velocity_mps = {-5213.7, -1107.3, 5413.9},
                     .acceleration_mps2 = {-5.31, -1.47, -5.87},
                     .jerk_mps3 = {0.0061, 0.0013, -0.0059}},
                    1.2e-3);
  ExpectTrackAxesOf(&flat,
                    {.position_m = {2.13e6, -1.07e6, 2.31e6},
                     .velocity_mps = {-1711.3, 2909.1, 717.7},
                     .acceleration_mps2 = {3.7, 9.3, -7.9},
                     .jerk_mps3 = {0.013, -0.0071, 0.0032}},
                    4e-3);
  ExpectTrackAxesOf(nullptr,
                    {.position_m = {917.3, -331.7, 3007.9},
                     .velocity_mps = {71.3, -11.9, 3.7},
                     .acceleration_mps2 = {0.31, 1.77, -0.23},
                     .jerk_mps3 = {-0.017, 0.031, 0.023}},
                    0.03);
}

TEST(TrackAxesTest, AreNotANumberWithoutATrack) {
  const Frame local = Frame::Local();
  EXPECT_TRUE(TrackAxesOf(local, {}).axes.array().isNaN().all());
  const TrackAxes vertical = TrackAxesOf(local, {.velocity_mps = {1e-6, 0.0, 70.3}});
  EXPECT_TRUE(vertical.axes.array().isNaN().all());
  EXPECT_TRUE(vertical.rate.array().isNaN().all());
  EXPECT_TRUE(vertical.acceleration.array().isNaN().all());
  const Motion not_a_number{.velocity_mps = Vector3d::Constant(std::nan(""))};
  EXPECT_TRUE(TrackAxesOf(local, not_a_number).axes.array().isNaN().all());
  const TrackAxes steep = TrackAxesOf(local, {.velocity_mps = {1e-3, 0.0, 70.3}});
  EXPECT_NEAR(steep.axes.determinant(), 1.0, 1e-12);
}

}  // namespace
}  // namespace sarblock
