// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/leberl/formulas.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace sarblock::leberl {
namespace {

// Hand values rest on two Pythagorean triangles: H = 12, y = 16, r' = 20; y - B = 5, r'' = 13.
const StereoConfiguration kHand{.base_m = 11.0, .height_m = 12.0, .ground_range_m = 16.0};
// Opposite-side: y = 16, r' = 20; y - B = -5, r'' = 13.
const StereoConfiguration kHandOpposite{.base_m = 21.0,
                                        .height_m = 12.0,
                                        .ground_range_m = 16.0,
                                        .arrangement = Arrangement::kOppositeSide};
constexpr double kRounding = 1e-14;  // a dozen operations on numbers near 1

StereoErrors Second(const StationErrors& errors) { return {.first = {}, .second = errors}; }
StereoErrors First(const StationErrors& errors) { return {.first = errors, .second = {}}; }

TEST(StereoConfigurationTest, GivesAnglesAndRangesOfTheHandTriangles) {
  EXPECT_DOUBLE_EQ(FirstSlantRange(kHand), 20.0);
  EXPECT_DOUBLE_EQ(SecondSlantRange(kHand), 13.0);
  EXPECT_NEAR(std::tan(FirstLookAngle(kHand)), 16.0 / 12.0, kRounding);
  EXPECT_NEAR(std::tan(SecondLookAngle(kHand)), 5.0 / 12.0, kRounding);
  // tan of a difference: (4/3 - 5/12) / (1 + 4/3 5/12) = 33/56, of a sum: 63/16
  EXPECT_NEAR(std::tan(IntersectionAngle(kHand)), 33.0 / 56.0, kRounding);
  EXPECT_NEAR(std::tan(IntersectionAngle(kHandOpposite)), 63.0 / 16.0, 1e-13);
}

TEST(StereoConfigurationTest, RefusesWhatIsNotStereo) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NO_THROW(Validate(kHand));
  EXPECT_NO_THROW(Validate(kHandOpposite));
  for (const StereoConfiguration& bad : {
           StereoConfiguration{.base_m = 0.0, .height_m = 12.0, .ground_range_m = 16.0},
           StereoConfiguration{.base_m = nan, .height_m = 12.0, .ground_range_m = 16.0},
           StereoConfiguration{.base_m = 11.0, .height_m = -12.0, .ground_range_m = 16.0},
           StereoConfiguration{.base_m = 11.0, .height_m = 12.0, .ground_range_m = 10.9},
           StereoConfiguration{.base_m = 11.0, .height_m = 12.0, .ground_range_m = 11.0},
           StereoConfiguration{.base_m = 11.0,
           .height_m = 12.0,
           .ground_range_m = 16.0,
           .arrangement = Arrangement::kOppositeSide},
       }) {
    EXPECT_THROW(Validate(bad), InputError) << bad.base_m << " " << bad.ground_range_m;
  }
}

TEST(ViewingGuidanceTest, JudgesTheQuotedIntervals) {  // hand: theta' = 53.13, theta'' = 22.62 deg
  const ViewingGuidance hand = CheckViewing(kHand);
  EXPECT_NEAR(hand.first_look_rad * kDegPerRad, 53.13010, 1e-5);
  EXPECT_NEAR(hand.second_look_rad * kDegPerRad, 22.61986, 1e-5);
  EXPECT_FALSE(hand.looks_within_37_and_67_deg);
  EXPECT_FALSE(hand.looks_not_below_40_deg);
  EXPECT_FALSE(hand.intersection_within_12_and_15_deg);
  // the aircraft of Table 1 in the middle of its model: 62.2 and 47.7 degrees
  const ViewingGuidance aircraft =
      CheckViewing({.base_m = 8e3, .height_m = 10e3, .ground_range_m = 19e3});
  EXPECT_TRUE(aircraft.looks_within_37_and_67_deg);
  EXPECT_TRUE(aircraft.looks_not_below_40_deg);
  EXPECT_TRUE(aircraft.intersection_within_12_and_15_deg);
}

TEST(ParallaxTest,
     FollowsTheHandTriangles) {  // cot' = 3/4, cot'' = 12/5; cos' = 3/5, cos'' = 12/13
  const double h = 0.37;
  EXPECT_NEAR(
      ParallaxFromHeight(kHand, h, Presentation::kGroundRange), h * (2.4 - 0.75), kRounding);
  EXPECT_NEAR(
      ParallaxFromHeight(kHand, h, Presentation::kSlantRange), h * (12.0 / 13.0 - 0.6), kRounding);
  EXPECT_NEAR(ParallaxFromHeight(kHandOpposite, h, Presentation::kGroundRange),
              h * (2.4 + 0.75),
              kRounding);
  EXPECT_NEAR(ParallaxFromHeight(kHandOpposite, h, Presentation::kSlantRange),
              h * (12.0 / 13.0 + 0.6),
              kRounding);
  EXPECT_NEAR(AbsoluteParallax(kHand), 7.0, kRounding);  // 20 - 13
  EXPECT_NEAR(AbsoluteParallax(kHandOpposite), 7.0, kRounding);
}

