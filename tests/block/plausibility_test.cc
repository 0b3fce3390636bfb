// SPDX-License-Identifier: Apache-2.0
// Mistakes that a block shows before it is adjusted: each made once in a block that is right, which
// draws no remark.
#include "block/plausibility.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::AllOf;
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

// A quarter of a circle of 1.9 km between straight legs, ranges of 5 km: looks on the legs are no
// look in a turn, those between are.
TEST(PlausibilityTest, LooksInATurnAreNamed) {
  constexpr double kRadius_m = 1900.0, kSpeed_mps = 97.0, kLeg_s = 120.0;
  const double turn_s = 0.5 * M_PI * kRadius_m / kSpeed_mps;
  const auto at = [&](double time_s) -> StateVector {
    if (time_s < 0.0) return {time_s, {kSpeed_mps * time_s, 0.0, 3000.0}, {kSpeed_mps, 0.0, 0.0}};
    const double angle = std::min(time_s, turn_s) * kSpeed_mps / kRadius_m;
    const double after_m = kSpeed_mps * std::max(0.0, time_s - turn_s);
    return {time_s,
            {kRadius_m * std::sin(angle), kRadius_m * (1.0 - std::cos(angle)) + after_m, 3000.0},
            {kSpeed_mps * std::cos(angle), kSpeed_mps * std::sin(angle), 0.0}};
  };
  Block block = test::MakeBlock(test::AircraftPlan(0.0, false)).block;
  std::vector<StateVector> states;
  for (double t_s = -kLeg_s; t_s < turn_s + kLeg_s; t_s += 0.7) states.push_back(at(t_s));
  block.passes[0].path = FlightPath(std::move(states));
  const auto times = [&](double time_s) {
    ChangeLooks(
        0,
        [&](std::size_t i) {
          block.looks.time_s[i] = time_s;
          block.looks.range_m[i] = 5000.0;
        },
        block);
  };
  const auto named = Contains(HasSubstr("looks are in a turn of its path, the first of point "));
  times(-60.0);
  EXPECT_THAT(ExaminePlausibility(block), testing::Not(named));
  times(turn_s + 60.0);
  EXPECT_THAT(ExaminePlausibility(block), testing::Not(named));
  times(0.5 * turn_s);
  EXPECT_THAT(ExaminePlausibility(block), named);
}

// One flight under two names, and the same states at other times or on another day.
TEST(SameFlightsTest, PassesWithTheSameStatesAreNamed) {
  const auto unshared = [](std::size_t, std::size_t) { return false; };
  Block block = RightBlock(test::OrbitPlan(0.0, false));
  for (Pass& pass : block.passes) pass.epoch_utc = "2022-10-16T01:50:44Z";
  EXPECT_THAT(FindSameFlights(block, unshared), IsEmpty());
  block.passes[1].path = block.passes[0].path;
  const std::string both = "passes " + block.passes[0].id + " and " + block.passes[1].id + " have ";
  EXPECT_THAT(FindSameFlights(block, unshared),
              ElementsAre(AllOf(HasSubstr(both), HasSubstr("they are one flight"))));
  EXPECT_THAT(FindSameFlights(block, [](std::size_t a, std::size_t b) { return a == 0 && b == 1; }),
              IsEmpty());
  ChangeStates(
      1, [](StateVector* state) { state->time_s += 3.5; }, &block);
  EXPECT_THAT(FindSameFlights(block, unshared),
              ElementsAre(HasSubstr("3.5 s apart): one of both has the orbit of another date")));
  ChangeStates(
      1, [](StateVector* state) { state->time_s -= 3.5; }, &block);
  block.passes[1].epoch_utc = "2022-10-28T01:50:44Z";
  EXPECT_THAT(FindSameFlights(block, unshared), ElementsAre(HasSubstr("orbit of another date")));
  // The epoch moved and the times with it: one flight again.
  block.passes[1].epoch_utc = "2022-10-16T01:50:41Z";
  ChangeStates(
      1, [](StateVector* state) { state->time_s += 3.0; }, &block);
  EXPECT_THAT(FindSameFlights(block, unshared), ElementsAre(HasSubstr("they are one flight")));
  // The same over midnight: the dates differ, the instants do not.
  block.passes[0].epoch_utc = "2022-10-16T23:59:58Z";
  block.passes[1].epoch_utc = "2022-10-17T00:00:01Z";
  ChangeStates(
      1, [](StateVector* state) { state->time_s -= 6.0; }, &block);
  EXPECT_THAT(FindSameFlights(block, unshared), ElementsAre(HasSubstr("they are one flight")));
}

