// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "geometry/sight_scene.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing_scene::FixPath;
using testing_scene::Station;
using testing_scene::View;

// Closed form: the look angles of parallel tracks subtract, whatever the squints are.
TEST(IntersectionAngleTest, IsTheDifferenceOfLookAnglesForParallelTracks) {
  const Eigen::Vector3d p(123.25, -456.5, 78.75);
  for (const double squint_rad : {0.0, 0.31, -0.87}) {
    View near, far;
    near.look_rad = 0.437;
    far.look_rad = 0.913;
    far.squint_rad = squint_rad;
    far.range_m = 14142.25;
    EXPECT_NEAR(IntersectionAngle(p, FixPath(p, near), FixPath(p, far)), 0.476, 1e-14)
        << squint_rad;
  }
}

TEST(IntersectionAngleTest, IsZeroForFlightsSquintedFromOneLine) {
  const Eigen::Vector3d p(123.25, -456.5, 78.75);
  View fore, aft;
  fore.squint_rad = 0.41;
  aft.squint_rad = -0.41;
  EXPECT_NEAR(IntersectionAngle(p, FixPath(p, fore), FixPath(p, aft)), 0.0, 1e-14);
}

// Hand value: d' = (0, 3, -4), d'' = (12, 0, -5): cos = 20/65.
TEST(IntersectionAngleTest, IsTheAngleOfTheRangeGradientsForCrossingTracks) {
  const FixedPathLook first = Station(0.0, -3e3, 4e3, 5e3, +1);
  FixedPathLook second = Station(-12e3, 0.0, 5e3, 13e3, -1);
  second.velocity_mps = {0.0, 250.0, 0.0};
  const Eigen::Vector3d p = Eigen::Vector3d::Zero();
  EXPECT_NEAR(IntersectionAngle(p, first, second), std::acos(20.0 / 65.0), 1e-15);
  EXPECT_EQ(IntersectionAngle(p, first, second), IntersectionAngle(p, second, first));
}

// Both look from opposite directions along one line: pi, the largest value there is.
TEST(IntersectionAngleTest, ReachesPi) {
  const FixedPathLook left = Station(0.0, -3e3, 4e3, 5e3, +1);
  const FixedPathLook below = Station(0.0, 6e3, -8e3, 10e3, -1);
  EXPECT_NEAR(IntersectionAngle(Eigen::Vector3d::Zero(), left, below), std::numbers::pi, 1e-15);
}

// Two routes: the largest of all pairs; above 16 looks of those with the first and the one farthest
// from it.
TEST(LargestIntersectionAngleTest, IsTheLargestOfThePairs) {
  const Eigen::Vector3d p(123.25, -456.5, 78.75);
  std::mt19937 random(417);
  std::uniform_real_distribution<double> look_rad(0.2, 1.3), squint_rad(-0.4, 0.4);
  std::vector<FixedPathLook> looks;
  const auto angle_rad = [&](std::size_t i, std::size_t k) {
    return IntersectionAngle(p, looks[i], looks[k]);
  };
  for (std::size_t count = 0; count <= 20; ++count) {
    double largest_rad = 0.0;
    std::size_t far = 0;
    for (std::size_t k = 1; k < count; ++k) {
      if (angle_rad(0, k) > angle_rad(0, far)) far = k;
    }
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < count; ++k) {
        if (count <= 16 || i == 0 || i == far) largest_rad = std::max(largest_rad, angle_rad(i, k));
      }
    }
    EXPECT_EQ(LargestIntersectionAngle(p, looks), largest_rad) << count;
    View view;
    view.look_rad = look_rad(random);
    view.squint_rad = squint_rad(random);
    looks.push_back(FixPath(p, view));
  }
}

}  // namespace
}  // namespace sarblock
