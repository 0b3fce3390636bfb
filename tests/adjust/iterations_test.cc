// SPDX-License-Identifier: Apache-2.0
// Blocks far from their solution: an adjustment goes on while its steps shrink, says what to raise
// where it was ended, and accepts no wrong place.
#include "sarblock/adjust/adjust.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"
#include "sarblock/model/result.h"
#include "sarblock/simulate/scene.h"

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

struct StartedBlock {
  StartedBlock(const std::string& name, const std::vector<std::string>& overrides) {
    const auto file = std::filesystem::path(SARBLOCK_DATASETS) / "scenes" / (name + ".toml");
    const Scene scene = files::ReadScene(file, overrides);
    simulated = Simulate(scene);
    std::vector<std::string> ids;
    for (const Pass& pass : simulated.block.passes) ids.push_back(pass.id);
    options = files::ReadAdjustTable(scene.adjust_toml, name, ids);
  }
  SimulatedBlock simulated;
  AdjustOptions options;
};

/// Points of an accepted result that are off by more than ten standard deviations.
std::size_t WrongPoints(const StartedBlock& started, const AdjustResult& result) {
  const Block& block = started.simulated.block;
  std::size_t wrong = 0;
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (!IsSolved(result.points.status[point])) continue;
    const Eigen::Vector3d& truth_m = started.simulated.truth.points_m[point];
    const Eigen::Vector3d error_m =
        block.frame.EnuFromFrame(truth_m) * (result.points.position_m[point] - truth_m);
    const Eigen::Matrix3d c = MatrixOf(result.points.covariance_m2[point]);
    wrong += error_m.dot(c.ldlt().solve(error_m)) > 100.0 ? 1U : 0U;
  }
  return wrong;
}

// Of five blocks each none came to an end within 50 iterations once.
TEST(IterationsTest, MoonAndVenusWithoutControlConverge) {
  for (const char* name : {"moon-alse", "venus-magellan"}) {
    for (const char* seed : {"seed=1", "seed=2", "seed=3"}) {
      const StartedBlock started(name, {"control.count=0", "points.count=150", seed});
      const AdjustResult result = Adjust(started.simulated.block, started.options);
      EXPECT_EQ(result.status, AdjustStatus::kConverged) << name << ", " << seed;
      EXPECT_EQ(WrongPoints(started, result), 0U) << name << ", " << seed;
    }
  }
}

TEST(IterationsTest, ALimitThatEndsThemIsNamed) {
  StartedBlock started("moon-alse", {"points.count=60"});
  started.options.max_iterations = 1;
  const AdjustResult result = Adjust(started.simulated.block, started.options);
  EXPECT_EQ(result.status, AdjustStatus::kNotConverged);
  EXPECT_FALSE(result.usable());
  EXPECT_THAT(result.assessment.reasons,
              testing::Contains(testing::HasSubstr("max_iterations = 1")));
}

TEST(IterationsTest, StartsTenKilometresOffEndAtTheTruth) {
  for (const char* seed : {"seed=1", "seed=2", "seed=3"}) {
    StartedBlock started("leberl-aircraft", {"points.count=60", seed});
    Block& block = started.simulated.block;
    for (std::size_t point = 0; point < block.points.size(); ++point) {
      if (block.points.role[point] != PointRole::kTie) continue;
      const auto k = static_cast<double>(point);
      block.points.given_m[point] =
          started.simulated.truth.points_m[point] +
          1e4 * Eigen::Vector3d(std::sin(k), std::cos(k), 0.3).normalized();
    }
    const AdjustResult result = Adjust(block, started.options);
    EXPECT_TRUE(result.usable()) << seed;
    EXPECT_EQ(WrongPoints(started, result), 0U) << seed;
  }
}

}  // namespace
}  // namespace sarblock