// Known points apart by the last digit are two; the same coordinates are one point.
TEST(SameKnownPointsTest, AreNamedWhereTheirCoordinatesAreTheSame) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  for (const std::size_t point : {1U, 4U, 7U}) test::AddKnownPoint(point, {0.2, 0.2, 0.2}, &known);
  Block& block = known.block;
  EXPECT_THAT(FindSameKnownPoints(block), IsEmpty());
  block.points.given_m[7] = block.points.given_m[1];
  EXPECT_THAT(FindSameKnownPoints(block),
              ElementsAre(AllOf(HasSubstr(std::string(block.points.ids[1])),
                                HasSubstr(std::string(block.points.ids[7])),
                                HasSubstr("with the same coordinates"))));
  block.points.given_m[7].z() += 1e-9;
  EXPECT_THAT(FindSameKnownPoints(block), IsEmpty());
}

TEST(PlausibilityTest, StatesThatAlternateBetweenTwoSolutionsAreNamed) {
  Block block = RightBlock(test::OrbitPlan(0.0, false));
  std::vector<StateVector> states;
  const FlightPath& path = block.passes[0].path;
  for (int k = 0; k < 40; ++k) {
    const double time_s = path.start_s() + (path.end_s() - path.start_s()) * k / 39.0;
    const Motion motion = *path.At(time_s);
    const Eigen::Vector3d off_m(0.0, k % 2 == 0 ? 0.0 : 0.61, 0.0);
    states.push_back({time_s, motion.position_m + off_m, motion.velocity_mps});
  }
  block.passes[0].path = FlightPath(std::move(states));
  EXPECT_THAT(ExaminePlausibility(block),
              Contains(AllOf(HasSubstr("pass " + block.passes[0].id + ": its states alternate"),
                             HasSubstr("0.61 m"))));
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

TEST(PlausibilityTest, CoordinatesOfAMapProjectionAreNamed) {
  Block block = RightBlock(test::AircraftPlan());
  const auto move = [&block](const Eigen::Vector3d& by_m) {
    for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
      ChangeStates(
          pass, [&by_m](StateVector* state) { state->position_m += by_m; }, &block);
    }
    for (const KnownPosition& known : block.points.known) {
      block.points.given_m[known.point] += by_m;
    }
  };
  move({437000.0, 5312000.0, 0.0});  // as in zone 32, 48 degrees north
  EXPECT_THAT(ExaminePlausibility(block),
              ElementsAre(HasSubstr("coordinates are like those of a map projection")));
  move({-437000.0, -5312000.0, 300000.0});
  EXPECT_THAT(ExaminePlausibility(block), testing::Not(Contains(HasSubstr("map projection"))));
}

