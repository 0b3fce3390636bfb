// SPDX-License-Identifier: Apache-2.0
// States that are no one's path: merged solutions, which follow each other closely or alternate.
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "geometry/recorded_states.h"
#include "geometry/test_flights.h"
#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::OnCircle;

std::vector<StateVector> StatesOnCircle(double spacing_s, int count) {
  std::vector<StateVector> states;
  for (int k = 0; k < count; ++k) states.push_back(OnCircle(spacing_s * k));
  return states;
}

// Hand arithmetic: 12 eps 7.4e6 m is the square of 0.14 ms; a thousandth of 10 s is 10 ms.
TEST(CloseStatesTest, AStateAgainShortlyAfterIsFound) {
  for (const double apart_s : {1e-6, 1e-4, 9e-3}) {
    auto states = StatesOnCircle(10.0, 12);
    states.insert(states.begin() + 7, OnCircle(60.0 + apart_s));
    const auto close = FindCloseStates(states);
    ASSERT_TRUE(close) << apart_s;
    EXPECT_EQ(close->second, 7U);
    EXPECT_NEAR(close->apart_s, apart_s, 1e-12);
    EXPECT_EQ(close->usual_s, 10.0);
  }
}

TEST(CloseStatesTest, AllStatesTwiceAreFoundTheFirstPairNamed) {
  std::vector<StateVector> states;
  for (int k = 0; k < 12; ++k) {
    states.push_back(OnCircle(10.0 * k));
    states.push_back(OnCircle(10.0 * k + 5e-3));
  }
  const auto close = FindCloseStates(states);
  ASSERT_TRUE(close);
  EXPECT_EQ(close->second, 1U);
}

TEST(CloseStatesTest, RecordingsOfAnyRateWithPausesAreNotClose) {
  for (const double spacing_s : {1e-3, 0.01, 1.0, 10.0, 300.0}) {
    auto states = StatesOnCircle(spacing_s, 200);
    EXPECT_FALSE(FindCloseStates(states)) << spacing_s;
    for (std::size_t k = 100; k < states.size(); ++k)
      states[k] = OnCircle(states[k].time_s + 900.0);
    EXPECT_FALSE(FindCloseStates(states)) << spacing_s;
  }
  EXPECT_FALSE(FindCloseStates(StatesOnCircle(1.0, 2)));
  EXPECT_FALSE(FindCloseStates({}));
}

// Two solutions, one displaced by a known vector, their states in turn, at even and uneven times.
TEST(AlternationTest, TwoSolutionsInterleavedAreFoundWithTheirDistance) {
  const Eigen::Vector3d apart_m(0.5, -0.62, 0.38), apart_mps(0.003, 0.0, -0.004);
  for (const double spacing_s : {1.0, 10.0, 60.0}) {
    for (const double late : {0.0, 0.2}) {  // of an interval, of every second state
      std::vector<StateVector> states;
      for (int k = 0; k < 30; ++k) {
        states.push_back(OnCircle(spacing_s * (k + (k % 2 == 1 ? late : 0.0))));
        if (k % 2 == 0) continue;
        states.back().position_m += apart_m;
        states.back().velocity_mps += apart_mps;
      }
      const auto found = FindAlternation(states);
      ASSERT_TRUE(found) << spacing_s;
      EXPECT_NEAR(found->position_m, apart_m.norm(), 1e-3) << spacing_s;
      EXPECT_NEAR(found->velocity_mps, apart_mps.norm(), 1e-5) << spacing_s;
    }
  }
}

// Seeded statistics: 2,000 draws of noise, and flights without any.
TEST(AlternationTest, NoiseAndFlightsAreNoAlternation) {
  for (const double spacing_s : {0.01, 1.0, 10.0, 60.0, 300.0}) {
    for (const int count : {8, 20, 31, 400}) {
      EXPECT_FALSE(FindAlternation(StatesOnCircle(spacing_s, count))) << spacing_s << " " << count;
    }
  }
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    RandomStream random(48, seed);
    auto states = StatesOnCircle(1.0, 20 + static_cast<int>(seed % 40));
    for (StateVector& state : states) {
      for (Eigen::Index i = 0; i < 3; ++i) {
        state.position_m[i] += 0.05 * random.Normal();
        state.velocity_mps[i] += 0.01 * random.Normal();
      }
    }
    EXPECT_FALSE(FindAlternation(states)) << seed;
  }
}

