// SPDX-License-Identifier: Apache-2.0
#include "sarblock/block/block.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "simulate/scene.h"
#include "simulate/small_scene.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr double kRad = std::numbers::pi / 180.0;

SceneImage ImageOf(double snr_db) {
  SceneImage image;
  image.bandwidth_hz = 149896229.0;  // a resolution of exactly 1 m
  image.azimuth_resolution_m = 3.0;
  image.snr_db = snr_db;
  return image;
}

ImageView ViewAt(double incidence_deg, double side = 1.0) {
  return {incidence_deg * kRad, {side / std::tan(incidence_deg * kRad), 0.0}};
}

// Published: Eineder et al. (2011) give 0.39 resolutions over the root of the signal to clutter.
TEST(ImageSigmaTest, OfAReflectorIsTheBoundOfItsPeak) {
  const ImageSigma sigma = SigmaOfMatch(ImageOf(30.0), ViewAt(40.0), ViewAt(25.0));
  EXPECT_NEAR(sigma.range_m, 0.39 / std::sqrt(1000.0), 1e-4);
  EXPECT_NEAR(sigma.azimuth_m, 3.0 * sigma.range_m, 1e-12);
}

// Hand arithmetic: a window of 30 m at 30 degrees has 900 * 0.5 / 3 = 150 cells; correlation 0.8
// and no noise to speak of: sqrt(1.5 / 150) * 0.6 / (pi 0.8), of which a look has
// 1/sqrt(2).
TEST(ImageSigmaTest, OfMatchedGroundIsThatOfItsCellsAndCorrelation) {
  SceneImage image = ImageOf(90.0);
  image.window_m = 30.0;
  image.correlation = 0.8;
  const ImageSigma sigma = SigmaOfMatch(image, ViewAt(30.0), ViewAt(30.0));
  EXPECT_NEAR(sigma.range_m,
              std::sqrt(1.5 / 150.0) * 0.6 / (std::numbers::pi * 0.8) / std::sqrt(2.0),
              1e-6);
  EXPECT_NEAR(sigma.azimuth_m, 3.0 * sigma.range_m, 1e-12);
}

// Hand arithmetic: a signal as strong as the noise in both images halves the correlation.
TEST(ImageSigmaTest, NoiseLowersTheCorrelation) {
  SceneImage clear = ImageOf(90.0), noisy = ImageOf(0.0);
  for (SceneImage* image : {&clear, &noisy}) {
    image->window_m = 30.0;
    image->snr_incidence_rad = 30.0 * kRad;
  }
  clear.correlation = 0.4;
  noisy.correlation = 0.8;
  const ImageView view = ViewAt(30.0);
  EXPECT_NEAR(
      SigmaOfMatch(noisy, view, view).range_m, SigmaOfMatch(clear, view, view).range_m, 1e-6);
  // Lambert's law: at 60 degrees the signal is (1/2)^2 / (3/4) = 1/3 of that at 30 degrees, and the
  // correlation 0.8 / (1 + 3) = 0.2 in place of 0.4; the window has sqrt(3) times the cells.
  clear.correlation = 0.2;
  EXPECT_NEAR(SigmaOfMatch(noisy, ViewAt(60.0), ViewAt(60.0)).range_m,
              SigmaOfMatch(clear, view, view).range_m / std::pow(3.0, 0.25),
              1e-6);
}

/// Sigma of a height from two looks (docs/planning.md, eq. (3)).
double SigmaUp(const SceneImage& image, double first_deg, double second_deg) {
  const ImageView first = ViewAt(first_deg), second = ViewAt(second_deg);
  const double r1_m = SigmaOfMatch(image, first, second).range_m;
  const double r2_m = SigmaOfMatch(image, second, first).range_m;
  const double i1 = first_deg * kRad, i2 = second_deg * kRad;
  return std::hypot(r1_m * std::sin(i2), r2_m * std::sin(i1)) / std::abs(std::sin(i1 - i2));
}

