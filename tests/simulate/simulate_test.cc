// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/simulate/scene.h"

#include <cmath>

#include "simulate/small_scene.h"
#include "simulate/true_path.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

TEST(SimulateTest, ReproducesHandComputedLooks) {
  // Hand values: flying along +x from x = -500 at 173 m/s, a point at x is seen at (x + 500)/173 s
  // from (x, 300 or 7600, 9100) at a plain distance.
  Scene scene = test::SmallScene();
  scene.looks.noise_scale = 0.0;
  const SimulatedBlock simulated = Simulate(scene);
  const Looks& looks = simulated.block.looks;
  ASSERT_EQ(looks.size(), 120u);
  for (std::size_t point = 0; point < 60; ++point) {
    const Eigen::Vector3d& p_m = simulated.truth.points_m[point];
    ASSERT_EQ(looks.offsets[point + 1] - looks.offsets[point], 2u);
    for (std::size_t k = 0; k < 2; ++k) {
      const std::size_t i = looks.offsets[point] + k;
      const double station_y_m = k == 0 ? 300.0 : 7600.0;
      EXPECT_EQ(looks.pass[i], k);
      EXPECT_NEAR(looks.time_s[i], (p_m.x() + 500.0) / 173.0, 1e-12);
      EXPECT_NEAR(looks.range_m[i], std::hypot(p_m.y() - station_y_m, 9100.0), 1e-9);
    }
  }
  EXPECT_EQ(simulated.block.passes[0].id, "A1");
  EXPECT_EQ(simulated.block.passes[0].start_s, 0.0);
  EXPECT_DOUBLE_EQ(simulated.block.passes[0].end_s, 21000.0 / 173.0);
}

TEST(SimulateTest, LooksToTheSideAskedFor) {
  Scene scene = test::SmallScene();
  scene.flights[0].side = LookSide::kRight;
  EXPECT_THROW((void)Simulate(scene), InputError);  // the area lies to the left
  scene.points.north_m = {-24900.0, -13100.0};
  scene.points.min_looks = 1;
  const SimulatedBlock simulated = Simulate(scene);
  EXPECT_EQ(
      simulated.block.looks.size(), 60u + [&] {
        std::size_t second = 0;  // the second station, at y = 7600, reaches down to y = -18400
        for (const auto& p_m : simulated.truth.points_m) second += p_m.y() >= 7600.0 - 26000.0;
        return second;
      }());
}

TEST(SimulateTest, PositiveSquintLooksForward) {
  Scene scene = test::SmallScene();
  scene.looks.noise_scale = 0.0;
  for (const double squint_rad : {0.2, -0.2}) {
    scene.flights[0].squint_rad = squint_rad;
    scene.flights[0].start_m.x() = -9000.0;
    scene.flights[0].length_m = 40000.0;
    const SimulatedBlock simulated = Simulate(scene);
    const Looks& looks = simulated.block.looks;
    const double antenna_x_m = -9000.0 + 173.0 * looks.time_s[0];
    const double ahead_m = simulated.truth.points_m[0].x() - antenna_x_m;
    EXPECT_NEAR(ahead_m, looks.range_m[0] * std::sin(squint_rad), 1e-6);  // closed form
    EXPECT_EQ(ahead_m > 0.0, squint_rad > 0.0);
    // Metres of azimuth are along track: a second of a straight flight is its speed at any squint.
    EXPECT_NEAR(simulated.exact.azimuth_rate_mps[0], 173.0, 1e-9);
  }
}

TEST(SimulateTest, WritesDopplerCentroids) {  // f = 2 v sin(tau)/lambda, closed form
  Scene scene = test::SmallScene();
  scene.flights[0].squint_rad = 0.03;
  scene.flights[0].wavelength_m = 0.0566;
  scene.looks.doppler = true;
  const SimulatedBlock simulated = Simulate(scene);
  ASSERT_FALSE(simulated.block.looks.cone.empty());
  EXPECT_NEAR(simulated.block.looks.cone[3], 2.0 * 173.0 * std::sin(0.03) / 0.0566, 1e-9);
  EXPECT_EQ(simulated.block.looks.flags[3], Looks::kDoppler);
}

