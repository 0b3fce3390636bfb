// SPDX-License-Identifier: Apache-2.0
// What a look measures, predicted. Evidence: a closed form, difference quotients, invariance.
#include "sarblock/geometry/look_equations.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// A look from a turning, climbing flight, squinted, its cone axis off the velocity.
LookGeometry TurningLook() {
  LookGeometry at;
  at.line_of_sight_m = {310.0, 4170.0, -2930.0};
  at.motion.velocity_mps = {103.0, 11.0, 3.7};
  at.motion.acceleration_mps2 = {0.31, -1.7, 0.23};
  at.motion.jerk_mps3 = {0.07, 0.04, -0.11};
  at.cone.squint_rad = 0.041;
  at.squint_bias_rad = 0.0017;
  at.axis_turn_rad = {2e-4, -7e-4, 5e-4};
  at.axis_turn_rad_per_s = {3e-5, 1e-5, -2e-5};
  return at;
}

// Closed form: straight flight, the point L ahead of abeam: L / v later, at its distance from the
// line; with a squint tau the antenna is r tan(tau) before abeam.
TEST(PredictLookTest, IsTheClosedFormOfAStraightFlight) {
  LookGeometry at;
  at.line_of_sight_m = {250.0, 4000.0, -3000.0};
  at.motion.velocity_mps = {125.0, 0.0, 0.0};
  LookPrediction out;
  ASSERT_TRUE(PredictLook(at, &out));
  EXPECT_NEAR(out.delay_s, 2.0, 1e-12);
  EXPECT_NEAR(out.range_m, 5000.0, 1e-9);
  EXPECT_NEAR(out.cone_rate_mps, 125.0, 1e-9);
  EXPECT_LT((out.line_of_sight_m - Eigen::Vector3d(0.0, 4000.0, -3000.0)).norm(), 1e-9);
  at.cone.squint_rad = 0.19;
  ASSERT_TRUE(PredictLook(at, &out));
  EXPECT_NEAR(out.delay_s, (250.0 - 5000.0 * std::tan(0.19)) / 125.0, 1e-11);
  EXPECT_NEAR(out.range_m, 5000.0 / std::cos(0.19), 1e-8);
  EXPECT_NEAR(out.cone_rate_mps, 125.0 * std::cos(0.19) * std::cos(0.19), 1e-9);
  EXPECT_NEAR(out.along_mps, 125.0, 1e-9);
}

// Central differences. Steps that move the look by a metre or less leave a relative error of 1e-7
// by the third derivatives and 1e-9 by rounding.
TEST(PredictLookTest, HasThePartialsOfDifferenceQuotients) {
  const LookGeometry at = TurningLook();
  LookPrediction out;
  ASSERT_TRUE(PredictLook(at, &out));
  const auto slope = [&](auto member, int axis, double step) {
    Eigen::Vector2d value[2];
    for (int side = 0; side < 2; ++side) {
      LookGeometry moved = at;
      member(&moved)[axis] += side == 0 ? step : -step;
      LookPrediction there;
      EXPECT_TRUE(PredictLook(moved, &there));
      value[side] = {there.range_m, there.delay_s};
    }
    return Eigen::Vector2d((value[0] - value[1]) / (2.0 * step));
  };
  const auto line = [](LookGeometry* g) { return g->line_of_sight_m.data(); };
  const auto velocity = [](LookGeometry* g) { return g->motion.velocity_mps.data(); };
  const auto acceleration = [](LookGeometry* g) { return g->motion.acceleration_mps2.data(); };
  const auto axis_turn_rad = [](LookGeometry* g) { return g->axis_turn_rad.data(); };
  const auto squint = [](LookGeometry* g) { return &g->squint_bias_rad; };
  const Eigen::Vector2d scale(1.0, 1.0 / 103.0);  // of a partial by metres
  const auto near = [&scale](const Eigen::Vector2d& a, const Eigen::Vector2d& b, double size) {
    EXPECT_LT((a - b).cwiseQuotient(scale).norm(), 1e-6 * size);
  };
  for (int k = 0; k < 3; ++k) {
    near(out.d_point.col(k), slope(line, k, 1.0), 1.0);
    near(out.d_position.col(k), -slope(line, k, 1.0), 1.0);
    near(out.d_velocity.col(k), slope(velocity, k, 0.02), 50.0);
    near(out.d_acceleration.col(k), slope(acceleration, k, 0.002), 100.0);
    near(out.d_axis.col(k), slope(axis_turn_rad, k, 1e-4), 5000.0);
  }
  near(out.d_squint, slope(squint, 0, 1e-4), 5000.0);
}

// Invariance: read elsewhere along its own motion the antenna meets the cone at the same time.
TEST(PredictLookTest, DoesNotDependOnWhereTheAntennaIsRead) {
  const LookGeometry at = TurningLook();
  LookPrediction here, there;
  ASSERT_TRUE(PredictLook(at, &here));
  constexpr double kLater_s = 0.37;
  LookGeometry moved = at;
  moved.motion.position_m = -at.line_of_sight_m;  // the point is the origin
  moved.motion = moved.motion.After(kLater_s);
  moved.line_of_sight_m = -moved.motion.position_m;
  moved.axis_turn_rad += kLater_s * at.axis_turn_rad_per_s;
  ASSERT_TRUE(PredictLook(moved, &there));
  EXPECT_NEAR(there.delay_s, here.delay_s - kLater_s, 1e-11);
  EXPECT_NEAR(there.range_m, here.range_m, 1e-8);
  EXPECT_LT((there.d_point - here.d_point).norm(), 1e-10);
}

TEST(PredictLookTest, HasNoValueWhereItsHeaderSaysSo) {
  const auto has_value = [](auto change) {
    LookGeometry at = TurningLook();
    change(&at);
    LookPrediction out;
    return PredictLook(at, &out);
  };
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(has_value([](LookGeometry*) {}));
  EXPECT_FALSE(has_value([](LookGeometry* at) { at->line_of_sight_m.setZero(); }));
  EXPECT_FALSE(has_value([](LookGeometry* at) { at->line_of_sight_m[1] = kNone; }));
  EXPECT_FALSE(has_value([](LookGeometry* at) { at->motion = {}; }));
  EXPECT_FALSE(has_value([](LookGeometry* at) { at->axis_turn_rad[2] = kNone; }));
  EXPECT_FALSE(has_value([](LookGeometry* at) {
    at->cone.kind = Cone::Kind::kDoppler;
    at->cone.closing_mps = 200.0;  // faster than the antenna
  }));
  EXPECT_FALSE(has_value([](LookGeometry* at) {  // around the point: the cone turns with it
    at->line_of_sight_m = {0.0, 1000.0, 0.0};
    at->motion.velocity_mps = {100.0, 0.0, 0.0};
    at->motion.acceleration_mps2 = {0.0, 10.0, 0.0};
    at->motion.jerk_mps3.setZero();
    at->cone.squint_rad = at->squint_bias_rad = 0.0;
    at->axis_turn_rad.setZero();
    at->axis_turn_rad_per_s.setZero();
  }));
}

}  // namespace
}  // namespace sarblock
