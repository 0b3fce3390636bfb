// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/simplifications.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/geometry/intersection.h"

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

AdjustResult IntersectAll(const Block& block) {
  AdjustOptions options;
  options.covariance = CovarianceLevel::kIntersection;
  return IntersectBlock(block, options);
}

/// A look with the antenna on the straight line between two states and the velocity interpolated
/// linearly, as it is defined.
Sight StraightSight(const Block& block, std::size_t look) {
  const Pass& pass = block.passes[block.looks.pass[look]];
  const double time_s = block.looks.time_s[look];
  const std::vector<StateVector>& states = pass.path.states();
  std::size_t k = 0;
  while (k + 2 < states.size() && states[k + 1].time_s <= time_s) ++k;
  const double part = (time_s - states[k].time_s) / (states[k + 1].time_s - states[k].time_s);
  const LookSigma sigma = block.SigmaOf(look);
  Sight sight;
  sight.antenna_m = (1.0 - part) * states[k].position_m + part * states[k + 1].position_m;
  sight.velocity_mps = (1.0 - part) * states[k].velocity_mps + part * states[k + 1].velocity_mps;
  sight.acceleration_mps2 = pass.path.At(time_s)->acceleration_mps2;
  sight.range_m = block.looks.range_m[look];
  sight.side = static_cast<int>(pass.side);
  sight.range_sigma_m = sigma.range_m;
  sight.azimuth_sigma = sigma.azimuth;
  sight.azimuth_in_seconds = sigma.azimuth_unit == AzimuthUnit::kSeconds;
  return sight;
}

// Second route: the points are intersected again from antennas that are interpolated linearly. The
// bound holds for every point and direction, and it is not idle.
TEST(SimplificationsTest, LinearVelocityMovesNoPointBeyondItsBound) {
  const test::KnownBlock known = test::MakeBlock(test::OrbitPlan());
  const Block& block = known.block;
  const AdjustResult exact = IntersectAll(block);
  const SimplificationBound bound =
      Find(BoundSimplifications(block, exact, 0.01), "linear-velocity");
  double largest = 0.0;
  for (std::size_t i = 0; i < block.points.size(); ++i) {
    ASSERT_TRUE(IsSolved(exact.points.status[i]));
    std::vector<Sight> sights;
    for (std::size_t k = block.looks.offsets[i]; k < block.looks.offsets[i + 1]; ++k) {
      sights.push_back(StraightSight(block, k));
    }
    const Eigen::Vector3d shift_m =
        block.frame.EnuFromFrame(exact.points.position_m[i]) *
        (Intersect(sights, block.frame).position_m - exact.points.position_m[i]);
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
  const AdjustResult result = IntersectAll(known.block);
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
  const auto bounds = BoundSimplifications(known.block, IntersectAll(known.block), 0.01);
  for (const char* name : {"flat-frame", "fixed-track-axes", "uncoupled-squint"}) {
    EXPECT_EQ(Find(bounds, name).fraction_1, 0.0) << name;
    EXPECT_TRUE(Find(bounds, name).allowed) << name;
  }
  const test::KnownBlock squinted = test::MakeBlock(test::AircraftPlan(20.0));
  EXPECT_GT(Find(BoundSimplifications(squinted.block, IntersectAll(squinted.block), 0.01),
                 "uncoupled-squint")
                .fraction_1,
            0.01);
}

}  // namespace
}  // namespace sarblock
