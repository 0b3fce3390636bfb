// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/statistics.h"
#include "sarblock/simulate/scene.h"

#include <cmath>
#include <cstring>
#include <vector>

#include "simulate/small_scene.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

Scene ErrorScene() {
  Scene scene = test::SmallScene();
  scene.navigation.constant_sigma_m = {11.0, 23.0, 7.0};
  scene.navigation.drift_sigma_m = {3.0, 5.0, 2.0};
  scene.navigation.range_bias_sigma_m = 1.9;
  scene.navigation.time_bias_sigma_s = 0.003;
  scene.control.layout = SceneControl::Layout::kCorners;
  scene.control.sigma_m = {0.4, 0.5, 0.6};
  return scene;
}

/// Bytes, so that NaN and the sign of zero count too.
bool SameBytes(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}
bool SameLooks(const SimulatedBlock& a, const SimulatedBlock& b) {
  return SameBytes(a.block.looks.time_s, b.block.looks.time_s) &&
         SameBytes(a.block.looks.range_m, b.block.looks.range_m);
}

TEST(RedrawTest, SameSeedGivesTheSameBytes) {  // invariance
  const Scene scene = ErrorScene();
  const SimulatedBlock a = Simulate(scene), b = Simulate(scene);
  EXPECT_TRUE(SameLooks(a, b));
  ASSERT_EQ(a.block.points.size(), b.block.points.size());
  for (std::size_t i = 0; i < a.block.points.size(); ++i) {
    EXPECT_EQ(a.truth.points_m[i], b.truth.points_m[i]);
  }
}

TEST(RedrawTest, AnotherSceneSeedChangesEverythingRandom) {
  Scene scene = ErrorScene();
  const SimulatedBlock a = Simulate(scene);
  scene.seed += 1;
  const SimulatedBlock b = Simulate(scene);
  EXPECT_FALSE(SameLooks(a, b));
  EXPECT_NE(a.truth.points_m.back(), b.truth.points_m.back());
  EXPECT_NE(a.errors[0].constant_m, b.errors[0].constant_m);
  EXPECT_NE(a.errors[0].constant_m, a.errors[1].constant_m);
  EXPECT_NE(a.block.points.given_m[0], b.block.points.given_m[0]);
}

TEST(RedrawTest, DoesNotDependOnEarlierDraws) {  // round trip
  const Scene scene = ErrorScene();
  const SimulatedBlock first = Simulate(scene);
  SimulatedBlock again = first;
  Redraw(scene, 991, {}, &again);
  EXPECT_FALSE(SameLooks(first, again));
  Redraw(scene, scene.seed, {}, &again);
  EXPECT_TRUE(SameLooks(first, again));
  EXPECT_EQ(first.block.points.given_m[0], again.block.points.given_m[0]);
}

TEST(RedrawTest, ChangesOnlyWhatIsChosen) {
  const Scene scene = ErrorScene();
  const SimulatedBlock first = Simulate(scene);
  SimulatedBlock other = first;
  Redraw(scene, 5, {.measurements = true, .navigation = false, .control = false}, &other);
  EXPECT_FALSE(SameLooks(first, other));
  EXPECT_TRUE(SameBytes(first.exact.range_m, other.exact.range_m));
  EXPECT_EQ(first.block.points.given_m[0], other.block.points.given_m[0]);

  other = first;
  Redraw(scene, 5, {.measurements = false, .navigation = true, .control = false}, &other);
  EXPECT_NE(first.errors[0].constant_m, other.errors[0].constant_m);
  EXPECT_FALSE(SameBytes(first.exact.range_m, other.exact.range_m));
  for (std::size_t i = 0; i < first.exact.range_m.size(); ++i) {  // the noise itself has stayed
    const std::uint32_t pass = first.block.looks.pass[i];
    const auto noise = [&](const SimulatedBlock& s) {
      return s.block.looks.range_m[i] - s.exact.range_m[i] - s.errors[pass].range_bias_m;
    };
    EXPECT_NEAR(noise(first), noise(other), 1e-10);  // rounding of 3e4 m
  }

  other = first;
  Redraw(scene, 5, {.measurements = false, .navigation = false, .control = true}, &other);
  EXPECT_TRUE(SameLooks(first, other));
  EXPECT_NE(first.block.points.given_m[0], other.block.points.given_m[0]);
}

