// SPDX-License-Identifier: Apache-2.0
// Mistakes that a block shows before it is adjusted: each made once in a block that is right, which
// draws no remark.
#include "block/plausibility.h"

#include "sarblock/core/error.h"

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// Exact looks, six points known, the paths off by what navigation may be.
Block RightBlock(const test::BlockPlan& plan) {
  test::KnownBlock known = test::MakeBlock(plan);
  for (const std::size_t point : {0U, 2U, 3U, 5U, 7U, 11U}) {
    test::AddKnownPoint(point, {0.31, 0.47, 0.83}, &known, PointRole::kCheck);
  }
  test::AddNoise(41, 1.0, &known);
  test::ShiftPath(1, {73.0, -91.0, 57.0}, &known.block);
  return known.block;
}

void ChangeStates(std::size_t pass, const std::function<void(StateVector*)>& change, Block* block) {
  std::vector<StateVector> states(block->passes[pass].path.states());
  for (StateVector& state : states) change(&state);
  block->passes[pass].path = FlightPath(std::move(states));
}

void ChangeLooks(std::uint32_t pass,
                 const std::function<void(std::size_t)>& change,
                 const Block& block) {
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (block.looks.pass[i] == pass) change(i);
  }
}

TEST(PlausibilityTest, RightBlocksDrawNoRemark) {
  for (const double squint_deg : {0.0, 12.0}) {
    for (const bool doppler : {false, true}) {
      EXPECT_THAT(ExaminePlausibility(RightBlock(test::AircraftPlan(squint_deg, doppler))),
                  IsEmpty());
      const Block orbit = RightBlock(test::OrbitPlan(squint_deg, doppler));
      EXPECT_THAT(ExaminePlausibility(orbit), IsEmpty());
      EXPECT_NO_THROW(RequireAboveGround(orbit));
    }
  }
}

TEST(PlausibilityTest, VelocitiesThatAreNotThoseOfThePositionsAreNamed) {
  Block block = RightBlock(test::AircraftPlan());
  ChangeStates(
      2, [](StateVector* state) { state->velocity_mps *= -1.0; }, &block);
  EXPECT_THAT(ExaminePlausibility(block),
              Contains(HasSubstr("pass A3: its velocities are not those of its positions")));
  block = RightBlock(test::OrbitPlan());
  ChangeStates(
      0, [](StateVector* state) { state->velocity_mps *= 1e-3; }, &block);
  EXPECT_THAT(ExaminePlausibility(block),
              Contains(HasSubstr("pass A1: its velocities are not those of its positions")));
}

TEST(PlausibilityTest, RangesOfAnotherUnitAreNamed) {
  Block block = RightBlock(test::AircraftPlan());
  ChangeLooks(
      0, [&](std::size_t i) { block.looks.range_m[i] *= 2.0; }, block);
  EXPECT_THAT(ExaminePlausibility(block), ElementsAre(HasSubstr("pass A1: its ranges are 2")));
  block = RightBlock(test::OrbitPlan());
  ChangeLooks(
      1, [&](std::size_t i) { block.looks.range_m[i] *= 1e-3; }, block);
  EXPECT_THAT(ExaminePlausibility(block), Contains(HasSubstr("but its shortest range is")));
}

TEST(PlausibilityTest, TimesOfAnotherOriginAreNamed) {
  Block block = RightBlock(test::AircraftPlan());
  ChangeLooks(
      3, [&](std::size_t i) { block.looks.time_s[i] += 17.0; }, block);
  EXPECT_THAT(ExaminePlausibility(block), ElementsAre(HasSubstr("pass A4: its known points lie ")));
}

TEST(PlausibilityTest, TheWrongSideIsNamed) {
  Block block = RightBlock(test::OrbitPlan());
  block.passes[2].side = LookSide::kLeft;
  EXPECT_THAT(ExaminePlausibility(block),
              ElementsAre(HasSubstr("pass A3: 6 of its 6 known points lie above the antenna or")));
}

TEST(PlausibilityTest, AKnownPointThatLiesElsewhereIsNamed) {
  Block block = RightBlock(test::AircraftPlan());
  std::swap(block.points.given_m[3], block.points.given_m[7]);
  EXPECT_THAT(
      ExaminePlausibility(block),
      ElementsAre(testing::AllOf(
          HasSubstr("known points that do not lie where"), HasSubstr("P4 ("), HasSubstr("P8 ("))));
}

TEST(PlausibilityTest, LocalCoordinatesInAGeocentricFrameAreRefused) {
  Block block = RightBlock(test::AircraftPlan());
  block.frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  EXPECT_THAT([&] { RequireAboveGround(block); },
              testing::ThrowsMessage<InputError>(testing::AllOf(HasSubstr("pass A1: its path is"),
                                                                HasSubstr("below the ground"))));
}

}  // namespace
}  // namespace sarblock
