// SPDX-License-Identifier: Apache-2.0
#include "sarblock/block/block.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::ElementsAre;
using Fixed = std::optional<std::array<double, 2>>;

FlightPath StraightPath(double start_s, double end_s) {
  const Eigen::Vector3d velocity_mps(211.7, 0.0, 0.0);
  return FlightPath({{start_s, {0.0, 0.0, 8123.4}, velocity_mps},
                     {end_s, (end_s - start_s) * velocity_mps, velocity_mps}});
}

// Five looks in no order: (point, pass) = (2,1) (0,1) (2,0) (0,0) (2,2); point 1 has none.
Looks ShuffledLooks() {
  Looks looks;
  looks.pass = {1, 1, 0, 0, 2};
  looks.flags = {0, Looks::kRejected, 0, Looks::kAzimuthSeconds, 0};
  looks.time_s = {21.25, 1.5, 20.75, 0.625, 22.125};
  looks.range_m = {5021.0, 5001.0, 5020.0, 5000.0, 5022.0};
  looks.azimuth_sigma = {kNotGiven, kNotGiven, 0.375, 0.0025, kNotGiven};
  return looks;
}
const std::vector<std::uint32_t> kPointOfLook{2, 0, 2, 0, 2};

Block ThreePasses() {
  Block block;
  for (const char* id : {"A", "B", "C"}) {
    Pass pass;
    pass.id = id;
    pass.path = StraightPath(-3.5, 41.25);
    pass.sigma = {1.25, 0.875, AzimuthUnit::kMetres};
    block.passes.push_back(std::move(pass));
  }
  block.looks = ShuffledLooks();
  SortLooksByPoint(kPointOfLook, 3, &block.looks);
  return block;
}

TEST(LooksTest, EachLookFindsItsPointAlsoBesidePointsWithoutLooks) {
  Looks looks;
  looks.offsets = {0, 0, 2, 2, 2, 5, 6, 6};
  looks.pass.assign(6, 0);
  const std::vector<std::size_t> point_of = {1, 1, 4, 4, 4, 5};
  for (std::size_t look = 0; look < looks.size(); ++look) {
    EXPECT_EQ(looks.PointOf(look), point_of[look]) << look;
  }
}

TEST(SortLooksByPointTest, OrdersByPointAndThenByPass) {  // hand arithmetic
  Looks looks = ShuffledLooks();
  const auto old_of_new = SortLooksByPoint(kPointOfLook, 3, &looks);
  EXPECT_THAT(old_of_new, ElementsAre(3u, 1u, 2u, 0u, 4u));
  EXPECT_THAT(looks.offsets, ElementsAre(0u, 2u, 2u, 5u));
  EXPECT_THAT(looks.pass, ElementsAre(0u, 1u, 0u, 1u, 2u));
  EXPECT_THAT(looks.range_m, ElementsAre(5000.0, 5001.0, 5020.0, 5021.0, 5022.0));
  EXPECT_THAT(looks.time_s, ElementsAre(0.625, 1.5, 20.75, 21.25, 22.125));
  EXPECT_TRUE(looks.rejected(1));
  EXPECT_FALSE(looks.rejected(0));
  EXPECT_TRUE(looks.cone.empty());  // a column that no look uses stays empty
}

TEST(SortLooksByPointTest, MovesNothingThatIsInOrder) {  // hand arithmetic
  Looks looks = ShuffledLooks();
  static_cast<void>(SortLooksByPoint(kPointOfLook, 3, &looks));
  const Looks sorted = looks;
  EXPECT_TRUE(SortLooksByPoint({0, 0, 2, 2, 2}, 3, &looks).empty());
  EXPECT_EQ(looks.offsets, sorted.offsets);
  EXPECT_EQ(looks.range_m, sorted.range_m);
  EXPECT_EQ(looks.pass, sorted.pass);
}

TEST(SortLooksByPointTest, KeepsTheOrderOfTheFileForDuplicates) {  // hand arithmetic
  Looks looks;
  looks.pass = {3, 3, 1, 3};
  looks.flags.assign(4, 0);
  looks.time_s = {4.0, 3.0, 2.0, 1.0};
  looks.range_m = {1.0, 2.0, 3.0, 4.0};
  SortLooksByPoint({0, 0, 0, 0}, 1, &looks);
  EXPECT_THAT(looks.range_m, ElementsAre(3.0, 1.0, 2.0, 4.0));
}

TEST(SortLooksByPointTest, GivesPointsWithoutLooksAnEmptyRange) {
  Looks looks;
  EXPECT_TRUE(SortLooksByPoint({}, 4, &looks).empty());
  EXPECT_THAT(looks.offsets, ElementsAre(0u, 0u, 0u, 0u, 0u));
}

