// SPDX-License-Identifier: Apache-2.0
// Blocks that contradict themselves: paths off by kilometres, exchanged points, gross errors of
// ranges. What agrees is adjusted, what does not is left out by name, and a block in which nothing
// is wrong is adjusted as without a consensus, to the last digit.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"

#include <algorithm>
#include <string>
#include <vector>

#include "support/scene_blocks.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

struct Made : test::SceneBlock {
  Made(const std::string& name, const std::string& points)
      : test::SceneBlock(test::SimulatedSceneBlock(
            "scenes", name, {"check.count=0", "points.count=" + points})) {
    options.test_level = 0.9999;
  }

  /// Moves the given path of every pass, the priors of the constants with it.
  void DisplacePaths(const std::vector<Eigen::Vector3d>& by_m, double sigma_m) {
    for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
      std::vector<StateVector> states = block.passes[pass].path.states();
      for (StateVector& state : states) state.position_m += by_m[pass % by_m.size()];
      block.passes[pass].path = FlightPath(std::move(states));
    }
    for (CorrectionGroup& group : options.groups) {
      for (std::vector<double>& prior_m : std::get<PositionCorrection>(group.model).prior_sigma_m) {
        prior_m[0] = sigma_m;
      }
    }
  }

  /// Exchanges the looks of two points in a pass that both see.
  void Exchange(std::size_t a, std::size_t b) {
    std::swap(block.looks.time_s[a], block.looks.time_s[b]);
    std::swap(block.looks.range_m[a], block.looks.range_m[b]);
  }

  /// Looks of tie points in a pass.
  [[nodiscard]] std::vector<std::size_t> TieLooks(std::size_t pass) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < block.looks.size(); ++i) {
      if (block.looks.pass[i] == pass && block.points.role[PointOf(i)] == PointRole::kTie) {
        found.push_back(i);
      }
    }
    return found;
  }
  [[nodiscard]] std::size_t PointOf(std::size_t look) const {
    const auto& offsets = block.looks.offsets;
    const auto after = std::upper_bound(offsets.begin(), offsets.end(), look);
    return static_cast<std::size_t>(after - offsets.begin()) - 1;
  }
};

const std::vector<Eigen::Vector3d> kKilometres = {
    {2300.0, -1100.0, 240.0}, {-1700.0, 900.0, -310.0}, {400.0, 2100.0, 150.0}};

TEST(ConsensusTest, LeavesABlockInWhichNothingIsWrongAsItIs) {
  for (const char* scene : {"block-12-strips", "earth-same-side", "leberl-aircraft"}) {
    SCOPED_TRACE(scene);
    const Made made(scene, "100");
    AdjustOptions without = made.options;
    without.quality.consensus = false;
    for (const RobustLoss loss : {RobustLoss::kNone, RobustLoss::kHuber, RobustLoss::kTukey}) {
      AdjustOptions with = made.options;
      with.robust = without.robust = loss;
      const AdjustResult a = Adjust(made.block, with), b = Adjust(made.block, without);
      ASSERT_TRUE(a.usable());
      EXPECT_FALSE(a.snooping.has_value());
      EXPECT_EQ(a.iterations, b.iterations);
      for (std::size_t point = 0; point < made.block.points.size(); ++point) {
        EXPECT_EQ(a.points.position_m[point], b.points.position_m[point]);
      }
    }
  }
}