// Relief limits heights: from some angle on a wider intersection gains nothing, and there is a best
// one. Without relief and noise it gains all the way.
TEST(ImageSigmaTest, ReliefAndNoiseMakeAnAngleTheBest) {
  SceneImage image = ImageOf(10.0);
  image.window_m = 30.0;
  image.slope_rms = 0.1;
  std::vector<double> up_m;
  for (double second_deg = 24.0; second_deg < 89.0; second_deg += 1.0) {
    up_m.push_back(SigmaUp(image, 23.0, second_deg));
  }
  const auto best = std::min_element(up_m.begin(), up_m.end());
  EXPECT_GT(best - up_m.begin(), 3);
  EXPECT_LT(best - up_m.begin(), 40);
  EXPECT_GT(up_m.back(), 3.0 * *best);
  image.slope_rms = 0.0;
  image.backscatter_exponent = 0.0;
  EXPECT_LT(SigmaUp(image, 23.0, 60.0), SigmaUp(image, 23.0, 45.0));
  EXPECT_LT(SigmaUp(image, 23.0, 45.0), SigmaUp(image, 23.0, 30.0));
}

TEST(ImageSigmaTest, AViewIsThatOfTheGroundAndTheAntenna) {
  const Frame frame = Frame::Local();
  // From 3 m west and 4 m above: 36.87 degrees; the ground rises 20 degrees towards the east, so it
  // faces the antenna and is seen at 16.87.
  const double slope = std::tan(20.0 * kRad);
  const ImageView view =
      ViewOf(frame, {1.0, 2.0, 3.0}, {-slope, 0.0, 1.0}, {1.0 - 3.0, 2.0, 3.0 + 4.0});
  EXPECT_NEAR(view.local_incidence_rad / kRad, std::atan2(3.0, 4.0) / kRad - 20.0, 1e-9);
  EXPECT_NEAR(view.parallax.x(), 4.0 / 3.0, 1e-12);
  EXPECT_NEAR(view.parallax.y(), 0.0, 1e-12);
}

// The looks of a scene carry what its image gives them, and their noise is of that size.
TEST(ImageSigmaTest, LooksOfASceneHaveTheirOwn) {
  Scene scene = test::SmallScene();
  SceneImage image = ImageOf(12.0);
  image.window_m = 40.0;
  image.slope_rms = 0.05;
  scene.looks.image = image;
  scene.looks.range_sigma_m = kNotGiven;
  scene.looks.azimuth = {};
  scene.points.count = 400;
  const SimulatedBlock simulated = Simulate(scene);
  const Block& block = simulated.block;
  ASSERT_EQ(block.looks.range_sigma_m.size(), block.looks.size());
  double squares = 0.0, least_m = 1e9, most_m = 0.0;
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    const double sigma_m = block.SigmaOf(i).range_m;
    const PassError& error = simulated.errors[block.looks.pass[i]];
    const double noise_m = block.looks.range_m[i] - error.range_bias_m -
                           (1.0 + error.range_scale) * simulated.exact.range_m[i];
    squares += std::pow(noise_m / sigma_m, 2.0);
    least_m = std::min(least_m, sigma_m);
    most_m = std::max(most_m, sigma_m);
  }
  const auto n = static_cast<double>(block.looks.size());
  EXPECT_NEAR(squares / n, 1.0, 4.0 * std::sqrt(2.0 / n));
  EXPECT_GT(most_m, 1.02 * least_m);
}

TEST(ImageSigmaTest, RefusesWhatIsNoImage) {
  const auto problem = [](auto&& change) {
    Scene scene = test::SmallScene();
    scene.looks.image = ImageOf(10.0);
    scene.looks.range_sigma_m = kNotGiven;
    scene.looks.azimuth = {};
    change(&scene);
    const auto found = FindProblem(scene);
    return found ? found->field : std::string("none");
  };
  EXPECT_EQ(problem([](Scene*) {}), "none");
  EXPECT_EQ(problem([](Scene* s) { s->looks.image->bandwidth_hz = 0.0; }),
            "looks.image.bandwidth_mhz");
  EXPECT_EQ(problem([](Scene* s) { s->looks.image->snr_db = kNotGiven; }), "looks.image.snr_db");
  EXPECT_EQ(problem([](Scene* s) { s->looks.image->correlation = 1.0; }),
            "looks.image.correlation");
  EXPECT_EQ(problem([](Scene* s) { s->looks.image->window_m = -3.0; }), "looks.image.window_m");
  EXPECT_EQ(problem([](Scene* s) { s->looks.range_sigma_m = 1.0; }), "looks.image");
  EXPECT_EQ(problem([](Scene* s) { s->flights[0].range_sigma_m = 1.0; }), "flight.0.range_sigma_m");
}

}  // namespace
}  // namespace sarblock
