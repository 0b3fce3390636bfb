// SPDX-License-Identifier: Apache-2.0
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "simulate/small_scene.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Layout = SceneControl::Layout;

/// True plan positions of the control points, in file order.
std::vector<Eigen::Vector2d> ControlOf(Layout layout,
                                       std::size_t count,
                                       double inset,
                                       const std::array<double, 2>& east_m = {kNotGiven,
                                                                              kNotGiven}) {
  Scene scene = test::SmallScene();  // area 19000 m x 11800 m from (700, 13100)
  scene.control.east_m = east_m;
  scene.control.layout = layout;
  scene.control.count = count;
  scene.control.sigma_m = {0.3, 0.3, 0.4};
  scene.control.inset = inset;
  const SimulatedBlock simulated = Simulate(scene);
  std::vector<Eigen::Vector2d> control_m;
  for (std::size_t i = 0; i < simulated.block.points.size(); ++i) {
    if (simulated.block.points.role[i] != PointRole::kControl) continue;
    control_m.push_back(simulated.truth.points_m[i].head<2>());
  }
  return control_m;
}

void ExpectAt(const std::vector<Eigen::Vector2d>& control_m,
              const std::vector<Eigen::Vector2d>& expected_m) {
  ASSERT_EQ(control_m.size(), expected_m.size());
  for (std::size_t i = 0; i < expected_m.size(); ++i) {  // rounding of numbers below 1e5 m
    EXPECT_LT((control_m[i] - expected_m[i]).norm(), 1e-9) << i << ": " << control_m[i].transpose();
  }
}

TEST(PlacePointsTest, PutsControlIntoTheCornersDiagonalFirst) {  // hand values
  ExpectAt(ControlOf(Layout::kCorners, 3, 0.1), {{2600, 14280}, {17800, 23720}, {17800, 14280}});
}

TEST(PlacePointsTest, FillsAnAreaOfItsOwnWithControl) {  // hand values: 3000 m wide from 1700
  ExpectAt(ControlOf(Layout::kCorners, 2, 0.1, {1700.0, 4700.0}), {{2000, 14280}, {4400, 23720}});
}

TEST(PlacePointsTest, WalksThePerimeterInEqualSteps) {
  // Hand values: inset 0 makes the way 2 (19000 + 11800) = 61600 m, a step of 15400 m.
  ExpectAt(ControlOf(Layout::kPerimeter, 4, 0.0),
           {{700, 13100}, {16100, 13100}, {19700, 24900}, {4300, 24900}});
}

TEST(PlacePointsTest, FillsAGridRowByRow) {  // hand values: 19000/11800 is 3 columns, 2 rows of 6
  ExpectAt(
      ControlOf(Layout::kGrid, 6, 0.0),
      {{700, 13100}, {10200, 13100}, {19700, 13100}, {700, 24900}, {10200, 24900}, {19700, 24900}});
}

// Hand values: sqrt(10 19000/11800) is 4 columns, 3 rows; of 10 points the first row has 4. Of 11
// both outer rows have 4.
TEST(PlacePointsTest, FillsAGridToItsCornersWhateverTheCount) {
  ExpectAt(ControlOf(Layout::kGrid, 10, 0.0),
           {{700, 13100},
            {700 + 19000.0 / 3, 13100},
            {700 + 38000.0 / 3, 13100},
            {19700, 13100},
            {700, 19000},
            {10200, 19000},
            {19700, 19000},
            {700, 24900},
            {10200, 24900},
            {19700, 24900}});
  const auto eleven_m = ControlOf(Layout::kGrid, 11, 0.0);
  const std::vector<double> north_m = {
      13100, 13100, 13100, 13100, 19000, 19000, 19000, 24900, 24900, 24900, 24900};
  ASSERT_EQ(eleven_m.size(), north_m.size());
  for (std::size_t i = 0; i < north_m.size(); ++i) EXPECT_NEAR(eleven_m[i].y(), north_m[i], 1e-9);
}

// Invariance: the corners are taken by every count that has two columns and rows.
TEST(PlacePointsTest, KeepsTheCornersOfAGrid) {
  for (std::size_t count = 5; count <= 40; ++count) {
    const auto control_m = ControlOf(Layout::kGrid, count, 0.0);
    ASSERT_EQ(control_m.size(), count);
    for (const Eigen::Vector2d& corner_m : {Eigen::Vector2d(700, 13100),
                                            Eigen::Vector2d(19700, 13100),
                                            Eigen::Vector2d(700, 24900),
                                            Eigen::Vector2d(19700, 24900)}) {
      double nearest_m = 1e9;
      for (const Eigen::Vector2d& p_m : control_m) {
        nearest_m = std::min(nearest_m, (p_m - corner_m).norm());
      }
      EXPECT_LT(nearest_m, 1e-9) << count << ": " << corner_m.transpose();
    }
  }
}

TEST(PlacePointsTest, LaysAChainAlongTheLongerMiddleLine) {
  ExpectAt(ControlOf(Layout::kChain, 3, 0.0), {{700, 19000}, {10200, 19000}, {19700, 19000}});
}

TEST(PlacePointsTest, ScattersRandomControlInsideTheInsetArea) {
  const auto control_m = ControlOf(Layout::kRandom, 50, 0.2);
  ASSERT_EQ(control_m.size(), 50u);
  for (const Eigen::Vector2d& p_m : control_m) {
    EXPECT_TRUE(p_m.x() > 4500 && p_m.x() < 15900 && p_m.y() > 15460 && p_m.y() < 22540) << p_m;
  }
  EXPECT_NE(control_m[0], control_m[1]);
}

TEST(PlacePointsTest, NumbersControlCheckAndTiePointsInThisOrder) {
  Scene scene = test::SmallScene();
  scene.control.layout = scene.check.layout = Layout::kRandom;
  scene.control.count = scene.check.count = 2;
  scene.control.sigma_m = scene.check.sigma_m = {0.3, 0.3, 0.4};
  scene.points.count = 2;
  const SimulatedBlock simulated = Simulate(scene);
  const Points& points = simulated.block.points;
  ASSERT_EQ(points.size(), 6u);
  const std::vector<std::string> ids = {"C1", "C2", "K1", "K2", "T1", "T2"};
  for (std::size_t i = 0; i < ids.size(); ++i) EXPECT_EQ(points.ids[i], ids[i]);
  ASSERT_EQ(points.known.size(), 4u);
  EXPECT_EQ(points.known[3].point, 3u);
  EXPECT_EQ(points.role[3], PointRole::kCheck);
  EXPECT_DOUBLE_EQ(points.known[0].covariance_enu_m2(2, 2), 0.4 * 0.4);
  EXPECT_TRUE(std::isnan(points.given_m[4].x()));
}

TEST(PlacePointsTest, LeavesOutTiePointsSeenOnceButKeepsControl) {
  Scene scene = test::SmallScene();
  scene.flights[0].count = 1;
  scene.control.layout = Layout::kCorners;
  scene.control.sigma_m = {1, 1, 1};
  EXPECT_EQ(Simulate(scene).block.points.size(), 4u);
  scene.points.min_looks = 1;
  EXPECT_EQ(Simulate(scene).block.points.size(), 64u);
}

}  // namespace
}  // namespace sarblock
