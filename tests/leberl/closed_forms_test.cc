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
  EXPECT_NEAR(AbsoluteParallax(kHand, Presentation::kSlantRange), 7.0, kRounding);  // 20 - 13
  EXPECT_NEAR(AbsoluteParallax(kHandOpposite, Presentation::kSlantRange), 7.0, kRounding);
}

TEST(ParallaxTest, IsTheBaseEverywhereInGroundRange) {  // y - (y - B) = B
  StereoConfiguration moved = kHand;
  double slant_before_m = 0.0;
  for (const double y_m : {11.3, 16.0, 41.7}) {
    moved.ground_range_m = y_m;
    EXPECT_EQ(AbsoluteParallax(moved, Presentation::kGroundRange), 11.0);
    const double slant_m = AbsoluteParallax(moved, Presentation::kSlantRange);
    EXPECT_GT(slant_m, slant_before_m + 0.1);  // a cylinder, not a plane
    slant_before_m = slant_m;
  }
  EXPECT_EQ(AbsoluteParallax(kHandOpposite, Presentation::kGroundRange), 21.0);
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
  // Bc = H (12/5 - 3/4) = 12 * 1.65
  EXPECT_NEAR(EquivalentBase(Exaggeration(kHand), 12.0), 19.8, 1e-13);
}

constexpr StereoViewing kViewing{
    .scale = 73e3, .eye_base_m = 0.064, .acuity_rad = 1.1e-4, .fusion_rad = 0.019};

// An independent route: the angle between the lines from both eyes to a point, by vectors. The eyes
// lie at +-e/2, the model plane 5 e before them, the raised point q h/M nearer.
TEST(RetinalDisparityTest, IsTheDifferenceOfTheAnglesAtBothEyes) {
  const double e = kViewing.eye_base_m, q = 1.93;
  const auto convergence = [&](double distance_m) {  // cos of the angle of (+-e/2, distance)
    const double square = distance_m * distance_m;
    return std::acos((square - 0.25 * e * e) / (square + 0.25 * e * e));
  };
  for (const double height_m : {-2100.0, 35.0, 2800.0}) {
    const double raised_m = q * height_m / kViewing.scale;
    EXPECT_NEAR(RetinalDisparity(q, height_m, kViewing),
                convergence(5.0 * e - raised_m) - convergence(5.0 * e),
                1e-13);
    EXPECT_NEAR(
        HeightOfDisparity(q, RetinalDisparity(q, height_m, kViewing), kViewing), height_m, 1e-8);
  }
  // first order: d = q h/(M e (25 + 1/4)), so twice the exaggeration shows half the height
  const double least_m = HeightOfDisparity(q, kViewing.acuity_rad, kViewing);
  EXPECT_NEAR(least_m, kViewing.acuity_rad * 25.25 * kViewing.scale * e / q, 1e-3 * least_m);
  EXPECT_NEAR(HeightOfDisparity(2.0 * q, kViewing.acuity_rad, kViewing), 0.5 * least_m, 1e-12);
}

TEST(RetinalDisparityTest, RefusesLimitsOutOfOrder) {
  EXPECT_NO_THROW(Validate(kViewing));
  StereoViewing bad = kViewing;
  bad.fusion_rad = 1e-4;  // below the acuity
  EXPECT_THROW(Validate(bad), InputError);
  bad.fusion_rad = 0.21;  // the eyes would have to turn outwards
  EXPECT_THROW(Validate(bad), InputError);
  for (double StereoViewing::*const member :
       {&StereoViewing::scale, &StereoViewing::eye_base_m, &StereoViewing::acuity_rad}) {
    bad = kViewing;
    bad.*member = 0.0;
    EXPECT_THROW(Validate(bad), InputError);
  }
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

// Hand: one scale e in both images gives A = 2 e, F = 0, C = e (2 y - B)/H and
// D = e (1 + y (y - B)/H^2), here e (2, 0, 21/12, 1 + 80/144).
TEST(RangeWarpTest, OfACommonScaleEqualsHandValues) {
  const Warp warp = RangeScaleWarp(kHand, 3e-3, 3e-3);
  EXPECT_NEAR(warp.a, 6e-3, kRounding);
  EXPECT_NEAR(warp.f, 0.0, kRounding);
  EXPECT_NEAR(warp.c, 3e-3 * 21.0 / 12.0, kRounding);
  EXPECT_NEAR(warp.d, 3e-3 * (1.0 + 80.0 / 144.0), kRounding);
}

// Differences of Eq. 14 and 15 with dr = e r, by y, and by z where H - z stands for H.
TEST(RangeWarpTest, OfScalesIsTheSlopeOfEq14And15) {
  constexpr double kStep_m = 1e-4;
  for (const StereoConfiguration& c : {kHand, kHandOpposite}) {
    for (const StereoErrors& errors :
         {First({.range_scale = 2e-3}), Second({.range_scale = 2e-3})}) {
      const auto slope = [&](double StereoConfiguration::*of, double sign, auto error) {
        StereoConfiguration above = c, below = c;
        above.*of += sign * kStep_m;
        below.*of -= sign * kStep_m;
        return (error(above, errors) - error(below, errors)) / (2.0 * kStep_m);
      };
      const Warp warp = RangeScaleWarp(c, errors.first.range_scale, errors.second.range_scale);
      EXPECT_NEAR(warp.a, slope(&StereoConfiguration::ground_range_m, 1.0, AcrossError), 1e-9);
      EXPECT_NEAR(warp.f, slope(&StereoConfiguration::height_m, -1.0, AcrossError), 1e-9);
      EXPECT_NEAR(warp.c, slope(&StereoConfiguration::ground_range_m, 1.0, HeightError), 1e-9);
      EXPECT_NEAR(warp.d, slope(&StereoConfiguration::height_m, -1.0, HeightError), 1e-9);
    }
  }
}

// The paper's example: aircraft, centre, dB = 100 m, Dy = Dz = 1 km; hand: -100/8 and
// 100 (8 - 38)/80 -/+ ... = -37.5 + 26.125 = -11.375 as printed, -37.5 - 26.125 as derived.
TEST(RelativeErrorsTest, SumToTheQuotedExample) {
  const StereoConfiguration c{.base_m = 8e3, .height_m = 10e3, .ground_range_m = 19e3};
  const StereoErrors errors = Second({.dy0_m = 100.0});
  const Difference printed = DifferenceErrors(c, errors, {1e3, 1e3}, Signs::kPrinted);
  EXPECT_NEAR(printed.dy_m, -12.5, 1e-12);
  EXPECT_NEAR(printed.dz_m, -11.375, 1e-12);
  EXPECT_NEAR(DifferenceErrors(c, errors, {1e3, 1e3}, Signs::kDerived).dz_m, -63.625, 1e-12);
  // as printed a scale is the constant dr = e r of the point: here 5e-4 20 km and 5e-4 13 km
  const StereoConfiguration kilometres{.base_m = 11e3, .height_m = 12e3, .ground_range_m = 16e3};
  const Difference as_scale =
      DifferenceErrors(kilometres,
                       {.first = {.range_scale = 5e-4}, .second = {.range_scale = 5e-4}},
                       {700.0, 300.0},
                       Signs::kPrinted);
  const Difference as_constant =
      DifferenceErrors(kilometres,
                       {.first = {.dr_m = 10.0}, .second = {.dr_m = 6.5}},
                       {700.0, 300.0},
                       Signs::kPrinted);
  EXPECT_NEAR(as_scale.dy_m, as_constant.dy_m, 1e-12);
  EXPECT_NEAR(as_scale.dz_m, as_constant.dz_m, 1e-12);
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