TEST(SimulateTest, AddsNoiseToMeasuredDopplersAndLeavesTheirTimes) {
  Scene scene = test::SmallScene();
  scene.flights[0].squint_rad = 0.03;
  scene.flights[0].wavelength_m = 0.0566;
  scene.looks.doppler = true;
  scene.looks.azimuth = {kNotGiven, 2.3, AzimuthUnit::kHertz};
  SimulatedBlock simulated = Simulate(scene);
  const double exact_hz = 2.0 * 173.0 * std::sin(0.03) / 0.0566;  // closed form
  for (const std::uint64_t seed : {scene.seed, scene.seed + 1}) {
    Redraw(scene, seed, {.measurements = true, .navigation = false, .control = false}, &simulated);
    const Looks& looks = simulated.block.looks;
    double square = 0.0, count = 0.0;
    for (std::size_t i = 0; i < looks.size(); ++i) {
      EXPECT_TRUE(simulated.block.MeasuresDoppler(i));
      EXPECT_EQ(looks.time_s[i],
                simulated.exact.time_s[i] - simulated.errors[looks.pass[i]].time_bias_s);
      if (looks.pass[i] != 0) continue;
      const double deviation = (looks.cone[i] - exact_hz) / 2.3;
      square += deviation * deviation;
      count += 1.0;
    }
    EXPECT_TRUE(ChiSquareInterval(0.9999, count).Contains(square)) << square << " of " << count;
  }
}

TEST(SimulateTest, BoundsTheSwathByLookAngleAndSlantRangeToo) {
  // Over flat ground the three kinds describe the same strip: two routes.
  Scene scene = test::SmallScene();
  scene.points.min_looks = 1;
  scene.points.count = 500;
  scene.flights[0].swath.limits = {8100.0, 15300.0};
  const auto looks = [&] { return Simulate(scene).block.looks.pass; };
  const auto by_ground = looks();
  EXPECT_LT(by_ground.size(), 900u);
  EXPECT_GT(by_ground.size(), 100u);
  scene.flights[0].swath = {SwathKind::kLookAngle,
                            {std::atan2(8100.0, 9100.0), std::atan2(15300.0, 9100.0)}};
  EXPECT_EQ(looks(), by_ground);
  scene.flights[0].swath = {SwathKind::kSlantRange,
                            {std::hypot(8100.0, 9100.0), std::hypot(15300.0, 9100.0)}};
  EXPECT_EQ(looks(), by_ground);
}

TEST(SimulateTest, TruePathIsTheNominalPathPlusTheErrorsInTrackAxes) {
  // Hand values: in Leberl's frame along, across, up are x, y, z.
  Scene scene = test::SmallScene();
  scene.navigation.constant_sigma_m = {3.0, 5.0, 7.0};
  scene.navigation.drift_sigma_m = {2.0, 4.0, 6.0};
  scene.navigation.curvature_sigma_m = {9.0, 1.0, 8.0};
  const SimulatedBlock simulated = Simulate(scene);
  const Pass& pass = simulated.block.passes[1];
  const PassError& error = simulated.errors[1];
  const double t_s = 31.7;
  const double x = 2.0 * t_s / (21000.0 / 173.0) - 1.0;
  const auto truth = simulated.truth.paths[1].At(t_s);
  const auto nominal = pass.path.At(t_s);
  ASSERT_TRUE(truth && nominal);
  const Eigen::Vector3d shift_m = truth->position_m - nominal->position_m;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    EXPECT_NEAR(shift_m[axis],
                error.constant_m[i] + x * error.drift_m[i] +
                    (3.0 * x * x - 1.0) / 2.0 * error.curvature_m[i],
                1e-9);
    EXPECT_NEAR(truth->velocity_mps[axis] - nominal->velocity_mps[axis],
                (error.drift_m[i] + 3.0 * x * error.curvature_m[i]) * 2.0 * 173.0 / 21000.0,
                1e-11);
  }
}