/// An orbit about the Earth with its oblateness, J2 = 1.0826e-3, integrated by Runge and Kutta's
/// fourth-order rule in steps of a second, in axes that do not turn.
std::vector<StateVector> IntegratedOrbit(double spacing_s, int count) {
  using Eigen::Vector3d;
  constexpr double kGm = 3.986004418e14, kJ2 = 1.0826e-3, kA_m = 6378137.0;
  const auto attraction = [](const Vector3d& p) -> Vector3d {
    const double r = p.norm(), z = p.z() / r, j = 1.5 * kJ2 * kA_m * kA_m / (r * r);
    return -kGm / (r * r * r) *
           Vector3d(p.x() * (1.0 + j * (1.0 - 5.0 * z * z)),
                    p.y() * (1.0 + j * (1.0 - 5.0 * z * z)),
                    p.z() * (1.0 + j * (3.0 - 5.0 * z * z)));
  };
  Vector3d p(5.1e6, 2.0e6, 4.5e6), v(-4100.0, -2900.0, 5600.0);
  std::vector<StateVector> states;
  double now_s = 0.0;
  for (int k = 0; k < count; ++k) {
    for (; now_s < spacing_s * k; now_s += 1.0) {
      const Vector3d a1 = attraction(p), v2 = v + 0.5 * a1, a2 = attraction(p + 0.5 * v);
      const Vector3d v3 = v + 0.5 * a2, a3 = attraction(p + 0.5 * v2), v4 = v + a3;
      const Vector3d a4 = attraction(p + v3);
      p += (v + 2.0 * v2 + 2.0 * v3 + v4) / 6.0;
      v += (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0;
    }
    states.push_back({now_s, p, v});
  }
  return states;
}

/// The same as the turning Earth sees it.
std::vector<StateVector> BodyFixed(std::vector<StateVector> states, double rate) {
  for (StateVector& state : states) {
    const Eigen::AngleAxisd back(-rate * (state.time_s - 8.9), Eigen::Vector3d::UnitZ());
    state.position_m = back * state.position_m;
    state.velocity_mps =
        back * state.velocity_mps - rate * Eigen::Vector3d::UnitZ().cross(state.position_m);
  }
  return states;
}

/// Coriolis and centrifugal acceleration on average, by hand: 2 w x v by the places at both ends,
/// w x (w x r) by the mean place.
double ApparentAcceleration_mps2(std::span<const StateVector> states, double rate) {
  const Eigen::Vector3d w = rate * Eigen::Vector3d::UnitZ();
  const StateVector &from = states.front(), &to = states.back();
  Eigen::Vector3d mean_m = -0.5 * (from.position_m + to.position_m);
  for (const StateVector& state : states) mean_m += state.position_m;
  mean_m /= static_cast<double>(states.size() - 1);
  const Eigen::Vector3d moved_m = to.position_m - from.position_m;
  return (2.0 / (to.time_s - from.time_s) * w.cross(moved_m) + w.cross(w.cross(mean_m))).norm();
}

TEST(InertialMotionTest, IsThatOfAnOrbitWhoseAxesDoNotTurn) {
  const Body& earth = *FindBody("WGS84");
  for (const auto& [spacing_s, count] : {std::pair{1.0, 20}, {10.0, 17}, {60.0, 4}, {120.0, 3}}) {
    const std::vector<StateVector> orbit = IntegratedOrbit(spacing_s, count);
    const auto motion = FindInertialMotion(orbit, earth);
    ASSERT_TRUE(motion) << spacing_s;
    // Their gravity is explained up to J2, 0.013 m/s^2: what is left in turning axes is that of the
    // turning, of the half where it is smaller. Trapezoids leave 2e-3 m/s^2 of it at most.
    const std::size_t half = orbit.size() / 2;
    const std::span<const StateVector> all(orbit);
    const double expected_mps2 =
        std::min(ApparentAcceleration_mps2(all.first(half + 1), earth.rotation),
                 ApparentAcceleration_mps2(all.subspan(half), earth.rotation));
    EXPECT_NEAR(motion->in_turning_axes_mps2, expected_mps2, motion->in_fixed_axes_mps2 + 2e-3)
        << spacing_s;
    EXPECT_LT(motion->in_fixed_axes_mps2, spacing_s < 100.0 ? 0.025 : 0.06) << spacing_s;
    EXPECT_FALSE(FindInertialMotion(BodyFixed(orbit, earth.rotation), earth)) << spacing_s;
  }
}

// Noise up to what hides the turning of the axes takes no body-fixed flight for an inertial one:
// the chance of both halves is below 1e-7 (the noise would have to be the Coriolis acceleration
// itself, within a tenth).
TEST(InertialMotionTest, NoiseOfVelocitiesMakesNone) {
  const Body& earth = *FindBody("WGS84");
  const std::vector<StateVector> exact = BodyFixed(IntegratedOrbit(1.0, 20), earth.rotation);
  for (const double noise_mps : {0.1, 1.0, 3.0, 10.0}) {
    for (std::uint64_t seed = 1; seed <= 500; ++seed) {
      RandomStream random(seed, 0);
      std::vector<StateVector> states = exact;
      for (StateVector& state : states) {
        for (int i = 0; i < 3; ++i) state.velocity_mps[i] += noise_mps * random.Normal();
      }
      EXPECT_FALSE(FindInertialMotion(states, earth)) << noise_mps << " " << seed;
    }
  }
}

TEST(WrapTest, IsAWholeDayOrWeekAwayOrNone) {
  const FlightPath path(StatesOnCircle(10.0, 12));  // 0 to 110 s
  EXPECT_EQ(WrapOf_s(path, 50.0), 0.0);
  EXPECT_EQ(WrapOf_s(path, 50.0 - 86400.0), 86400.0);
  EXPECT_EQ(WrapOf_s(path, 50.0 + 604800.0), -604800.0);
  EXPECT_EQ(WrapOf_s(path, 200.0), 0.0);
}

TEST(InertialMotionTest, IsNoneOfAnAircraftOrOfTwoStates) {
  const Body& earth = *FindBody("WGS84");
  std::vector<StateVector> flight;
  for (int k = 0; k < 50; ++k) {
    const double angle = 2e-6 * k;  // 200 m/s around the Earth at 10 km
    flight.push_back({0.0638 * k,
                      6388137.0 * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0),
                      200.0 * Eigen::Vector3d(-std::sin(angle), std::cos(angle), 0.0)});
  }
  EXPECT_FALSE(FindInertialMotion(flight, earth));
  EXPECT_FALSE(FindInertialMotion(IntegratedOrbit(10.0, 2), earth));
}

}  // namespace
}  // namespace sarblock
