// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/geometry/path.h"

#include <cmath>

#include "geometry/smooth_path.h"
#include "geometry/test_flights.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::OnCircle;

std::vector<StateVector> Circle(int count, double spacing_s) {
  std::vector<StateVector> states;
  for (int k = 0; k < count; ++k) states.push_back(OnCircle(spacing_s * k - 31.25));
  return states;
}

struct Errors {
  double position_m = 0.0, velocity_mps = 0.0;
};
Errors LargestErrors(const FlightPath& path) {
  Errors largest;
  for (double time_s = path.start_s(); time_s < path.end_s(); time_s += 0.3137) {
    const Motion motion = *path.At(time_s);
    const StateVector truth = OnCircle(time_s);
    largest.position_m =
        std::max(largest.position_m, (motion.position_m - truth.position_m).norm());
    largest.velocity_mps =
        std::max(largest.velocity_mps, (motion.velocity_mps - truth.velocity_mps).norm());
  }
  return largest;
}

// Closed form. States 10 s apart: h^4/384 and sqrt(3) h^3/216 of s'''' = 8.99e-6 m/s^4 are 0.23 mm
// and 7.2e-5 m/s; 1 s apart 2.3e-8 m and 7.2e-8 m/s. Coordinates round at 1e-9 m, which one second
// turns into 4e-9 m/s; the divided differences multiply it by about ten.
TEST(ResampleOrbitTest, ACubicThroughItFollowsACircleToTheRounding) {
  const std::vector<StateVector> given = Circle(12, 10.0);
  const Errors before = LargestErrors(FlightPath(given));
  EXPECT_NEAR(before.position_m, 2.34e-4, 0.05e-4);
  EXPECT_NEAR(before.velocity_mps, 7.2e-5, 0.2e-5);
  for (const OrbitThrough through : {OrbitThrough::kStates, OrbitThrough::kPositions}) {
    const Errors after = LargestErrors(FlightPath(ResampleOrbit(given, 1.0, through)));
    EXPECT_LT(after.position_m, 5e-8);
    EXPECT_LT(after.velocity_mps, 1.5e-7);
  }
}

TEST(ResampleOrbitTest, GivenStatesStayAsTheyAreAndPartsAreEqual) {
  const std::vector<StateVector> given = Circle(5, 10.0);
  const std::vector<StateVector> dense = ResampleOrbit(given, 3.0, OrbitThrough::kStates);
  ASSERT_EQ(dense.size(), 17u);  // four parts of 2.5 s in four intervals
  for (std::size_t k = 0; k < given.size(); ++k) {
    EXPECT_EQ(dense[4 * k].time_s, given[k].time_s);
    EXPECT_EQ(dense[4 * k].position_m, given[k].position_m);
    EXPECT_EQ(dense[4 * k].velocity_mps, given[k].velocity_mps);
  }
  EXPECT_DOUBLE_EQ(dense[1].time_s, given[0].time_s + 2.5);
  EXPECT_EQ(ResampleOrbit(given, 10.0, OrbitThrough::kStates).size(), 5u);
  EXPECT_EQ(ResampleOrbit(Circle(2, 10.0), 1.0, OrbitThrough::kPositions).size(), 11u);
}

// By hand: velocities 7.5 mm/s off in a fixed direction leave a path through positions untouched
// and make one through states swing by 2 * 7.5 mm/s at most.
TEST(ResampleOrbitTest, ContradictingVelocitiesAreMeasuredAndCanBeLeftOut) {
  std::vector<StateVector> given = Circle(14, 10.0);
  EXPECT_LT(LargestContradiction_mps(given), 1e-6);
  for (StateVector& state : given) state.velocity_mps += Eigen::Vector3d(0.0045, 0.006, 0.0);
  EXPECT_NEAR(LargestContradiction_mps(given), 0.0075, 1e-6);
  const auto error = [&given](OrbitThrough through) {
    return LargestErrors(FlightPath(ResampleOrbit(given, 1.0, through)));
  };
  EXPECT_LT(error(OrbitThrough::kPositions).velocity_mps, 1.5e-7);
  EXPECT_GT(error(OrbitThrough::kStates).velocity_mps, 0.007);
  EXPECT_LT(error(OrbitThrough::kStates).velocity_mps, 0.015);
  EXPECT_EQ(LargestContradiction_mps(Circle(8, 10.0)), 0.0);  // too few states to tell
}

TEST(ResampleOrbitTest, RefusesWhatIsNoOrbit) {
  const auto resample = [](const std::vector<StateVector>& states, double step_s) {
    static_cast<void>(ResampleOrbit(states, step_s, OrbitThrough::kStates));
  };
  EXPECT_THROW(resample(Circle(1, 10.0), 1.0), InputError);
  EXPECT_THROW(resample(Circle(4, -10.0), 1.0), InputError);
  EXPECT_THROW(resample(Circle(4, 10.0), 0.0), InputError);
}

}  // namespace
}  // namespace sarblock
