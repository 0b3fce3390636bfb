// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/path.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::Vector3d;

const Vector3d kC0(4690113.37, 1310207.11, 5120331.73);  // low orbit, values not round
const Vector3d kC1(-5213.7, -1107.3, 5413.9);
const Vector3d kC2(-2.653, -0.731, -2.937);
const Vector3d kC3(0.00091, 0.00031, -0.00107);

// Values at x seconds after the origin of one cubic.
Motion Cubic(double x) {
  return {.position_m = kC0 + x * (kC1 + x * (kC2 + x * kC3)),
          .velocity_mps = kC1 + x * (2.0 * kC2 + 3.0 * x * kC3),
          .acceleration_mps2 = 2.0 * kC2 + 6.0 * x * kC3,
          .jerk_mps3 = 6.0 * kC3};
}

// Cubic states at `times` after `origin_s`; times are multiples of 1/64 s so that the sum with a
// large origin is exact.
FlightPath CubicPath(double origin_s, const std::vector<double>& times) {
  std::vector<StateVector> states;
  for (const double x : times) {
    const Motion motion = Cubic(x);
    states.push_back({origin_s + x, motion.position_m, motion.velocity_mps});
  }
  return FlightPath(states);
}

const std::vector<double> kEqual = {0.0, 10.25, 20.5, 30.75, 41.0};
const std::vector<double> kUnequal = {0.0, 3.75, 20.5, 22.015625, 41.0};

// Closed form: Hermite interpolation reproduces a cubic. Position rounds at the ulp of 7e6 m
// (1e-9); in the derivatives the rounding of the given positions is divided by the spacing:
// 1e-9/1.5 s.
TEST(FlightPathTest, ReproducesACubicEverywhereAndAtAnyTimeOrigin) {
  for (const double origin_s : {0.0, 1.4e9}) {
    for (const auto& times : {kEqual, kUnequal}) {
      const FlightPath path = CubicPath(origin_s, times);
      for (int i = 0; i <= 41 * 8; ++i) {
        const double x = 0.125 * i;
        const auto motion = path.At(origin_s + x);
        ASSERT_TRUE(motion.has_value());
        const Motion truth = Cubic(x);
        EXPECT_LE((motion->position_m - truth.position_m).norm(), 5e-9) << x;
        EXPECT_LE((motion->velocity_mps - truth.velocity_mps).norm(), 1e-8) << x;
        EXPECT_LE((motion->acceleration_mps2 - truth.acceleration_mps2).norm(), 3e-8) << x;
        EXPECT_LE((motion->jerk_mps3 - truth.jerk_mps3).norm(), 5e-8) << x;
      }
    }
  }
}

// States that no one cubic fits: a circle.
FlightPath CirclePath(const std::vector<double>& times) {
  std::vector<StateVector> states;
  for (const double t : times) {
    const double angle = 1.07e-3 * t;
    states.push_back({t,
                      7.0713e6 * Vector3d(std::cos(angle), std::sin(angle), 0.0),
                      7.0713e6 * 1.07e-3 * Vector3d(-std::sin(angle), std::cos(angle), 0.0)});
  }
  return FlightPath(states);
}

TEST(FlightPathTest, PassesThroughItsStates) {
  for (const auto& times : {kEqual, kUnequal}) {
    const FlightPath path = CirclePath(times);
    for (const StateVector& state : path.states()) {
      const auto motion = path.At(state.time_s);
      ASSERT_TRUE(motion.has_value());
      EXPECT_LE((motion->position_m - state.position_m).norm(), 2e-9);
      EXPECT_LE((motion->velocity_mps - state.velocity_mps).norm(), 1e-9);
    }
  }
}

TEST(FlightPathTest, PositionAndVelocityAreContinuousAtAState) {
  const FlightPath path = CirclePath(kUnequal);
  for (std::size_t k = 1; k + 1 < kUnequal.size(); ++k) {
    const double before_s = std::nextafter(kUnequal[k], 0.0);  // 4e-15 s, 3e-11 m earlier
    const auto before = path.At(before_s);
    const auto after = path.At(kUnequal[k]);
    EXPECT_LE((before->position_m - after->position_m).norm(), 5e-9);
    EXPECT_LE((before->velocity_mps - after->velocity_mps).norm(), 2e-9);
    // The acceleration jumps: which piece answers is decided by which side of the state it is.
    EXPECT_GT((before->acceleration_mps2 - after->acceleration_mps2).norm(), 1e-8);
  }
}

// The stated bound h^4/384 max|s''''|: attained within a per cent at the middle of a short piece.
TEST(FlightPathTest, InterpolationErrorOfACircleIsTheOneStated) {
  const FlightPath path = CirclePath(kEqual);
  const double angle = 1.07e-3 * 15.375;  // the middle of the second piece
  const Vector3d truth = 7.0713e6 * Vector3d(std::cos(angle), std::sin(angle), 0.0);
  const double bound_m = std::pow(10.25 * 1.07e-3, 4) * 7.0713e6 / 384.0;  // 0.27 mm
  const double error_m = (path.At(15.375)->position_m - truth).norm();
  EXPECT_LE(error_m, bound_m);
  EXPECT_GE(error_m, 0.99 * bound_m);
}