// Hand arithmetic: 0.1 ms at 7.5 km/s is 0.75 m, its rounding 0.22 m; four decimals of a degree are
// 11.1 m, their rounding 3.2 m; a range in whole metres rounds by 0.29 m.
TEST(PlausibilityTest, DecimalsThatRoundMoreThanIsStatedAreNamed) {
  const auto rounded = [](double value, double step) { return step * std::round(value / step); };
  Block block = RightBlock(test::OrbitPlan());
  for (Pass& pass : block.passes) pass.sigma = {0.4, 6e-5, AzimuthUnit::kSeconds};
  EXPECT_THAT(ExaminePlausibility(block), IsEmpty());
  ChangeLooks(
      1,
      [&](std::size_t i) { block.looks.time_s[i] = rounded(block.looks.time_s[i], 1e-4); },
      block);
  EXPECT_THAT(ExaminePlausibility(block), IsEmpty());  // 29 us beside 60
  for (Pass& pass : block.passes) pass.sigma = {0.4, 2e-5, AzimuthUnit::kSeconds};
  EXPECT_THAT(
      ExaminePlausibility(block),
      ElementsAre(HasSubstr("pass A2: its times are multiples of 0.0001: rounding alone is 0.2")));
  ChangeLooks(
      2,
      [&](std::size_t i) { block.looks.range_m[i] = std::round(block.looks.range_m[i]); },
      block);
  EXPECT_THAT(
      ExaminePlausibility(block),
      Contains(HasSubstr("pass A3: its ranges are multiples of 1: rounding alone is 0.2887 m")));
  block = RightBlock(test::OrbitPlan());
  for (const KnownPosition& known : block.points.known) {
    Eigen::Vector3d& p_m = block.points.given_m[known.point];
    Geodetic at = block.frame.GeodeticFromFrame(p_m);
    at.lat_rad = kRadPerDeg * rounded(kDegPerRad * at.lat_rad, 1e-4);
    at.lon_rad = kRadPerDeg * rounded(kDegPerRad * at.lon_rad, 1e-4);
    p_m = block.frame.FrameFromGeodetic(at);
  }
  EXPECT_THAT(ExaminePlausibility(block),
              ElementsAre(HasSubstr("lat_deg of known points are multiples of 0.0001 deg: rounding "
                                    "alone is 3.2"),
                          HasSubstr("lon_deg of known points are multiples of 0.0001 deg")));
}

/// Rounds a coordinate of all known points.
void RoundKnown(const std::function<void(Geodetic*, Eigen::Vector3d*)>& round, Block* block) {
  for (const KnownPosition& known : block->points.known) {
    Eigen::Vector3d& p_m = block->points.given_m[known.point];
    Geodetic at = block->frame.GeodeticFromFrame(p_m);
    Eigen::Vector3d rounded_m = p_m;
    round(&at, &rounded_m);
    p_m = rounded_m == p_m ? block->frame.FrameFromGeodetic(at) : rounded_m;
  }
}

// Rounding to a metre is 0.289 m. Standard deviations are 0.31, 0.47 and 0.83 m east, north and up:
// 0.289 is more than half of the first two and less than that of the third.
TEST(PlausibilityTest, DecimalsOfKnownPointsAreNamedByColumn) {
  const Block right = RightBlock(test::OrbitPlan());
  ASSERT_GE(right.points.known.size(), 5U);
  Block block = right;
  RoundKnown([](Geodetic* at, Eigen::Vector3d*) { at->h_m = std::round(at->h_m); }, &block);
  EXPECT_THAT(ExaminePlausibility(block), IsEmpty());
  for (KnownPosition& known : block.points.known) known.covariance_enu_m2(2, 2) = 0.31 * 0.31;
  EXPECT_THAT(
      ExaminePlausibility(block),
      ElementsAre(HasSubstr("h_m of known points are multiples of 1 m: rounding alone is 0.2887")));
  // Flat ground is round and not rounded.
  RoundKnown([](Geodetic* at, Eigen::Vector3d*) { at->h_m = 140.0; }, &block);
  EXPECT_THAT(ExaminePlausibility(block),
              testing::Not(Contains(HasSubstr("h_m of known points are multiples"))));
  for (const int axis : {0, 1, 2}) {
    block = right;
    for (KnownPosition& known : block.points.known) {
      known.covariance_enu_m2 = 0.31 * 0.31 * Eigen::Matrix3d::Identity();
    }
    EXPECT_THAT(ExaminePlausibility(block), IsEmpty());
    RoundKnown([axis](Geodetic*, Eigen::Vector3d* p_m) { (*p_m)[axis] = std::round((*p_m)[axis]); },
               &block);
    const std::string column =
        std::string(1, "xyz"[axis]) + "_m of known points are multiples of 1 m";
    EXPECT_THAT(ExaminePlausibility(block), ElementsAre(HasSubstr(column)));
  }
}

}  // namespace
}  // namespace sarblock