TEST(SimulateTest, TrueVelocityIsTheDerivativeOfTheTruePath) {
  // Numerical route: central differences over 2 ms of a spline error with a knot every 9 s.
  Scene scene = test::SmallScene();
  scene.navigation.process = SceneNavigation::Process::kGaussMarkov;
  scene.navigation.process_sigma_m = {8.0, 12.0, 5.0};
  scene.navigation.correlation_time_s = 25.0;
  scene.navigation.knot_spacing_s = 9.0;
  const SimulatedBlock simulated = Simulate(scene);
  const TruePath path(simulated.block.frame, simulated.block.passes[0], simulated.errors[0], 9.0);
  const double h_s = 1e-3;
  const auto before = path.At(40.37 - h_s), at = path.At(40.37), after = path.At(40.37 + h_s);
  ASSERT_TRUE(before && at && after);
  // Positions of 1e4 m round at 2e-12 m, which 2 ms turn into 1e-9 m/s.
  EXPECT_LT(((after->position_m - before->position_m) / (2 * h_s) - at->velocity_mps).norm(), 1e-8);
  EXPECT_LT(
      ((after->velocity_mps - before->velocity_mps) / (2 * h_s) - at->acceleration_mps2).norm(),
      1e-8);
  EXPECT_GT(at->acceleration_mps2.norm(), 1e-4);
}

TEST(SimulateTest, ProcessesHaveTheirVariances) {
  // Seeded statistics of 400 passes: the first coefficient of Gauss-Markov is stationary, the last
  // one of a random walk has reached its sigma, neighbours correlate as exp(-h/T).
  Scene scene = test::SmallScene();
  SceneNavigation& navigation = scene.navigation;
  navigation.process = SceneNavigation::Process::kGaussMarkov;
  navigation.process_sigma_m = {2.0, 2.0, 2.0};
  navigation.correlation_time_s = 30.0;
  navigation.knot_spacing_s = 12.2;
  const Pass pass = Simulate(test::SmallScene()).block.passes[0];
  const UniformSpline spline(pass.start_s, pass.end_s, navigation.knot_spacing_s);
  constexpr int kDraws = 400;
  double first = 0.0, last = 0.0, product = 0.0, walk_last = 0.0, walk_first = 0.0;
  for (std::uint64_t seed = 0; seed < kDraws; ++seed) {
    const auto c = DrawPassError(navigation, Frame::Local(), pass, 0, seed).spline_m[1];
    ASSERT_EQ(c.size(), spline.count());
    first += c.front() * c.front() / 4.0;
    last += c.back() * c.back() / 4.0;
    product += c[3] * c[4] / 4.0;
    SceneNavigation walk = navigation;
    walk.process = SceneNavigation::Process::kRandomWalk;
    const auto w = DrawPassError(walk, Frame::Local(), pass, 0, seed).spline_m[1];
    walk_first += std::abs(w.front());
    walk_last += w.back() * w.back() / 4.0;
  }
  const Interval accepted = ChiSquareInterval(0.999, kDraws);
  EXPECT_TRUE(accepted.Contains(first)) << first;
  EXPECT_TRUE(accepted.Contains(last)) << last;
  EXPECT_TRUE(accepted.Contains(walk_last)) << walk_last;
  EXPECT_EQ(walk_first, 0.0);
  const double phi = std::exp(-spline.spacing_s() / 30.0);
  EXPECT_NEAR(product / kDraws, phi, 4.0 * std::sqrt((1.0 + phi * phi) / kDraws));
}

}  // namespace
}  // namespace sarblock
