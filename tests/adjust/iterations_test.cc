// SPDX-License-Identifier: Apache-2.0
// Blocks far from their solution: an adjustment goes on while its steps shrink, says what to raise
// where it was ended, and accepts no wrong place.
#include "sarblock/adjust/adjust.h"

#include <cmath>

#include "support/scene_blocks.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// Points of an accepted result that are off by more than ten standard deviations.
std::size_t WrongPoints(const test::SceneBlock& started, const AdjustResult& result) {
  std::size_t wrong = 0;
  for (std::size_t point = 0; point < started.block.points.size(); ++point) {
    if (!IsSolved(result.points.status[point])) continue;
    const double off = test::DistanceInSigmas(started.block.frame,
                                              result.points.position_m[point],
                                              started.truth.points_m[point],
                                              result.points.covariance_m2[point]);
    wrong += off <= 10.0 ? 0U : 1U;
  }
  return wrong;
}

// Fifty iterations were once too few for any of five blocks of each.
TEST(IterationsTest, MoonAndVenusWithoutControlConverge) {
  for (const char* name : {"moon-alse", "venus-magellan"}) {
    for (const char* seed : {"seed=1", "seed=2", "seed=3"}) {
      const test::SceneBlock started =
          test::SimulatedSceneBlock("scenes", name, {"control.count=0", "points.count=150", seed});
      const AdjustResult result = Adjust(started.block, started.options);
      EXPECT_EQ(result.status, AdjustStatus::kConverged) << name << ", " << seed;
      EXPECT_EQ(WrongPoints(started, result), 0U) << name << ", " << seed;
    }
  }
}

TEST(IterationsTest, ALimitThatEndsThemIsNamed) {
  test::SceneBlock started = test::SimulatedSceneBlock("scenes", "moon-alse", {"points.count=60"});
  started.options.max_iterations = 1;
  const AdjustResult result = Adjust(started.block, started.options);
  EXPECT_EQ(result.status, AdjustStatus::kNotConverged);
  EXPECT_FALSE(result.usable());
  EXPECT_THAT(result.assessment.reasons,
              testing::Contains(testing::HasSubstr("max_iterations = 1")));
}

TEST(IterationsTest, StartsTenKilometresOffEndAtTheTruth) {
  for (const char* seed : {"seed=1", "seed=2", "seed=3"}) {
    test::SceneBlock started =
        test::SimulatedSceneBlock("scenes", "leberl-aircraft", {"points.count=60", seed});
    Block& block = started.block;
    for (std::size_t point = 0; point < block.points.size(); ++point) {
      if (block.points.role[point] != PointRole::kTie) continue;
      const auto k = static_cast<double>(point);
      block.points.given_m[point] =
          started.truth.points_m[point] +
          1e4 * Eigen::Vector3d(std::sin(k), std::cos(k), 0.3).normalized();
    }
    const AdjustResult result = Adjust(block, started.options);
    EXPECT_TRUE(result.usable()) << seed;
    EXPECT_EQ(WrongPoints(started, result), 0U) << seed;
  }
}

}  // namespace
}  // namespace sarblock