// Second route: times equally spaced to the milliseconds of a file, not to the last bit, against
// the same states with one more far off, which are searched. Both must take the piece that holds
// the time and not its neighbour, whose acceleration differs.
TEST(FlightPathTest, RoundedTimesChooseTheRightPiece) {
  std::vector<double> times;
  for (int k = 0; k < 40; ++k) times.push_back(std::round(1e3 * k * 10.0 / 3.0) / 1e3);
  const FlightPath equal = CirclePath(times);
  times.push_back(1000.0);  // the same states and one more, far off: searched, not counted
  const FlightPath searched = CirclePath(times);
  for (std::size_t k = 0; k < 40; ++k) {
    for (const double step_s : {-1e-9, -1e-4, 0.0, 1e-4, 1e-9}) {
      const double t_s = times[k] + step_s;
      if (t_s < equal.start_s() || t_s >= equal.end_s()) continue;
      const auto a = equal.At(t_s);
      const auto b = searched.At(t_s);
      EXPECT_EQ(a->position_m, b->position_m);
      EXPECT_EQ(a->acceleration_mps2, b->acceleration_mps2);
    }
  }
}

// Closed form: a straight flight whose states are rounded is one piece; one that turns is not.
TEST(FlightPathTest, JoinsStatesOfAStraightFlight) {
  const Vector3d from_m(-717.8186409, 38000.0, 10000.0), velocity_mps(179.9, 3.7, -0.2);
  for (const double bend_mps2 : {0.0, 1e-9}) {
    std::vector<StateVector> states;
    for (int k = 0; k < 300; ++k) {
      const double t_s = 5123.7 + 1.0 / 3.0 * k, x_s = t_s - 5123.7;
      const Vector3d bend(0.0, bend_mps2, 0.0);
      states.push_back(
          {t_s, from_m + x_s * velocity_mps + 0.5 * x_s * x_s * bend, velocity_mps + x_s * bend});
    }
    const FlightPath path(states);
    EXPECT_EQ(path.IsStraight(), bend_mps2 == 0.0);
    for (const double x_s : {0.0, 0.1, 41.7, 99.0}) {
      const auto motion = path.At(5123.7 + x_s);
      ASSERT_TRUE(motion.has_value());
      const Vector3d bent_m(0.0, 0.5 * x_s * x_s * bend_mps2, 0.0);
      EXPECT_LE((motion->position_m - from_m - x_s * velocity_mps - bent_m).norm(), 1e-9) << x_s;
      EXPECT_EQ(motion->acceleration_mps2.isZero(0.0), bend_mps2 == 0.0);
    }
  }
}

// Straight legs joined by a turn: each leg is one piece, the turn keeps its own.
TEST(FlightPathTest, FindsThePieceAmongJoinedOnes) {
  std::vector<StateVector> states;
  for (int k = 0; k < 20; ++k) {
    states.push_back({1.0 * k, Vector3d(100.0 * k, 0.0, 5000.0), Vector3d(100.0, 0.0, 0.0)});
  }
  for (int k = 0; k < 20; ++k) {
    states.push_back(
        {25.0 + k, Vector3d(2400.0, 60.0 + 100.0 * k, 5000.0), Vector3d(0.0, 100.0, 0.0)});
  }
  const FlightPath path(states);
  EXPECT_FALSE(path.IsStraight());
  EXPECT_EQ(path.At(7.25)->position_m, Vector3d(725.0, 0.0, 5000.0));
  EXPECT_EQ(path.At(30.5)->position_m, Vector3d(2400.0, 610.0, 5000.0));
  EXPECT_GT(path.At(22.0)->acceleration_mps2.norm(), 1.0);
  for (const StateVector& state : states) {
    EXPECT_LE((path.At(state.time_s)->position_m - state.position_m).norm(), 1e-11);
  }
}

TEST(FlightPathTest, RefusesATimeOutsideTheSpan) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& times : {kEqual, kUnequal}) {
    const FlightPath path = CubicPath(1.4e9, times);
    EXPECT_TRUE(path.At(path.start_s()).has_value());
    EXPECT_TRUE(path.At(path.end_s()).has_value());
    EXPECT_FALSE(path.At(std::nextafter(path.start_s(), 0.0)).has_value());
    EXPECT_FALSE(path.At(std::nextafter(path.end_s(), 2e9)).has_value());
    EXPECT_FALSE(path.At(nan).has_value());
  }
  EXPECT_FALSE(FlightPath().At(0.0).has_value());
}

TEST(FlightPathTest, RefusesStatesThatAreNoPath) {
  const double inf = std::numeric_limits<double>::infinity();
  const StateVector a{1.5, {1.0, 2.0, 3.0}, {70.3, 0.1, 0.2}};
  const StateVector b{2.7, {85.0, 2.0, 3.0}, {70.1, 0.2, 0.1}};
  EXPECT_NO_THROW(FlightPath({a, b}));
  EXPECT_THROW(FlightPath(std::vector<StateVector>{}), InputError);
  EXPECT_THROW(FlightPath({a}), InputError);
  EXPECT_THROW(FlightPath({b, a}), InputError);
  EXPECT_THROW(FlightPath({a, a}), InputError);
  StateVector bad = b;
  bad.velocity_mps.setZero();
  EXPECT_THROW(FlightPath({a, bad}), InputError);
  bad = b;
  bad.position_m.y() = inf;
  EXPECT_THROW(FlightPath({a, bad}), InputError);
  bad = b;
  bad.time_s = inf;
  EXPECT_THROW(FlightPath({a, bad}), InputError);
}

}  // namespace
}  // namespace sarblock
