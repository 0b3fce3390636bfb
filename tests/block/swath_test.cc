// SPDX-License-Identifier: Apache-2.0
#include "block/swath.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Along x at (50 t, 300, 4000 m), strip from 2 s to 22 s; looks to the left, which is +y.
Pass EastwardPass() {
  Pass pass;
  pass.id = "A";
  const Eigen::Vector3d velocity_mps(50.0, 0.0, 0.0);
  pass.path = FlightPath(
      {{0.0, {0.0, 300.0, 4000.0}, velocity_mps}, {24.0, {1200.0, 300.0, 4000.0}, velocity_mps}});
  pass.start_s = 2.0;
  pass.end_s = 22.0;
  return pass;
}

bool Sees(const Pass& pass, double y_m, double z_m = 0.0) {
  return IsSeen(Frame::Local(), pass, *pass.path.At(10.0), {500.0, y_m, z_m});
}

// Hand arithmetic. 3 km beside the track and 4 km below it the range is 5 km and tan(look) = 3/4.
TEST(IsSeenTest, EachKindHasItsOwnQuantity) {
  Pass pass = EastwardPass();
  const double look_rad = std::atan2(3.0, 4.0);
  const struct {
    SwathKind kind;
    double value;
  } cases[] = {{SwathKind::kLookAngle, look_rad},
               {SwathKind::kGroundRange, 3000.0},
               {SwathKind::kSlantRange, 5000.0}};
  for (const auto& [kind, value] : cases) {
    pass.swath = Swath{kind, {value * (1.0 - 1e-12), value * 1.5}};
    EXPECT_TRUE(Sees(pass, 3300.0)) << static_cast<int>(kind);
    EXPECT_FALSE(Sees(pass, 3299.0)) << static_cast<int>(kind);
    pass.swath = Swath{kind, {value * 0.5, value * (1.0 + 1e-12)}};
    EXPECT_TRUE(Sees(pass, 3300.0)) << static_cast<int>(kind);
    EXPECT_FALSE(Sees(pass, 3301.0)) << static_cast<int>(kind);
    EXPECT_FALSE(Sees(pass, -2700.0)) << "the same distance on the other side";
  }
}

TEST(IsSeenTest, WithoutASwathAPassSeesItsSideBelowTheAntenna) {  // hand arithmetic
  Pass pass = EastwardPass();
  EXPECT_TRUE(Sees(pass, 301.0));
  EXPECT_FALSE(Sees(pass, 299.0));
  EXPECT_FALSE(Sees(pass, 3300.0, 4001.0));
  pass.side = LookSide::kRight;
  EXPECT_FALSE(Sees(pass, 301.0));
  EXPECT_TRUE(Sees(pass, 299.0));
}

// Closed form: from r = a + H the horizon is cos(centre angle) = a/r away.
TEST(IsSeenTest, NothingIsSeenBeyondTheHorizonOfABody) {
  const Frame frame = Frame::Geocentric(NamedEllipsoid("Moon"));
  const double a_m = frame.ellipsoid().a_m, height_m = 87e3;
  const Motion motion{.position_m = {a_m + height_m, 0.0, 0.0}, .velocity_mps = {0.0, 0.0, 1600.0}};
  Pass pass = EastwardPass();
  const double horizon_rad = std::acos(a_m / (a_m + height_m));
  const auto sees = [&](double centre_rad) {
    // the flight is towards +z, up is +x: left is -y
    return IsSeen(
        frame, pass, motion, {a_m * std::cos(centre_rad), -a_m * std::sin(centre_rad), 0.0});
  };
  EXPECT_TRUE(sees(horizon_rad - 1e-6));
  EXPECT_FALSE(sees(horizon_rad + 1e-6));
  EXPECT_FALSE(sees(-1e-3));
  pass.swath = Swath{SwathKind::kLookAngle, {0.1, 0.9}};
  EXPECT_TRUE(sees(0.03));
  // where the line of sight leaves the body again: the same look angle, seen through it
  const double far_rad = 2.0 * std::acos((a_m + height_m) / a_m * std::sin(0.5)) + 0.2;
  EXPECT_FALSE(sees(far_rad));
}

TEST(TimeSeenTest, IsThatOfThePassesSquintWithinItsStrip) {  // hand arithmetic
  Pass pass = EastwardPass();
  const Frame frame = Frame::Local();
  EXPECT_NEAR(TimeSeen(frame, pass, {500.0, 3300.0, 0.0}).value(), 10.0, 1e-9);
  EXPECT_FALSE(TimeSeen(frame, pass, {99.0, 3300.0, 0.0}));  // 1.98 s, on the path before the strip
  EXPECT_FALSE(TimeSeen(frame, pass, {1101.0, 3300.0, 0.0}));
  // 5 km across the line, squint with tangent 0.05 forward: seen 250 m earlier
  pass.squint_rad = std::atan(0.05);
  EXPECT_NEAR(TimeSeen(frame, pass, {500.0, 3300.0, 0.0}).value(), 5.0, 1e-9);
}