TEST(ConsensusTest, BringsExchangedPointsAndDisplacedPathsHome) {
  Made made("block-12-strips", "300");
  made.DisplacePaths(kKilometres, 2000.0);
  std::vector<std::uint8_t> touched(made.block.points.size(), 0);
  for (std::size_t pass = 0; pass < made.block.passes.size(); ++pass) {
    const std::vector<std::size_t> looks = made.TieLooks(pass);
    for (std::size_t k = 3; k + 17 < looks.size(); k += 31) {
      made.Exchange(looks[k], looks[k + 17]);
      touched[made.PointOf(looks[k])] = touched[made.PointOf(looks[k + 17])] = 1;
    }
  }
  ASSERT_GT(std::count(touched.begin(), touched.end(), 1), 20);
  const AdjustResult result = Adjust(made.block, made.options);
  EXPECT_TRUE(result.usable());
  EXPECT_TRUE(result.chi_square_passed) << result.sigma0_squared;
  ASSERT_TRUE(result.snooping.has_value());
  EXPECT_THAT(result.warnings, testing::Contains(testing::HasSubstr("solved by consensus")));
  std::size_t lost = 0;
  for (std::size_t point = 0; point < touched.size(); ++point) {
    if (!IsSolved(result.points.status[point])) {
      lost += touched[point] == 0 ? 1U : 0U;
    } else {
      // The chance that any of 300 points is beyond 6 (chi-square above 36) is 2e-5.
      EXPECT_LT(test::DistanceInSigmas(made.block.frame,
                                       result.points.position_m[point],
                                       made.truth.points_m[point],
                                       result.points.covariance_m2[point]),
                6.0)
          << made.block.points.ids[point];
    }
  }
  EXPECT_LE(lost, touched.size() / 100) << "points that nobody touched";
}

TEST(ConsensusTest, LeavesOutByNameTwoPointsOfWhichNoLookIsKnownToBeWrong) {
  Made made("leberl-aircraft", "100");
  const std::vector<std::size_t> looks = made.TieLooks(0);
  made.Exchange(looks[10], looks[60]);
  const AdjustResult result = Adjust(made.block, made.options);
  EXPECT_TRUE(result.usable());
  EXPECT_TRUE(result.chi_square_passed);
  for (const std::size_t look : {looks[10], looks[60]}) {
    const std::size_t point = made.PointOf(look);
    EXPECT_EQ(result.points.status[point], PointStatus::kApart);
    EXPECT_EQ(result.points.reason[point],
              "its looks contradict each other and none can be identified as wrong: A1, A2");
  }
  EXPECT_EQ(
      std::count(result.points.status.begin(), result.points.status.end(), PointStatus::kAdjusted),
      static_cast<std::ptrdiff_t>(made.block.points.size()) - 2);
}

TEST(ConsensusTest, IsNotMadeWhereItIsSwitchedOff) {
  Made made("leberl-aircraft", "100");
  const std::vector<std::size_t> looks = made.TieLooks(0);
  made.Exchange(looks[10], looks[60]);
  made.options.quality.consensus = false;
  const AdjustResult result = Adjust(made.block, made.options);
  EXPECT_FALSE(result.usable());
  EXPECT_FALSE(result.snooping.has_value());
}

TEST(ConsensusTest, IsNoneWhereAWholePassIsWrong) {
  Made made("block-12-strips", "200");
  for (std::size_t i = 0; i < made.block.looks.size(); ++i) {
    if (made.block.looks.pass[i] == 5) made.block.looks.range_m[i] += 400.0;
  }
  const AdjustResult result = Adjust(made.block, made.options);
  EXPECT_FALSE(result.usable());
  EXPECT_FALSE(result.snooping.has_value());
}

TEST(ConsensusTest, IsTheSameWithAnyNumberOfThreads) {
  Made made("block-12-strips", "150");
  made.DisplacePaths(kKilometres, 2000.0);
  const std::vector<std::size_t> looks = made.TieLooks(5);
  for (std::size_t k = 0; k + 8 < looks.size(); k += 16) made.Exchange(looks[k], looks[k + 8]);
  made.options.threads = 1;
  const AdjustResult one = Adjust(made.block, made.options);
  made.options.threads = 3;
  const AdjustResult three = Adjust(made.block, made.options);
  ASSERT_TRUE(one.snooping.has_value());
  for (std::size_t point = 0; point < made.block.points.size(); ++point) {
    EXPECT_EQ(one.points.status[point], three.points.status[point]);
    if (IsSolved(one.points.status[point])) {
      EXPECT_EQ(one.points.position_m[point], three.points.position_m[point]);
    }
  }
}

}  // namespace
}  // namespace sarblock
