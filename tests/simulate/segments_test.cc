// SPDX-License-Identifier: Apache-2.0
// Lines cut into segments, and which of many passes show a point.
#include "sarblock/geometry/look_equations.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <string>
#include <vector>

#include "simulate/small_scene.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// Two lines of three segments of 9 km that overlap by 1.7 km.
Scene SegmentedScene() {
  Scene scene = test::SmallScene();
  scene.flights[0].length_m = 9000.0;
  scene.flights[0].segments = 3;
  scene.flights[0].segment_spacing_m = 7300.0;
  return scene;
}

TEST(SegmentsTest, FollowOneAnotherAlongTheLine) {  // hand values: start (-500, 300), heading east
  const SimulatedBlock simulated = Simulate(SegmentedScene());
  const std::vector<Pass>& passes = simulated.block.passes;
  ASSERT_EQ(passes.size(), 6u);
  const std::vector<std::string> ids = {"A1-1", "A1-2", "A1-3", "A2-1", "A2-2", "A2-3"};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(passes[i].id, ids[i]);
    EXPECT_NEAR(passes[i].end_s - passes[i].start_s, 9000.0 / 173.0, 1e-9);
    const Eigen::Vector3d start_m = passes[i].path.At(passes[i].start_s)->position_m;
    const Eigen::Vector3d expected_m(
        -500.0 + 7300.0 * static_cast<double>(i % 3), i < 3 ? 300.0 : 7600.0, 9100.0);
    EXPECT_LT((start_m - expected_m).norm(), 1e-8);  // rounding of 1e4 m and of times of 1e2 s
  }
}

TEST(SegmentsTest, ASingleLineIsNumberedBySegmentsAlone) {
  Scene scene = SegmentedScene();
  scene.flights[0].count = 1;
  EXPECT_EQ(PassId(scene.flights[0], 0, 2), "A-3");
}

TEST(SegmentsTest, NeedASpacingAndAreForStripsOnly) {
  Scene scene = SegmentedScene();
  scene.flights[0].segment_spacing_m = kNotGiven;
  ASSERT_TRUE(FindProblem(scene).has_value());
  EXPECT_EQ(FindProblem(scene)->field, "flight.0.segment_spacing_m");
  scene.flights[0].segments = 0;
  ASSERT_TRUE(FindProblem(scene).has_value());
  EXPECT_EQ(FindProblem(scene)->field, "flight.0.segments");
}

// Second route: every pass is asked about every point. 16 lines per side, so that no point is near
// all of them.
TEST(VisibilityTest, FindsEveryStripThatShowsAPoint) {
  Scene scene = SegmentedScene();
  scene.flights[0].count = 16;
  scene.flights.push_back(scene.flights[0]);
  scene.flights[1].id = "B";
  scene.flights[1].side = LookSide::kRight;
  scene.flights[1].squint_rad = 0.17;
  scene.flights[1].start_m.y() += 31000.0;
  scene.points.count = 300;
  scene.points.min_looks = 0;
  scene.points.north_m = {5100.0, 140000.0};
  const SimulatedBlock simulated = Simulate(scene);
  const Block& block = simulated.block;
  ASSERT_EQ(block.passes.size(), 96u);
  std::size_t looks = 0;
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    const Eigen::Vector3d& p_m = simulated.truth.points_m[point];
    std::vector<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < 96; ++i) {
      const Pass& pass = block.passes[i];
      const auto time_s = FindConeTime(
          pass.path, p_m, Cone{.squint_rad = i < 48 ? 0.0 : 0.17}, pass.start_s, pass.end_s);
      if (!time_s) continue;
      // Flight due east: across is y, to the left.
      const double across_m = (p_m - pass.path.At(*time_s)->position_m).y() * (i < 48 ? 1.0 : -1.0);
      if (across_m >= 5200.0 && across_m <= 26000.0) expected.push_back(i);
    }
    const auto begin = block.looks.pass.begin();
    const std::vector<std::uint32_t> listed(
        begin + static_cast<std::ptrdiff_t>(block.looks.offsets[point]),
        begin + static_cast<std::ptrdiff_t>(block.looks.offsets[point + 1]));
    EXPECT_EQ(listed, expected) << block.points.ids[point];
    looks += expected.size();
  }
  EXPECT_GT(looks, 1000u);
}

}  // namespace
}  // namespace sarblock
