// SPDX-License-Identifier: Apache-2.0
#include "block/point_order.h"

#include <array>
#include <cstdint>
#include <string>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Points that the passes `first_of(point)` and the one after it see, at ranges that identify the
/// look.
template <typename FirstOf>
Block BlockOf(std::size_t passes, std::uint32_t points, const FirstOf& first_of) {
  Block block;
  block.passes.resize(passes);
  for (std::uint32_t point = 0; point < points; ++point) {
    block.points.ids.Append("P" + std::to_string(point));
    block.points.role.push_back(point % 7 == 3 ? PointRole::kCheck : PointRole::kTie);
    block.points.given_m.emplace_back(point, 0.5, -1.25);
    if (point % 7 == 3) {
      KnownPosition known;
      known.point = point;
      known.covariance_enu_m2(0, 0) = point + 0.25;
      block.points.known.push_back(known);
    }
    const std::uint32_t first = first_of(point);
    for (const std::uint32_t pass : {first, first + 1}) {
      block.looks.pass.push_back(pass);
      block.looks.flags.push_back(point % 5 == 0 ? Looks::kRejected : 0);
      block.looks.time_s.push_back(point + 0.125 * pass);
      block.looks.range_m.push_back(1e5 + point);
      block.looks.azimuth_sigma.push_back(0.5 + point);
    }
    block.looks.offsets.push_back(block.looks.size());
  }
  return block;
}

/// 600 passes, each of which sees points of every thousand.
Block InNoOrder() {
  return BlockOf(601, 6000, [](std::uint32_t point) { return point * 7 % 600; });
}

TEST(OrderByPassesTest, PutsPointsOfTheSamePassesTogetherInTheirOrder) {  // hand arithmetic
  const Block block = InNoOrder();
  const PointOrder order = OrderByPasses(block);
  ASSERT_EQ(order.size(), block.points.size());
  const auto key = [&](std::uint32_t point) { return std::tuple(point * 7 % 600, point); };
  for (std::size_t place = 1; place < order.size(); ++place) {
    ASSERT_LT(key(order[place - 1]), key(order[place])) << place;
  }
}

TEST(OrderByPassesTest, OfPointsWithTheSameFirstPassTheLastDecides) {  // hand arithmetic
  Block block = InNoOrder();
  // Point 600 has the passes of point 0; without its second look it ends a pass before.
  const std::uint64_t second = block.looks.offsets[601] - 1;
  block.looks.pass.erase(block.looks.pass.begin() + static_cast<std::ptrdiff_t>(second));
  for (std::size_t j = 601; j < block.looks.offsets.size(); ++j) --block.looks.offsets[j];
  const PointOrder order = OrderByPasses(block);
  ASSERT_GE(order.size(), 2U);
  EXPECT_EQ(order[0], 600U);
  EXPECT_EQ(order[1], 0U);
}

TEST(OrderByPassesTest, LeavesPointsWhereNeighboursShareTheirPasses) {
  EXPECT_THAT(OrderByPasses(BlockOf(601, 6000, [](std::uint32_t point) { return point / 10; })),
              IsEmpty());
}

TEST(OrderByPassesTest, LeavesPointsOfFewPasses) {
  EXPECT_THAT(
      OrderByPasses(BlockOf(201, 6000, [](std::uint32_t point) { return point * 7 % 200; })),
      IsEmpty());
}

TEST(ReorderPointsTest, MovesAPointWithAllThatBelongsToIt) {  // hand arithmetic
  Block block = BlockOf(9, 5, [](std::uint32_t point) { return point; });
  ReorderPoints({3, 0, 4, 1, 2}, &block);
  EXPECT_EQ(block.points.ids[0], "P3");
  EXPECT_EQ(block.points.ids[4], "P2");
  EXPECT_EQ(block.points.role[0], PointRole::kCheck);
  EXPECT_EQ(block.points.role[3], PointRole::kTie);
  EXPECT_EQ(block.points.given_m[2].x(), 4.0);
  ASSERT_EQ(block.points.known.size(), 1U);
  EXPECT_EQ(block.points.known[0].point, 0U);
  EXPECT_EQ(block.points.known[0].covariance_enu_m2(0, 0), 3.25);
  EXPECT_THAT(block.looks.offsets, ElementsAre(0U, 2U, 4U, 6U, 8U, 10U));
  EXPECT_THAT(block.looks.pass, ElementsAre(3U, 4U, 0U, 1U, 4U, 5U, 1U, 2U, 2U, 3U));
  EXPECT_THAT(block.looks.flags, ElementsAre(0, 0, 1, 1, 0, 0, 0, 0, 0, 0));
  EXPECT_EQ(block.looks.time_s[5], 4.625);
  EXPECT_EQ(block.looks.range_m[9], 100002.0);
  EXPECT_EQ(block.looks.azimuth_sigma[0], 3.5);
  EXPECT_TRUE(block.looks.cone.empty());
}

TEST(ReorderPointsTest, ComesBackByTheInverse) {  // round trip
  const Block before = InNoOrder();
  Block block = before;
  const PointOrder order = OrderByPasses(block);
  ReorderPoints(order, &block);
  EXPECT_NE(block.looks.range_m, before.looks.range_m);
  ReorderPoints(InverseOf(order), &block);
  EXPECT_EQ(block.looks.offsets, before.looks.offsets);
  EXPECT_EQ(block.looks.pass, before.looks.pass);
  EXPECT_EQ(block.looks.flags, before.looks.flags);
  EXPECT_EQ(block.looks.time_s, before.looks.time_s);
  EXPECT_EQ(block.looks.range_m, before.looks.range_m);
  EXPECT_EQ(block.points.role, before.points.role);
  EXPECT_EQ(block.points.given_m, before.points.given_m);
  for (std::size_t k = 0; k < before.points.known.size(); ++k) {
    EXPECT_EQ(block.points.known[k].point, before.points.known[k].point);
  }
  for (std::size_t point = 0; point < before.points.size(); ++point) {
    ASSERT_EQ(block.points.ids[point], before.points.ids[point]);
  }
}

}  // namespace
}  // namespace sarblock