TEST(ParallaxTest, ComesBackThroughItsInverse) {  // round trip
  for (const StereoConfiguration& c : {kHand, kHandOpposite}) {
    for (const Presentation p : {Presentation::kGroundRange, Presentation::kSlantRange}) {
      EXPECT_NEAR(HeightFromParallax(c, ParallaxFromHeight(c, 1.2347, p), p), 1.2347, kRounding);
    }
  }
}

TEST(ExaggerationTest, HasTheSameValueInBothRadarForms) {  // closed form, hand: 5 (12/5 -/+ 3/4)
  EXPECT_NEAR(Exaggeration(kHand), 5.0 * 1.65, 1e-13);
  EXPECT_NEAR(Exaggeration(kHandOpposite), 5.0 * 3.15, 1e-13);
  for (const StereoConfiguration& c : {kHand, kHandOpposite}) {
    EXPECT_NEAR(ExaggerationFromAngles(
                    std::abs(FirstLookAngle(c)), std::abs(SecondLookAngle(c)), c.arrangement),
                Exaggeration(c),
                1e-13);
  }
  EXPECT_DOUBLE_EQ(CameraExaggeration(3.3, 5.5), 3.0);
}

TEST(PointErrorsTest, EqualHandValuesTermByTerm) {
  const auto expect = [](const StereoErrors& e, double dx, double dy, double dz) {
    const PointError found = PointErrors(kHand, e, Signs::kPrinted);
    EXPECT_NEAR(found.dx_m, dx, kRounding);
    EXPECT_NEAR(found.dy_m, dy, kRounding);
    EXPECT_NEAR(found.dz_m, dz, kRounding);
  };
  expect(First({.dx0_m = 0.3}), 0.15, 0, 0);
  expect(Second({.dx0_m = 0.3}), 0.15, 0, 0);
  expect(First({.dy0_m = 0.3}), 0, 0.3 * 16 / 11, 0.3 * 16 * 5 / (12 * 11));
  expect(Second({.dy0_m = 0.3}), 0, -0.3 * 5 / 11, -0.3 * 16 * 5 / (12 * 11));
  expect(First({.dz0_m = 0.3}), 0, -0.3 * 12 / 11, -0.3 * 5 / 11);
  expect(Second({.dz0_m = 0.3}), 0, 0.3 * 12 / 11, 0.3 * 16 / 11);
  expect(First({.dr_m = 0.3}), 0, 0.3 * 20 / 11, 0.3 * 20 * 5 / (11 * 12));
  expect(Second({.dr_m = 0.3}), 0, -0.3 * 13 / 11, -0.3 * 13 * 16 / (11 * 12));
  expect(First({.dydot0 = 0.03}), 0.03 * 8, 0, 0);
  expect(Second({.dydot0 = 0.03}), 0.03 * 2.5, 0, 0);
  expect(First({.dzdot0 = 0.03}), 0.03 * 6, 0, 0);
  expect(Second({.dzdot0 = 0.03}), 0.03 * 6, 0, 0);
  EXPECT_NEAR(AcrossErrorOfSecondAcross(kHand, 0.3), -0.3 * 5 / 11, kRounding);
}

TEST(PointErrorsTest, TurnTheYawTermAloneInTheDerivedSigns) {
  const StereoErrors errors{.first = {.dx0_m = 0.7, .dydot0 = 0.03, .dzdot0 = 0.02},
                            .second = {.dydot0 = 0.05}};
  EXPECT_NEAR(AlongError(kHand, errors, Signs::kPrinted), 0.35 + 0.24 + 0.125 + 0.12, kRounding);
  EXPECT_NEAR(AlongError(kHand, errors, Signs::kDerived), 0.35 - 0.24 - 0.125 + 0.12, kRounding);
}

TEST(PointErrorsTest,
     MoveThePointWithBothStations) {  // invariance: a common shift shifts the model
  const StationErrors shift{.dx0_m = 0.31, .dy0_m = -0.47, .dz0_m = 0.83};
  for (const StereoConfiguration& c : {kHand, kHandOpposite}) {
    const PointError found = PointErrors(c, {.first = shift, .second = shift}, Signs::kPrinted);
    EXPECT_NEAR(found.dx_m, 0.31, kRounding);
    EXPECT_NEAR(found.dy_m, -0.47, kRounding);
    EXPECT_NEAR(found.dz_m, 0.83, kRounding);
  }
}

