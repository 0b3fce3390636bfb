// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/simplifications.h"

#include "sarblock/adjust/adjust.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/small_blocks.h"
#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

const SimplificationBound& Find(const std::vector<SimplificationBound>& bounds,
                                const std::string& name) {
  return *std::find_if(
      bounds.begin(), bounds.end(), [&](const SimplificationBound& b) { return b.name == name; });
}

AdjustResult Intersect(const Block& block) {
  AdjustOptions options;
  options.covariance = CovarianceLevel::kIntersection;
  return IntersectBlock(block, options);
}

/// A path of straight pieces between the states: so many states on them that the cubics between
/// them are the straight pieces.
FlightPath Straightened(const FlightPath& path) {
  std::vector<StateVector> states;
  for (std::size_t i = 0; i + 1 < path.states().size(); ++i) {
    const StateVector& a = path.states()[i];
    const StateVector& b = path.states()[i + 1];
    constexpr int kPieces = 64;
    for (int k = 0; k < kPieces; ++k) {
      const double part = static_cast<double>(k) / kPieces;
      states.push_back({a.time_s + part * (b.time_s - a.time_s),
                        a.position_m + part * (b.position_m - a.position_m),
                        a.velocity_mps + part * (b.velocity_mps - a.velocity_mps)});
    }
  }
  states.push_back(path.states().back());
  return FlightPath(states);
}

// Second route: the points are intersected again on paths that are straight between their states.
// The bound holds for every point and direction, and it is not idle.
TEST(SimplificationsTest, LinearVelocityMovesNoPointBeyondItsBound) {
  const test::KnownBlock known = test::MakeBlock(test::OrbitPlan());
  const AdjustResult exact = Intersect(known.block);
  const SimplificationBound bound =
      Find(BoundSimplifications(known.block, exact, 0.01), "linear-velocity");
  Block straight = known.block;
  for (Pass& pass : straight.passes) pass.path = Straightened(pass.path);
  const AdjustResult moved = Intersect(straight);
  double largest = 0.0;
  for (std::size_t i = 0; i < known.block.points.size(); ++i) {
    ASSERT_TRUE(IsSolved(exact.points.status[i]));
    const Eigen::Vector3d shift_m = known.block.frame.EnuFromFrame(exact.points.position_m[i]) *
                                    (moved.points.position_m[i] - exact.points.position_m[i]);
    for (int axis = 0; axis < 3; ++axis) {
      const double sigma_m =
          std::sqrt(exact.points.covariance_m2[i][static_cast<std::size_t>(axis)]);
      largest = std::max(largest, std::abs(shift_m[axis]) / sigma_m);
    }
  }
  EXPECT_LE(largest, 1.05 * bound.fraction_1);  // first order
  EXPECT_GE(largest, 0.1 * bound.fraction_1);
  EXPECT_FALSE(bound.allowed);
}

// Closed form: height of a tangent plane at the distance d is d^2 / 2r.
TEST(SimplificationsTest, TheFlatFrameIsThatOfATangentPlane) {
  const test::KnownBlock known = test::MakeBlock(test::OrbitPlan());
  const AdjustResult result = Intersect(known.block);
  const SimplificationBound bound =
      Find(BoundSimplifications(known.block, result, 0.01), "flat-frame");
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p_m : result.points.position_m) middle_m += p_m;
  middle_m /= static_cast<double>(result.points.position_m.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < result.points.position_m.size(); ++i) {
    const double d_m = (result.points.position_m[i] - middle_m).cross(middle_m.normalized()).norm();
    largest = std::max(
        largest,
        d_m * d_m / (2.0 * middle_m.norm()) / std::sqrt(result.points.covariance_m2[i][2]));
  }
  // The ellipsoid's normal and the radius differ by up to 0.2 degrees.
  EXPECT_NEAR(bound.fraction_1 / largest, 1.0, 0.02);
}

// Exact: nothing to bound where looks are not squinted, paths not corrected, the frame flat.
TEST(SimplificationsTest, WhatIsNotThereCostsNothing) {
  const test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  const auto bounds = BoundSimplifications(known.block, Intersect(known.block), 0.01);
  for (const char* name : {"flat-frame", "fixed-track-axes", "uncoupled-squint"}) {
    EXPECT_EQ(Find(bounds, name).fraction_1, 0.0) << name;
    EXPECT_TRUE(Find(bounds, name).allowed) << name;
  }
  const test::KnownBlock squinted = test::MakeBlock(test::AircraftPlan(20.0));
  EXPECT_GT(Find(BoundSimplifications(squinted.block, Intersect(squinted.block), 0.01),
                 "uncoupled-squint")
                .fraction_1,
            0.01);
}

}  // namespace
}  // namespace sarblock
