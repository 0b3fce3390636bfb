// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/statistics.h"

#include <cmath>

#include "simulate/places.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

SceneTerrain Relief(SceneTerrain::Kind kind) {
  SceneTerrain terrain;
  terrain.kind = kind;
  terrain.height_m = 412.5;
  terrain.relief_m = 83.0;
  terrain.correlation_m = 3700.0;
  return terrain;
}

constexpr int kDraws = 600;

TEST(TerrainTest, FlatGroundHasItsMeanHeightEverywhere) {
  const Terrain terrain(Relief(SceneTerrain::Kind::kFlat), 3);
  EXPECT_EQ(terrain.HeightAt({1234.5, -987.6}), 412.5);
}

TEST(TerrainTest, HasTheReliefAskedFor) {
  // Seeded statistics: one height a draw is close to normal (64 waves), so that the square sum in
  // reliefs follows chi-square with as many degrees as draws; acceptance 99.9 percent.
  for (const auto kind : {SceneTerrain::Kind::kRolling, SceneTerrain::Kind::kRugged}) {
    double square_sum = 0.0, sum = 0.0;
    for (int seed = 0; seed < kDraws; ++seed) {
      const Terrain terrain(Relief(kind), static_cast<std::uint64_t>(seed));
      const double z = (terrain.HeightAt({311.0, 7919.0}) - 412.5) / 83.0;
      square_sum += z * z;
      sum += z;
    }
    const Interval accepted = ChiSquareInterval(0.999, kDraws);
    EXPECT_TRUE(accepted.Contains(square_sum)) << square_sum;
    EXPECT_LT(std::abs(sum) / std::sqrt(kDraws), NormalQuantile(0.9995));
  }
}

TEST(TerrainTest, LosesItsCorrelationAtTheCorrelationLength) {
  // Closed form: exp(-(r/L)^2). Standard error of a product's mean: sqrt((1 + c^2)/n); 4 of them.
  for (const double part : {0.3, 1.0, 2.5}) {
    double sum = 0.0;
    for (int seed = 0; seed < kDraws; ++seed) {
      const Terrain terrain(Relief(SceneTerrain::Kind::kRolling), static_cast<std::uint64_t>(seed));
      const Eigen::Vector2d a(150.0, -40.0);
      const Eigen::Vector2d b = a + part * 3700.0 * Eigen::Vector2d(0.6, 0.8);
      sum += (terrain.HeightAt(a) - 412.5) * (terrain.HeightAt(b) - 412.5) / (83.0 * 83.0);
    }
    const double expected = std::exp(-part * part);
    const double error = std::sqrt((1.0 + expected * expected) / kDraws);
    EXPECT_NEAR(sum / kDraws, expected, 4.0 * error) << part;
  }
}

TEST(TerrainTest, RuggedGroundIsRougherThanRolling) {
  // Closed form: mean square slope of one octave is 2 relief^2/L^2 a direction; four octaves with
  // relief and L halved keep it per octave, weighted to a total relief: 4/1.328125 times as much.
  double rolling = 0.0, rugged = 0.0;
  for (int seed = 0; seed < kDraws; ++seed) {
    const auto s = static_cast<std::uint64_t>(seed);
    const Terrain smooth(Relief(SceneTerrain::Kind::kRolling), s);
    const Terrain rough(Relief(SceneTerrain::Kind::kRugged), s);
    rolling += std::pow(smooth.HeightAt({1.0, 5.0}) - smooth.HeightAt({0.0, 5.0}), 2);
    rugged += std::pow(rough.HeightAt({1.0, 5.0}) - rough.HeightAt({0.0, 5.0}), 2);
  }
  // Ratio of two chi-square means of 600: relative standard error about 8 percent.
  EXPECT_NEAR(rugged / rolling, 4.0 / 1.328125, 0.35 * 4.0 / 1.328125);
}

}  // namespace
}  // namespace sarblock