TEST(RelativeErrorsTest, EqualHandValues) {
  EXPECT_NEAR(AcrossErrorOfBase(kHand, 0.3), -0.3 * 16 / 11, kRounding);
  EXPECT_NEAR(HeightErrorOfBase(kHand, 0.3), -0.3 * 5 * 16 / (11 * 12), kRounding);
  EXPECT_NEAR(AcrossErrorOfHeight(kHand, 0.3), 0.3 * 12 / 11, kRounding);
  EXPECT_NEAR(HeightErrorOfHeight(kHand, 0.3), 0.3 * 16 / 11, kRounding);

  const Difference d{.dy_m = 0.9, .dz_m = 0.4};
  const Difference base = DifferenceErrorOfBase(kHand, d, 0.3, Signs::kPrinted);
  EXPECT_NEAR(base.dy_m, -0.3 * 0.9 / 11, kRounding);
  EXPECT_NEAR(base.dz_m, 0.3 * (-0.9 * 21 / 132 + 0.4 * 80 / 1584), kRounding);
  EXPECT_NEAR(DifferenceErrorOfBase(kHand, d, 0.3, Signs::kDerived).dz_m,
              0.3 * (-0.9 * 21 / 132 - 0.4 * 80 / 1584),
              kRounding);
  const Difference height = DifferenceErrorOfHeight(kHand, d, 0.3, Signs::kPrinted);
  EXPECT_NEAR(height.dy_m, 0.3 * 0.4 / 11, kRounding);
  EXPECT_NEAR(height.dz_m, 0.3 * 0.9 / 11, kRounding);
  EXPECT_NEAR(
      DifferenceErrorOfHeight(kHand, d, 0.3, Signs::kDerived).dy_m, -0.3 * 0.4 / 11, kRounding);
}

TEST(RangeWarpTest, EqualsHandValues) {
  const Warp first = RangeWarp(kHand, 0.3, 0.0, Signs::kPrinted);
  EXPECT_NEAR(first.a, 0.3 * 16 / 220, kRounding);
  EXPECT_NEAR(first.f, 0.3 * 12 / 220, kRounding);
  EXPECT_NEAR(first.c, 0.3 * (20.0 / 132 + 80.0 / 2640), kRounding);
  EXPECT_NEAR(first.d, 0.3 * (5.0 / 220 - 100.0 / 1584), kRounding);
  const Warp second = RangeWarp(kHand, 0.0, 0.3, Signs::kPrinted);
  EXPECT_NEAR(second.a, -0.3 * 5 / 143, kRounding);
  EXPECT_NEAR(second.f, -0.3 * 12 / 143, kRounding);
  EXPECT_NEAR(second.c, -0.3 * (13.0 / 132 + 80.0 / 1716), kRounding);
  EXPECT_NEAR(second.d, -0.3 * (16.0 / 143 - 208.0 / 1584), kRounding);
  const Warp derived = RangeWarp(kHand, 0.3, 0.0, Signs::kDerived);
  EXPECT_EQ(derived.a, first.a);
  EXPECT_EQ(derived.f, -first.f);
  EXPECT_EQ(derived.c, first.c);
  EXPECT_EQ(derived.d, -first.d);
  const Difference of = first.Apply({.dy_m = 2.0, .dz_m = 3.0});
  EXPECT_NEAR(of.dy_m, 2.0 * first.a + 3.0 * first.f, kRounding);
  EXPECT_NEAR(of.dz_m, 2.0 * first.c + 3.0 * first.d, kRounding);
}

TEST(RangeNoiseTest, EqualsHandValues) {
  const RangeNoise noise = NoiseOfRange(kHand, 0.3);
  EXPECT_NEAR(noise.sigma_y_m, 0.3 * std::sqrt(400.0 + 169.0) / 11, kRounding);
  EXPECT_NEAR(noise.sigma_z_m, 0.3 * std::hypot(20.0 * 5, 13.0 * 16) / (11 * 12), kRounding);
  const RangeNoise one = NoiseOfRange(kHand, 0.3, 0.0);
  EXPECT_NEAR(one.sigma_y_m, 0.3 * 20 / 11, kRounding);
  EXPECT_NEAR(one.sigma_z_m, 0.3 * 100 / 132, kRounding);
}

TEST(RangeNoiseTest, IsNearly1900MetresForVoir) {  // printed: sigma_y ~ sigma_z ~ 1.9 km
  const RangeNoise noise =
      NoiseOfRange({.base_m = 40e3, .height_m = 375e3, .ground_range_m = 395e3}, 100.0);
  EXPECT_NEAR(noise.sigma_y_m, 1900.0, 50.0);
  EXPECT_NEAR(noise.sigma_z_m, 1900.0, 50.0);
}

}  // namespace
}  // namespace sarblock::leberl