TEST(RedrawTest, NoiseHasTheStatedStandardDeviations) {
  // Seeded statistics: square sums of normalised noise follow chi-square; acceptance 99.9 percent.
  Scene scene = ErrorScene();
  scene.points.count = 400;
  SimulatedBlock simulated = Simulate(scene);
  double time_sum = 0.0, range_sum = 0.0, product = 0.0;
  double n = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Redraw(scene, seed, {.navigation = false}, &simulated);
    for (std::size_t i = 0; i < simulated.block.looks.size(); ++i) {
      const PassError& error = simulated.errors[simulated.block.looks.pass[i]];
      const double t =
          (simulated.block.looks.time_s[i] + error.time_bias_s - simulated.exact.time_s[i]) *
          173.0 / 1.3;  // straight level flight: |de_d/dt| is the speed
      const double r =
          (simulated.block.looks.range_m[i] - error.range_bias_m - simulated.exact.range_m[i]) /
          0.7;
      time_sum += t * t;
      range_sum += r * r;
      product += t * r;
      n += 1.0;
    }
  }
  ASSERT_GT(n, 3000.0);
  // The speed on the true path differs from 173 m/s by 2 c_along/T: below 1e-3, 2e-3 in the square.
  const Interval accepted = ChiSquareInterval(0.999, n);
  EXPECT_TRUE(accepted.Contains(time_sum)) << time_sum << " of " << n;
  EXPECT_TRUE(accepted.Contains(range_sum)) << range_sum << " of " << n;
  EXPECT_LT(std::abs(product) / std::sqrt(n), NormalQuantile(0.9995));
}

TEST(RedrawTest, PassAndControlErrorsHaveTheStatedStandardDeviations) {  // as above
  const Scene scene = ErrorScene();
  SimulatedBlock simulated = Simulate(scene);
  constexpr int kDraws = 200;
  std::array<double, 3> constant{}, drift{}, control{};
  double bias = 0.0;
  for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
    Redraw(scene, seed, {.measurements = false}, &simulated);
    for (const PassError& error : simulated.errors) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        constant[axis] +=
            std::pow(error.constant_m[axis] / scene.navigation.constant_sigma_m[axis], 2);
        drift[axis] += std::pow(error.drift_m[axis] / scene.navigation.drift_sigma_m[axis], 2);
      }
      bias += std::pow(error.range_bias_m / 1.9, 2);
    }
    for (const KnownPosition& known : simulated.block.points.known) {
      const Eigen::Vector3d error_m =
          simulated.block.points.given_m[known.point] - simulated.truth.points_m[known.point];
      for (int axis = 0; axis < 3; ++axis) {
        control[static_cast<std::size_t>(axis)] +=
            error_m[axis] * error_m[axis] / known.covariance_enu_m2(axis, axis);
      }
    }
  }
  const Interval passes = ChiSquareInterval(0.9999, 2 * kDraws);
  const Interval points = ChiSquareInterval(0.9999, 4 * kDraws);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_TRUE(passes.Contains(constant[axis])) << constant[axis];
    EXPECT_TRUE(passes.Contains(drift[axis])) << drift[axis];
    EXPECT_TRUE(points.Contains(control[axis])) << control[axis];
  }
  EXPECT_TRUE(passes.Contains(bias)) << bias;
}

TEST(RedrawTest, BiasesEnterWithTheSignsOfTheModel) {
  // Second route: the observation equations of model.md, section 4, with the drawn corrections.
  Scene scene = ErrorScene();
  scene.flights[0].squint_rad = 0.11;
  scene.flights[0].length_m = 40000.0;
  scene.flights[0].start_m.x() = -9000.0;
  scene.looks.noise_scale = 0.0;
  scene.navigation.squint_bias_sigma_rad = 2e-3;
  scene.navigation.range_scale_sigma = 3e-5;
  const SimulatedBlock simulated = Simulate(scene);
  const Looks& looks = simulated.block.looks;
  ASSERT_GT(looks.size(), 80u);
  for (std::size_t point = 0; point < simulated.block.points.size(); ++point) {
    for (auto i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      const PassError& error = simulated.errors[looks.pass[i]];
      const auto motion =
          simulated.truth.paths[looks.pass[i]].At(looks.time_s[i] + error.time_bias_s);
      ASSERT_TRUE(motion.has_value());
      const Eigen::Vector3d d = simulated.truth.points_m[point] - motion->position_m;
      const double rho = d.norm();
      // Hermite of the true states is exact here: straight paths, linear errors. 1e-6 m in cone.
      EXPECT_NEAR(rho + error.range_bias_m + error.range_scale * rho, looks.range_m[i], 1e-6);
      EXPECT_NEAR(motion->velocity_mps.normalized().dot(d),
                  rho * std::sin(looks.cone[i] + error.squint_bias_rad),
                  1e-6);
      EXPECT_EQ(looks.cone[i], 0.11);
    }
  }
}

TEST(RedrawTest, AddsTheFractionOfBlundersAskedFor) {
  Scene scene = test::SmallScene();
  scene.points.count = 1000;
  scene.looks.blunder_fraction = 0.07;
  scene.looks.blunder_size = 40.0;
  const SimulatedBlock simulated = Simulate(scene);
  double blunders = 0.0;
  for (std::size_t i = 0; i < simulated.blunder.size(); ++i) {
    const double r = std::abs(simulated.block.looks.range_m[i] - simulated.exact.range_m[i]) / 0.7;
    EXPECT_EQ(r > 20.0, simulated.blunder[i] == 1) << r;  // noise stays far below 20 sigmas
    blunders += simulated.blunder[i];
  }
  const double n = static_cast<double>(simulated.blunder.size());
  EXPECT_NEAR(blunders / n, 0.07, 4.0 * std::sqrt(0.07 * 0.93 / n));  // binomial
}

}  // namespace
}  // namespace sarblock