/// Three points at look angles of 30, 45 and 60 degrees off the eastward pass and its twin.
Block TwoPassBlock() {
  Block block;
  for (const char* id : {"A", "B"}) {
    block.passes.push_back(EastwardPass());
    block.passes.back().id = id;
    block.passes.back().sigma = {1.0, 1.0, AzimuthUnit::kMetres};
  }
  for (const char* id : {"P30", "P45", "P60"}) block.points.ids.Append(id);
  block.points.role.assign(3, PointRole::kTie);
  block.points.given_m.clear();
  block.looks.offsets = {0};
  for (const double look_deg : {30.0, 45.0, 60.0}) {
    const double y_m = 300.0 + 4000.0 * std::tan(look_deg * kRadPerDeg);
    block.points.given_m.emplace_back(500.0, y_m, 0.0);
    for (const std::uint32_t pass : {0U, 1U}) {
      block.looks.pass.push_back(pass);
      block.looks.flags.push_back(0);
      block.looks.time_s.push_back(10.0);
      block.looks.range_m.push_back(4000.0 / std::cos(look_deg * kRadPerDeg));
    }
    block.looks.offsets.push_back(block.looks.size());
  }
  return block;
}

TEST(LooksOutsideSwathTest, AreCountedByKindWithTheFarthestNamed) {  // hand arithmetic
  Block block = TwoPassBlock();
  std::vector<std::uint8_t> used(block.looks.size(), 1);
  const auto found = [&] { return FindLooksOutsideSwath(block, block.points.given_m, used); };
  EXPECT_THAT(found(), IsEmpty());
  block.passes[0].swath = Swath{SwathKind::kLookAngle, {28.0 * kRadPerDeg, 42.0 * kRadPerDeg}};
  EXPECT_THAT(
      found(),
      ElementsAre(
          "2 looks are outside the swath of their pass: the farthest, pass A sees point P60 "
          "at 60, where swath_look_deg = [28, 42]; check limits, look side, point and path"));
  block.passes[1].swath = Swath{SwathKind::kSlantRange, {5000.0, 9000.0}};
  EXPECT_THAT(found(),
              ElementsAre(HasSubstr("2 looks are"),
                          HasSubstr("1 look is outside the swath of its pass: pass B sees point "
                                    "P30 at 4619, where swath_range_m = [5000, 9000]")));
  // of a width of 4000 m the look at 4619 m is 0.095 outside: with 8000 m it is within the margin
  block.passes[1].swath = Swath{SwathKind::kSlantRange, {5000.0, 13000.0}};
  EXPECT_THAT(found(), ElementsAre(HasSubstr("2 looks are")));
  block.passes[1].swath = Swath{SwathKind::kSlantRange, {13000.0, 25000.0}};
  EXPECT_THAT(found(), testing::Contains(HasSubstr("where swath_range_m = [13000, 25000]")));
  block.passes[1].swath.reset();
  used[2] = used[4] = 0;
  EXPECT_THAT(found(), IsEmpty());
}

TEST(CoverageTest, CountsLooksPerPointAndTheirAngles) {  // hand arithmetic
  Block block = TwoPassBlock();
  block.looks.flags[5] = Looks::kRejected;
  const Coverage coverage = CoverageOf(block, block.points.given_m);
  EXPECT_EQ(coverage.fewest, 1U);
  EXPECT_EQ(coverage.most, 2U);
  EXPECT_DOUBLE_EQ(coverage.looks_per_point, 5.0 / 3.0);
  EXPECT_NEAR(coverage.least_look_rad, 30.0 * kRadPerDeg, 1e-12);
  EXPECT_NEAR(coverage.most_look_rad, 60.0 * kRadPerDeg, 1e-12);
  EXPECT_EQ(Describe(coverage), "1.67 looks per point (1 to 2) at look angles of 30 to 60 degrees");
  block.passes[0].swath = Swath{SwathKind::kGroundRange, {1.0, 2.0}};
  EXPECT_THAT(WarningOfPlan(block, block.points.given_m).value(),
              HasSubstr("1.67 looks per point"));
  block.passes[1].swath = block.passes[0].swath;
  EXPECT_FALSE(WarningOfPlan(block, block.points.given_m));
}

TEST(SwathTest, OfABlockFilledByHandIsChecked) {
  Block block = TwoPassBlock();
  EXPECT_NO_THROW(Validate(block));
  const auto message = [&] {
    try {
      Validate(block);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  block.passes[1].swath = Swath{SwathKind::kLookAngle, {30.0 * kRadPerDeg, 90.0 * kRadPerDeg}};
  EXPECT_EQ(message(),
            "passes[1]: 'B': swath_look_deg must be near and far, 0 <= near < far < 90, got 30 and "
            "90");
  block.passes[1].swath = Swath{SwathKind::kSlantRange, {7.0, 5.0}};
  EXPECT_EQ(message(),
            "passes[1]: 'B': swath_range_m must be near and far, 0 <= near < far, got 7 and 5");
  block.passes[1].swath = Swath{SwathKind::kGroundRange, {kNotGiven, 5.0}};
  EXPECT_THAT(message(), HasSubstr("swath_ground_m must be"));
  block.passes[1].swath.reset();
  block.passes[1].squint_rad = -1.6;
  EXPECT_THAT(message(), HasSubstr("must have a squint between -pi/2 and pi/2 [rad], exclusive"));
}

}  // namespace
}  // namespace sarblock