// Two routes: what stands in order is examined in pieces of 32768 looks, the rest is sorted.
TEST(SortLooksByPointTest, ManyLooksInOrderGetTheOffsetsOfThoseThatAreSorted) {
  constexpr std::uint32_t kPoints = 70001;
  Looks given;
  std::vector<std::uint32_t> point_of_look;
  for (std::uint32_t point = 0; point < kPoints; ++point) {
    for (std::uint32_t pass = 0; pass < point % 4; ++pass) {  // every fourth point has none
      given.pass.push_back(2 * pass + 1);
      given.time_s.push_back(0.25 * point + pass);
      point_of_look.push_back(point);
    }
  }
  given.flags.assign(given.size(), 0);
  given.range_m = given.time_s;
  Looks in_order = given;
  EXPECT_TRUE(SortLooksByPoint(point_of_look, kPoints, &in_order).empty());
  const auto same_as_in_order = [&](const Looks& sorted) {
    EXPECT_EQ(sorted.offsets, in_order.offsets);
    EXPECT_EQ(sorted.pass, in_order.pass);
    EXPECT_EQ(sorted.time_s, in_order.time_s);
  };
  // Out of order at one place alone: within a piece, and where a piece ends.
  for (const std::size_t place : {std::size_t{40001}, std::size_t{65536}, given.size() - 1}) {
    Looks swapped = given;
    std::vector<std::uint32_t> points = point_of_look;
    std::swap(swapped.pass[place - 1], swapped.pass[place]);
    std::swap(swapped.time_s[place - 1], swapped.time_s[place]);
    std::swap(points[place - 1], points[place]);
    EXPECT_FALSE(SortLooksByPoint(points, kPoints, &swapped).empty()) << place;
    same_as_in_order(swapped);
  }
}

TEST(SigmaOfTest, TakesTheLooksOwnValueBeforeThatOfThePass) {
  const Block block = ThreePasses();
  const LookSigma own_seconds = block.SigmaOf(0);
  EXPECT_EQ(own_seconds.azimuth, 0.0025);
  EXPECT_EQ(own_seconds.azimuth_unit, AzimuthUnit::kSeconds);
  EXPECT_EQ(own_seconds.range_m, 1.25);
  const LookSigma of_pass = block.SigmaOf(1);
  EXPECT_EQ(of_pass.azimuth, 0.875);
  EXPECT_EQ(of_pass.azimuth_unit, AzimuthUnit::kMetres);
}

TEST(SigmaOfTest, KeepsMetresOfALookWhosePassGivesSeconds) {
  Block block = ThreePasses();
  block.passes[0].sigma = {2.5, 0.0005, AzimuthUnit::kSeconds};
  const LookSigma own_metres = block.SigmaOf(2);
  EXPECT_EQ(own_metres.azimuth, 0.375);
  EXPECT_EQ(own_metres.azimuth_unit, AzimuthUnit::kMetres);
  EXPECT_EQ(own_metres.range_m, 2.5);
}

TEST(FindKnownTest, FindsKnownPointsOnly) {
  Points points;
  for (const std::uint32_t point : {3u, 7u, 19u}) {
    KnownPosition known;
    known.point = point;
    points.known.push_back(known);
  }
  EXPECT_EQ(points.FindKnown(7), &points.known[1]);
  EXPECT_EQ(points.FindKnown(19), &points.known[2]);
  EXPECT_EQ(points.FindKnown(8), nullptr);
  EXPECT_EQ(points.FindKnown(20), nullptr);
}

TEST(SetStripSpansTest, SpansTheLooksThatTakePart) {  // hand arithmetic
  Block block = ThreePasses();
  SetStripSpans({}, &block);
  EXPECT_EQ(block.passes[0].start_s, 0.625);
  EXPECT_EQ(block.passes[0].end_s, 20.75);
  EXPECT_EQ(block.passes[1].start_s, 20.75);  // half a second on each side of its only look
  EXPECT_EQ(block.passes[1].end_s, 21.75);
}

TEST(SetStripSpansTest, SpansManyLooksWhereverTheFirstAndTheLastAre) {  // closed form
  Block block = ThreePasses();
  constexpr std::size_t kLooks = 100003;
  block.looks = {};
  for (std::size_t i = 0; i < kLooks; ++i) {
    block.looks.pass.push_back(i % 3 == 0 ? 2 : 0);
    block.looks.time_s.push_back(0.125 * static_cast<double>((i + 50000) % kLooks));
    block.looks.flags.push_back(0);
  }
  SetStripSpans({}, &block);
  EXPECT_EQ(block.passes[0].start_s, 0.0);             // look 50003
  EXPECT_EQ(block.passes[0].end_s, 0.125 * 100002.0);  // look 50002
  EXPECT_EQ(block.passes[2].start_s, 0.125);           // look 50004
  EXPECT_EQ(block.passes[2].end_s, 0.125 * 100001.0);  // look 50001
}

TEST(SetStripSpansTest, PutsOneSecondAroundASingleTime) {
  Block block = ThreePasses();
  SetStripSpans({}, &block);
  EXPECT_EQ(block.passes[2].start_s, 21.625);
  EXPECT_EQ(block.passes[2].end_s, 22.625);
}

TEST(SetStripSpansTest, TakesThePathWhereAPassHasNoTimes) {
  Block block = ThreePasses();
  for (double& time_s : block.looks.time_s) time_s = kNotGiven;
  SetStripSpans({}, &block);
  EXPECT_EQ(block.passes[1].start_s, -3.5);
  EXPECT_EQ(block.passes[1].end_s, 41.25);
}

TEST(SetStripSpansTest, LetsThePassesOwnSpanWin) {
  Block block = ThreePasses();
  SetStripSpans({Fixed{}, Fixed{{-1.75, 33.5}}}, &block);
  EXPECT_EQ(block.passes[0].start_s, 0.625);
  EXPECT_EQ(block.passes[1].start_s, -1.75);
  EXPECT_EQ(block.passes[1].end_s, 33.5);
}

TEST(SetStripSpansTest, RefusesAnEmptySpan) {
  Block block = ThreePasses();
  EXPECT_THROW(SetStripSpans({Fixed{{2.5, 2.5}}}, &block), InputError);
}

}  // namespace
}  // namespace sarblock
