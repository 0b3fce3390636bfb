// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/geometry/look_equations.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

// A straight flight along x at 173 m/s and 9137 m up: At(t) = (173 t - 1200, 310, 9137).
constexpr double kSpeed_mps = 173.0;
FlightPath Straight() {
  std::vector<StateVector> states;
  for (const double t_s : {-3.0, 4.5, 19.0, 61.0}) {
    states.push_back({t_s, {kSpeed_mps * t_s - 1200.0, 310.0, 9137.0}, {kSpeed_mps, 0.0, 0.0}});
  }
  return FlightPath(states);
}

const Eigen::Vector3d kPoint_m(4321.7, 12834.0, 211.5);

// Closed form: the flight passes the cone where the point lies q tan(tau) ahead, q its distance
// from the flight line.
double ClosedForm_s(double squint_rad) {
  const double q_m = std::hypot(kPoint_m.y() - 310.0, kPoint_m.z() - 9137.0);
  return (kPoint_m.x() - q_m * std::tan(squint_rad) + 1200.0) / kSpeed_mps;
}

// e_d reaches 1e-9 m here and falls at 100 m/s or more: times to 1e-10 s.
constexpr double kTime_s = 1e-10;

TEST(ConeTimeTest, IsTheClosedFormOfAStraightFlightWithSquint) {
  const FlightPath path = Straight();
  for (const double squint_deg : {0.0, -7.3, 11.9}) {
    const Cone cone{.squint_rad = squint_deg * kRadPerDeg};
    const double expected_s = ClosedForm_s(cone.squint_rad);
    const auto found_s = FindConeTime(path, kPoint_m, cone, -3.0, 61.0);
    ASSERT_TRUE(found_s.has_value()) << squint_deg;
    EXPECT_NEAR(*found_s, expected_s, kTime_s) << squint_deg;
    const auto solved_s = SolveConeTime(path, kPoint_m, cone, expected_s + 4.7);
    ASSERT_TRUE(solved_s.has_value()) << squint_deg;
    EXPECT_NEAR(*solved_s, expected_s, kTime_s) << squint_deg;
  }
}

// v.d/rho = lambda f_D / 2 and sin(tau) = v.d/(|v| rho): the closed form with that squint.
TEST(ConeTimeTest, ADopplerConeIsTheSquintConeOfItsClosingSpeed) {
  Cone cone;
  cone.kind = Cone::Kind::kDoppler;
  cone.closing_mps = 0.5 * 0.0566 * 613.7;
  cone.squint_rad = 0.3;  // of the other kind, without meaning here
  const double expected_s = ClosedForm_s(std::asin(cone.closing_mps / kSpeed_mps));
  const auto found_s = FindConeTime(Straight(), kPoint_m, cone, -3.0, 61.0);
  ASSERT_TRUE(found_s.has_value());
  EXPECT_NEAR(*found_s, expected_s, kTime_s);
}

// Central difference of e_d along a path with acceleration, squint and Doppler.
TEST(ConeTimeTest, TheRateIsTheDerivativeAlongACurvedPath) {
  const FlightPath path({{0.0, {0.0, 0.0, 9137.0}, {171.0, 4.0, -1.0}},
                         {20.0, {3460.0, 190.0, 9101.0}, {174.0, 13.0, 2.5}}});
  Cone doppler;
  doppler.kind = Cone::Kind::kDoppler;
  doppler.closing_mps = 17.3;
  for (const Cone& cone : {Cone{.squint_rad = 0.21}, doppler}) {
    const double t_s = 7.9, h_s = 1e-3;
    const double later_m = EvaluateCone(*path.At(t_s + h_s), kPoint_m, cone).doppler_error_m;
    const double earlier_m = EvaluateCone(*path.At(t_s - h_s), kPoint_m, cone).doppler_error_m;
    // Truncation h^2/6 d3e/dt3 < 1e-9, rounding 1e-12 m / 1e-3 s.
    EXPECT_NEAR(EvaluateCone(*path.At(t_s), kPoint_m, cone).rate_mps,
                (later_m - earlier_m) / (2.0 * h_s),
                1e-6);
  }
}

TEST(ConeTimeTest, FindsNothingOutsideTheSpanAskedFor) {
  const FlightPath path = Straight();
  const Cone broadside;
  const double expected_s = ClosedForm_s(0.0);
  EXPECT_TRUE(FindConeTime(path, kPoint_m, broadside, -3.0, expected_s + 0.01).has_value());
  EXPECT_FALSE(FindConeTime(path, kPoint_m, broadside, -3.0, expected_s - 0.01).has_value());
  EXPECT_FALSE(FindConeTime(path, kPoint_m, broadside, expected_s + 0.01, 61.0).has_value());
  EXPECT_FALSE(FindConeTime(path, kPoint_m, broadside, -3.0, 61.5).has_value());  // not flown
}

TEST(ConeTimeTest, FindsNothingWhereTheIterationLeavesThePath) {
  const Eigen::Vector3d beyond_m(173.0 * 64.0 - 1200.0, 9000.0, 0.0);  // abeam 3 s after the end
  EXPECT_FALSE(SolveConeTime(Straight(), beyond_m, Cone{}, 60.0).has_value());
  EXPECT_FALSE(SolveConeTime(Straight(), kPoint_m, Cone{}, 61.5).has_value());
}

// A full circle about the point: e_d rises again in its other half, where Newton's method would
// walk to the wrong crossing.
TEST(ConeTimeTest, RefusesToWalkAcrossATurningPoint) {
  const double radius_m = 5000.0, rate_radps = kSpeed_mps / radius_m;
  std::vector<StateVector> states;
  for (int k = 0; k <= 180; ++k) {
    const double a = k * (kRadPerDeg * 2.0);
    states.push_back({a / rate_radps,
                      {radius_m * std::cos(a), radius_m * std::sin(a), 0.0},
                      {-kSpeed_mps * std::sin(a), kSpeed_mps * std::cos(a), 0.0}});
  }
  const FlightPath circle(states);
  const Eigen::Vector3d inside_m(-2113.0, 0.0, -3000.0);  // nearest to the flight at 180 degrees
  // e_d = u.(p - s) = 2113 sin(a): it rises to a quarter circle and falls from there, crosses
  // zero at half a circle and falls on to three quarters.
  const double half_s = std::numbers::pi / rate_radps;
  const auto solved_s = SolveConeTime(circle, inside_m, Cone{}, 0.8 * half_s);
  ASSERT_TRUE(solved_s.has_value());
  // Hermite interpolation of the circle, 2 degrees a piece: 5000 m (0.035)^4/384 = 2e-5 m.
  EXPECT_NEAR(*solved_s, half_s, 1e-6);
  EXPECT_FALSE(SolveConeTime(circle, inside_m, Cone{}, 0.4 * half_s).has_value());  // rising
  EXPECT_FALSE(SolveConeTime(circle, inside_m, Cone{}, 1.6 * half_s).has_value());
  const auto found_s = FindConeTime(circle, inside_m, Cone{}, 0.1 * half_s, 1.9 * half_s);
  ASSERT_TRUE(found_s.has_value());
  EXPECT_NEAR(*found_s, half_s, 1e-6);
}

}  // namespace
}  // namespace sarblock
