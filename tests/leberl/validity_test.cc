// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <cmath>

#include "leberl/rigorous.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

const ValidityCase kCase{.source = ValiditySource::kAcrossPosition,
                         .look_rad = 50.0 * kRadPerDeg,
                         .base_ratio = 0.4,
                         .terrain_ratio = 0.0};

TEST(LeberlValidityTest, GrowsInProportionToTheErrorOnTheDatum) {  // second order over first
  const auto small = RelativeDifference(kCase, 1e-6);
  const auto twice = RelativeDifference(kCase, 2e-6);
  ASSERT_TRUE(small && twice);
  EXPECT_NEAR(*twice / *small, 2.0, 1e-3);
}

TEST(LeberlValidityTest, LineHasItsLevel) {  // round trip through the map's own figure
  for (const double level : {0.01, 0.05, 0.20}) {
    const auto ratio = ErrorRatioAtLevel(kCase, level);
    ASSERT_TRUE(ratio);
    EXPECT_NEAR(*RelativeDifference(kCase, *ratio), level, 1e-5 * level);
  }
}

// Closed form: at (y, z) with an infinitesimal dy0'' the exact effect is dy = dy0'' (B - y)/B and
// dz = dy y/(H - z); the formula has H for H - z.
TEST(LeberlValidityTest, KeepsTheTerrainTermForASmallError) {
  ValidityCase raised = kCase;
  raised.terrain_ratio = 0.02;
  const double tangent = std::tan(kCase.look_rad);
  const double expected = tangent * (1.0 / 0.98 - 1.0) / std::hypot(1.0, tangent / 0.98);
  const auto difference = RelativeDifference(raised, 1e-7);
  ASSERT_TRUE(difference);
  EXPECT_NEAR(*difference, expected, 1e-5);
  EXPECT_EQ(ErrorRatioAtLevel(raised, 0.01), 0.0);
  EXPECT_GT(ErrorRatioAtLevel(raised, 0.05).value(), 0.0);
}

TEST(LeberlValidityTest, HasNoGeometryOnTheWrongSide) {
  ValidityCase inside = kCase;
  inside.look_rad = 10.0 * kRadPerDeg;  // y = 0.18 H lies between the stations
  EXPECT_FALSE(RelativeDifference(inside, 1e-4));
  inside.arrangement = leberl::Arrangement::kOppositeSide;
  EXPECT_TRUE(RelativeDifference(inside, 1e-4));
}

TEST(LeberlValidityTest, MapAndLinesCoverTheGrid) {
  const ValidityOptions options{.look_deg = {30, 50},
                                .base_ratio = {0.1},
                                .terrain_ratio = {0.0, 0.01},
                                .error_ratio = {1e-5, 1e-4, 1e-3}};
  EXPECT_EQ(ValidityMap(options).size(), 36u);  // 3 sources, 2 looks, 2 heights, 3 sizes
  EXPECT_EQ(ValidityLines(options).size(), 12u);
  for (const ValidityLine& line : ValidityLines(options)) {
    ASSERT_TRUE(line.error_ratio_1_percent && line.error_ratio_5_percent);
    EXPECT_LE(*line.error_ratio_1_percent, *line.error_ratio_5_percent);
  }
}

}  // namespace
}  // namespace sarblock
