// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/statistics.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "simulate/true_path.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr double kRms_m = 5.3;
constexpr double kTime_s = 7.4;
constexpr double kStart_s = 211.0;

SmoothCurve Drawn(std::uint64_t seed, double from_s = 180.0, double to_s = 260.0) {
  return DrawGaussMarkov(kRms_m, kTime_s, kStart_s, from_s, to_s, seed, 17);
}

TEST(GaussMarkovTest, HasItsRmsInPositionVelocityAndAcceleration) {
  // Seeded statistics over 1500 draws, 99.9 percent each: closed forms s, s/(sqrt(3) T), s/T^2.
  constexpr int kSeeds = 1500;
  const std::array<double, 3> sigma = {
      kRms_m, kRms_m / (std::sqrt(3.0) * kTime_s), kRms_m / (kTime_s * kTime_s)};
  const Interval accepted = ChiSquareInterval(0.999, kSeeds);
  const double step_s = kTime_s / 64.0;
  for (const double time_s : {kStart_s - 250.0 * step_s, kStart_s, kStart_s + 31.0 * step_s}) {
    std::array<double, 3> square{};
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      const std::array<double, 4> value = Drawn(seed).At(time_s);
      for (std::size_t i = 0; i < 3; ++i) square[i] += std::pow(value[i] / sigma[i], 2);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_TRUE(accepted.Contains(square[i])) << i << " at " << time_s << ": " << square[i];
    }
  }
}

TEST(GaussMarkovTest, FollowsItsAutocorrelation) {
  // Closed forms, x = tau/T: (1 + x + x^2/3) exp(-x) of positions, (1 + x - x^2) exp(-x) of
  // velocities; across the start, where the two directions meet. Four standard errors.
  constexpr int kSeeds = 2000;
  for (const double x : {0.31, 1.4, 3.0}) {
    const double first_s = kStart_s - 0.4 * x * kTime_s;
    double positions = 0.0, velocities = 0.0, crossed = 0.0;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      const SmoothCurve curve = Drawn(seed);
      const std::array<double, 4> a = curve.At(first_s), b = curve.At(first_s + x * kTime_s);
      positions += a[0] * b[0] / (kRms_m * kRms_m);
      velocities += a[1] * b[1] * 3.0 * std::pow(kTime_s / kRms_m, 2);
      crossed += a[0] * a[1] * std::sqrt(3.0) * kTime_s / (kRms_m * kRms_m);
    }
    const double of_positions = (1.0 + x + x * x / 3.0) * std::exp(-x);
    const double of_velocities = (1.0 + x - x * x) * std::exp(-x);
    const auto error = [&](double r) { return 4.0 * std::sqrt((1.0 + r * r) / kSeeds); };
    EXPECT_NEAR(positions / kSeeds, of_positions, error(of_positions)) << x;
    EXPECT_NEAR(velocities / kSeeds, of_velocities, error(of_velocities)) << x;
    EXPECT_NEAR(crossed / kSeeds, 0.0, error(0.0)) << x;
  }
}

TEST(GaussMarkovTest, ALongerSpanContinuesAShorterOne) {
  const SmoothCurve shorter = Drawn(5, 205.0, 216.0), longer = Drawn(5);
  for (const double time_s : {205.1, 210.99, 211.0, 213.7, 215.99}) {
    EXPECT_EQ(shorter.At(time_s), longer.At(time_s)) << time_s;
  }
  EXPECT_LE(shorter.nodes().front().time_s, 205.0);
  EXPECT_GE(shorter.nodes().back().time_s, 216.0);
  EXPECT_NE(Drawn(6).At(211.0), longer.At(211.0));
}

TEST(GaussMarkovTest, CurveKeepsItsDistanceFromTheProcess) {
  // Closed form (docs/theory/trajectory_error.md, eq. (9)): without every other node the curve
  // misses the nodes left out by s (2/64)^2.5 / sqrt(3840), 2.8e-6 s. Nodes left out are
  // independent.
  const std::vector<SmoothCurve::Node> nodes = Drawn(3, 100.0, 400.0).nodes();
  std::vector<SmoothCurve::Node> every_other;
  for (std::size_t i = 0; i < nodes.size(); i += 2) every_other.push_back(nodes[i]);
  const SmoothCurve coarse(every_other);
  const double bound_m = kRms_m * std::pow(2.0 / 64.0, 2.5) / std::sqrt(3840.0);
  double square = 0.0, count = 0.0;
  for (std::size_t i = 1; i + 1 < nodes.size(); i += 2) {
    square += std::pow((coarse.At(nodes[i].time_s)[0] - nodes[i].value) / bound_m, 2);
    count += 1.0;
  }
  ASSERT_GT(count, 1000.0);
  // The bound leaves terms out that are smaller by step/T.
  EXPECT_NEAR(square / count, 1.0, 4.0 * std::sqrt(2.0 / count) + 0.05);
}

TEST(SmoothCurveTest, IsTheNaturalSplineOfHandValues) {
  // Hand arithmetic: second derivatives 0, -3, 0 through (0, 0), (1, 1), (2, 0).
  const SmoothCurve curve = SmoothCurve::Natural({0.0, 1.0, 2.0}, {0.0, 1.0, 0.0});
  EXPECT_NEAR(curve.At(0.5)[0], 0.6875, 1e-15);
  EXPECT_NEAR(curve.At(1.0)[2], -3.0, 1e-14);
  EXPECT_NEAR(curve.At(0.5)[3], -3.0, 1e-13);
  EXPECT_NEAR(curve.At(-2.0)[0], -3.0, 1e-15);  // straight, slope 1.5
  EXPECT_NEAR(curve.At(4.0)[0], -3.0, 1e-14);
  EXPECT_EQ(SmoothCurve().At(3.0), (std::array<double, 4>{}));
  const SmoothCurve line = SmoothCurve::Natural({3.0, 7.0}, {1.0, 3.0});
  EXPECT_NEAR(line.At(6.0)[0], 2.5, 1e-15);
}

TEST(SmoothCurveTest, DerivativesAreThoseOfTheValues) {
  // Numerical route: central differences over 0.2 ms, inside pieces and across nodes.
  const SmoothCurve process = Drawn(9);
  const SmoothCurve table =
      SmoothCurve::Natural({180.0, 184.5, 199.0, 221.7, 230.0, 260.0}, {3, -1, 4, 1, -5, 9});
  const double h_s = 1e-4;
  for (const SmoothCurve* curve : {&process, &table}) {
    for (const double time_s : {184.5, 199.03, 211.0, 226.61}) {
      const auto before = curve->At(time_s - h_s), at = curve->At(time_s),
                 after = curve->At(time_s + h_s);
      // Rounding of 5 m over 0.2 ms, and a jump of the third derivative by some m/s3 times h/2.
      EXPECT_NEAR((after[0] - before[0]) / (2.0 * h_s), at[1], 1e-7);
      EXPECT_NEAR((after[1] - before[1]) / (2.0 * h_s), at[2], 1e-4);
    }
  }
}

}  // namespace
}  // namespace sarblock
