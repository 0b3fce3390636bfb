// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/recorded_states.h"
#include "geometry/test_flights.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr double kTight_rad = 1e-9;

// ---- flights

using test::kCircleRadius_m;
using test::kCircleRate_radps;
using test::OnCircle;

const test::Aircraft kAircraft(0.0);

StateVector OnCubic(double t) {
  return {t,
          {120.3 * t, 3.1 + 0.21 * t * t, 900.0 - 0.017 * t * t * t},
          {120.3, 0.42 * t, -0.051 * t * t}};
}

template <typename Flight>
std::vector<StateVector> Record(const Flight& flight, double spacing_s, int count) {
  std::vector<StateVector> states;
  for (int k = 0; k < count; ++k) states.push_back(flight(31.25 + spacing_s * k));
  return states;
}

std::vector<StateVector> WithNoise(std::vector<StateVector> states,
                                   double sigma_m,
                                   double sigma_mps,
                                   std::uint64_t seed) {
  RandomStream random(20261122, seed);
  for (StateVector& state : states) {
    for (Eigen::Index i = 0; i < 3; ++i) state.position_m[i] += sigma_m * random.Normal();
    for (Eigen::Index i = 0; i < 3; ++i) state.velocity_mps[i] += sigma_mps * random.Normal();
  }
  return states;
}

TimeSpan Inner(const std::vector<StateVector>& states) {
  const double tenth_s = 0.1 * (states.back().time_s - states.front().time_s);
  return {states.front().time_s + tenth_s, states.back().time_s - tenth_s};
}

Recording MakeRecording(const std::vector<StateVector>& states, const StateNoise& given = {}) {
  return {states, given, Inner(states)};
}

/// Root mean square of the error of the velocity across the flight, length of the vector.
template <typename Flight>
double VelocityError_mps(const FlightPath& path, const Flight& flight, const TimeSpan& span_s) {
  double sum = 0.0, count = 0.0;
  const double step_s = (span_s.last_s - span_s.first_s) / 4999.3;
  for (double t_s = span_s.first_s; t_s < span_s.last_s; t_s += step_s) {
    const StateVector truth = flight(t_s);
    const Eigen::Vector3d e = path.At(t_s)->velocity_mps - truth.velocity_mps;
    const Eigen::Vector3d u = truth.velocity_mps.normalized();
    sum += (e - u * u.dot(e)).squaredNorm();
    count += 1.0;
  }
  return std::sqrt(sum / count);
}

// ---- what the states say of themselves

// Closed form: a cubic has no differences of order 4 and above, its velocities none of order 3.
TEST(RecordingTest, APolynomialHasNeitherNoiseNorContradictionNorErrorOfInterpolation) {
  const std::vector<StateVector> states = Record(OnCubic, 0.5, 40);
  const RecordedPath read = MakeRecording(states).Read(PathThrough::kStates, kTight_rad);
  EXPECT_LT(read.noise.position_m, 1e-10);  // rounding of 6 km
  EXPECT_LT(read.noise.velocity_mps, 1e-12);
  EXPECT_LT(read.errors.contradiction_mps, 1e-10);
  EXPECT_LT(read.errors.interpolation_mps, 1e-9);
  EXPECT_LT(read.errors.noise.velocity_mps, 1e-9);
}

// Seeded statistics. A mean square over 768 elements of differences, correlated over some ten
// states, is known to about a sixth; the least of eight orders is low by less than that.
TEST(RecordingTest, NoiseIsEstimatedFromDifferencesOfStates) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const auto states = WithNoise(Record(kAircraft, 0.01, 6000), 0.021, 0.013, seed);
    const Recording recording = MakeRecording(states);
    EXPECT_NEAR(recording.noise().position_m, 0.021, 0.16 * 0.021);
    EXPECT_NEAR(recording.noise().velocity_mps, 0.013, 0.16 * 0.013);
  }
}

TEST(RecordingTest, StatesTooSparseForTheFlightShowNoNoise) {
  const Recording recording = MakeRecording(Record(OnCircle, 300.0, 24));
  EXPECT_EQ(recording.noise().position_m, 0.0);
  EXPECT_EQ(recording.noise().velocity_mps, 0.0);
}

// Hand values: the velocity of a cubic through noise has, on average over the piece, the variance
// 12/5 sigma_p^2/h^2 + 4/15 sigma_v^2.
TEST(RecordingTest, TheCubicTurnsNoiseOfStatesIntoNoiseOfTheVelocity) {
  const double h_s = 0.25, sigma_m = 0.031, sigma_mps = 0.17;
  const double expected_mps =
      std::sqrt(12.0 / 5.0 * std::pow(sigma_m / h_s, 2) + 4.0 / 15.0 * std::pow(sigma_mps, 2));
  const auto states = WithNoise(Record(kAircraft, h_s, 4000), sigma_m, sigma_mps, 3);
  const Recording recording = MakeRecording(states, {sigma_m, sigma_mps});
  const RecordedPath read = recording.Read(PathThrough::kStates, kTight_rad);
  EXPECT_NEAR(read.errors.noise.velocity_mps, expected_mps, 1e-12);
  // Two axes lie across the flight. 4,000 pieces know the mean square to 3 %.
  EXPECT_NEAR(VelocityError_mps(read.path, kAircraft, Inner(states)),
              std::sqrt(2.0) * expected_mps,
              0.05 * expected_mps);
  EXPECT_LT(read.errors.interpolation_mps, 0.2 * expected_mps);
}

// Closed form: s'''' of a circle of radius r is r w^4, and the velocity of the cubic is off by
// h^3 s''''/(12 sqrt(210)) in the mean. The next order is (w h)^2/14 of that.
TEST(RecordingTest, TheErrorOfInterpolationOfACircleIsThatOfItsFourthDerivative) {
  for (const double h_s : {10.0, 60.0, 120.0, 300.0}) {
    const auto states = Record(OnCircle, h_s, 30);
    const RecordedPath read = MakeRecording(states).Read(PathThrough::kStates, kTight_rad);
    const double expected_mps = std::pow(h_s, 3) * kCircleRadius_m *
                                std::pow(kCircleRate_radps, 4) / (12.0 * std::sqrt(210.0));
    EXPECT_NEAR(read.errors.interpolation_mps, expected_mps, 0.03 * expected_mps) << h_s;
    EXPECT_NEAR(
        VelocityError_mps(read.path, OnCircle, Inner(states)), expected_mps, 0.03 * expected_mps)
        << h_s;
    EXPECT_LT(read.errors.contradiction_mps, 0.05 * expected_mps) << h_s;
  }
}

// The same of two states alone, from the curvature between them.
TEST(RecordingTest, TwoStatesOfAnOrbitReportTheirErrorOfInterpolation) {
  const double h_s = 120.0;
  const RecordedPath read =
      MakeRecording(Record(OnCircle, h_s, 2)).Read(PathThrough::kStates, kTight_rad);
  const double expected_mps = std::pow(h_s, 3) * kCircleRadius_m * std::pow(kCircleRate_radps, 4) /
                              (12.0 * std::sqrt(210.0));
  EXPECT_NEAR(read.errors.interpolation_mps, expected_mps, 0.05 * expected_mps);
}

// Closed form: between positions that are right a velocity that is off by b at the states swings by
// b (1 - 6u + 6u^2), root mean square b/sqrt(5).
TEST(RecordingTest, VelocitiesThatContradictPositionsAreMeasured) {
  auto states = Record(OnCircle, 10.0, 40);
  const Eigen::Vector3d b_mps(0.0, 0.023, 0.0);  // across the orbit
  for (StateVector& state : states) state.velocity_mps += b_mps;
  const Recording recording = MakeRecording(states);
  EXPECT_NEAR(recording.contradiction_mps(), 0.023, 1e-5);
  const RecordedPath read = recording.Read(PathThrough::kStates, kTight_rad);
  EXPECT_NEAR(read.errors.contradiction_mps, 0.023 / std::sqrt(5.0), 1e-5);
  EXPECT_NEAR(VelocityError_mps(read.path, OnCircle, Inner(states)), 0.023 / std::sqrt(5.0), 3e-4);
  const RecordedPath positions = recording.Read(PathThrough::kPositions, kTight_rad);
  EXPECT_EQ(positions.errors.contradiction_mps, 0.0);
  EXPECT_LT(VelocityError_mps(positions.path, OnCircle, Inner(states)), 7.5e-6);
}

TEST(RecordingTest, NoiseOfVelocitiesIsNoContradiction) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Recording recording =
        MakeRecording(WithNoise(Record(kAircraft, 0.1, 700), 0.02, 0.05, seed));
    EXPECT_EQ(recording.contradiction_mps(), 0.0) << seed;
  }
}

// ---- polynomials of degree 7

// States 60 to 300 s apart: the errors reported are the true ones, within a factor of two, and far
// below those of the cubic.
TEST(RecordingTest, PolynomialsOfDegreeSevenFollowASparseOrbitAndReportTheirErrors) {
  for (const double h_s : {60.0, 120.0, 300.0}) {
    const auto states = Record(OnCircle, h_s, 30);
    const Recording recording = MakeRecording(states);
    const double cubic_mps =
        recording.Read(PathThrough::kStates, kTight_rad).errors.interpolation_mps;
    for (const PathThrough through : {PathThrough::kOrbit, PathThrough::kPositions}) {
      const RecordedPath read = recording.Read(through, kTight_rad);
      const double error_mps = VelocityError_mps(read.path, OnCircle, Inner(states));
      const double reported_mps = read.errors.interpolation_mps;
      // The states made follow the polynomial to kTight_rad, 7.5e-6 m/s, at most.
      EXPECT_NEAR(error_mps, reported_mps, 1.0 * reported_mps + 7.5e-6) << h_s;
      EXPECT_LT(error_mps, 0.1 * cubic_mps) << h_s;
      EXPECT_LT(read.errors.noise.velocity_mps, 1e-6);
    }
  }
}

TEST(RecordingTest, NoiseComesOutOfPolynomialsAsReported) {
  for (const PathThrough through : {PathThrough::kOrbit, PathThrough::kPositions}) {
    const auto states = WithNoise(Record(kAircraft, 0.5, 3000), 0.031, 0.047, 5);
    const Recording recording = MakeRecording(states, {0.031, 0.047});
    const RecordedPath read = recording.Read(through, 1e-6);
    const double reported_mps = std::sqrt(2.0) * read.errors.noise.velocity_mps;
    EXPECT_NEAR(
        VelocityError_mps(read.path, kAircraft, Inner(states)), reported_mps, 0.06 * reported_mps);
  }
}

// ---- smoothing

// A cubic is a spline: nothing is left but rounding, and one piece is enough.
TEST(RecordingTest, ASmoothedCubicIsTheCubic) {
  const auto states = Record(OnCubic, 0.5, 40);
  const RecordedPath read =
      MakeRecording(states, {0.01, 0.01}).Read(PathThrough::kSmooth, kTight_rad);
  for (double t_s = states.front().time_s; t_s <= states.back().time_s; t_s += 0.173) {
    EXPECT_LT((read.path.At(t_s)->position_m - OnCubic(t_s).position_m).norm(), 1e-8);
    EXPECT_LT((read.path.At(t_s)->velocity_mps - OnCubic(t_s).velocity_mps).norm(), 1e-8);
  }
}

// The cubic through states at the knots is the spline: its acceleration does not jump.
TEST(RecordingTest, TheAccelerationOfASmoothedPathIsContinuous) {
  const auto states = WithNoise(Record(kAircraft, 0.01, 6000), 0.02, 0.01, 11);
  const RecordedPath read = MakeRecording(states).Read(PathThrough::kSmooth, kTight_rad);
  ASSERT_GT(read.path.piece_count(), 10U);
  ASSERT_LT(read.path.piece_count(), 600U);
  for (std::size_t k = 1; k < read.path.piece_count(); ++k) {
    const double at_s = read.path.PieceStart_s(k);
    const Eigen::Vector3d before = read.path.At(at_s - 1e-9)->acceleration_mps2;
    const Eigen::Vector3d after = read.path.At(at_s)->acceleration_mps2;
    EXPECT_LT((after - before).norm(), 1e-6);  // jerk times 1 ns, and rounding of 9 km
  }
}

// States at the recorded times then hold all knots and give the same path again.
TEST(RecordingTest, KnotsAreAtRecordedTimesToTheLastBit) {
  std::vector<StateVector> states;
  for (int k = 0; k < 3000; ++k) states.push_back(kAircraft(-22.0 + 0.01 * k));
  const RecordedPath read =
      MakeRecording(WithNoise(states, 0.02, 0.01, 13)).Read(PathThrough::kSmooth, kTight_rad);
  ASSERT_GT(read.path.states().size(), 30U);
  for (const StateVector& knot : read.path.states()) {
    EXPECT_TRUE(std::any_of(states.begin(), states.end(), [&knot](const StateVector& state) {
      return state.time_s == knot.time_s;
    })) << knot.time_s;
  }
}

// Seeded statistics: 2 cm and 1 cm/s at 100 Hz. The cubic is off by metres per second; what is left
// of the smoothed path is reported, noise and what the knots do not follow together.
TEST(RecordingTest, ASmoothedFlightIsAsGoodAsReported) {
  double square = 0.0, reported = 0.0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const auto states = WithNoise(Record(kAircraft, 0.01, 6000), 0.02, 0.01, seed);
    for (const StateNoise& given : {StateNoise{}, StateNoise{0.02, 0.01}}) {
      const RecordedPath read = MakeRecording(states, given).Read(PathThrough::kSmooth, kTight_rad);
      square += std::pow(VelocityError_mps(read.path, kAircraft, Inner(states)), 2);
      reported += 2.0 * (std::pow(read.errors.noise.velocity_mps, 2) +
                         std::pow(read.errors.interpolation_mps, 2));
      EXPECT_NEAR(read.noise.position_m, 0.02, 0.001);
      EXPECT_NEAR(read.noise.velocity_mps, 0.01, 0.0005);
    }
  }
  const double rms_mps = std::sqrt(square / 24.0), reported_mps = std::sqrt(reported / 24.0);
  EXPECT_LT(rms_mps, 0.002);
  EXPECT_NEAR(reported_mps, rms_mps, 0.1 * rms_mps);
}

// Chi-square of positions and of velocities, each with its own degrees of freedom, over seeds.
TEST(RecordingTest, TheMisfitOfASmoothedPathFollowsItsSigmas) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto states = WithNoise(Record(kAircraft, 0.02, 3000), 0.02, 0.03, seed);
    const RecordedPath read =
        MakeRecording(states, {0.02, 0.03}).Read(PathThrough::kSmooth, kTight_rad);
    ASSERT_TRUE(read.fit.has_value());
    const FitOfStates& fit = *read.fit;
    const Interval p = ChiSquareInterval(0.9999, fit.position_freedom);
    const Interval v = ChiSquareInterval(0.9999, fit.velocity_freedom);
    EXPECT_TRUE(p.Contains(fit.position_ratio * fit.position_freedom)) << fit.position_ratio;
    EXPECT_TRUE(v.Contains(fit.velocity_ratio * fit.velocity_freedom)) << fit.velocity_ratio;
    EXPECT_GT(fit.position_freedom + fit.velocity_freedom, 17000.0);
    // The same states under sigmas three times as large.
    const RecordedPath loose =
        MakeRecording(states, {0.06, 0.09}).Read(PathThrough::kSmooth, kTight_rad);
    EXPECT_NEAR(loose.fit->position_ratio, 1.0 / 9.0, 0.01);
    EXPECT_NEAR(loose.fit->velocity_ratio, 1.0 / 9.0, 0.01);
  }
}

TEST(RecordingTest, StatesAtUnequalTimesAreSmoothedAlike) {
  RandomStream random(7, 1);
  std::vector<StateVector> states;
  for (double t_s = 0.0; t_s < 60.0; t_s += 0.002 + 0.03 * random.Uniform()) {
    states.push_back(kAircraft(t_s));
  }
  states = WithNoise(states, 0.02, 0.01, 2);
  const RecordedPath read = MakeRecording(states).Read(PathThrough::kSmooth, kTight_rad);
  EXPECT_LT(VelocityError_mps(read.path, kAircraft, Inner(states)), 0.003);
  EXPECT_NEAR(read.noise.position_m, 0.02, 0.001);
  EXPECT_NEAR(read.noise.velocity_mps, 0.01, 0.0006);
  EXPECT_FALSE(read.fit.has_value());  // of sigmas that the states themselves gave
}

TEST(RecordingTest, TwoStatesCanBeReadInEveryWay) {
  const auto states = Record(kAircraft, 1.5, 2);
  for (const PathThrough through :
       {PathThrough::kStates, PathThrough::kOrbit, PathThrough::kPositions, PathThrough::kSmooth}) {
    const RecordedPath read = MakeRecording(states).Read(through, kTight_rad);
    EXPECT_EQ(read.path.start_s(), states.front().time_s);
    EXPECT_EQ(read.path.end_s(), states.back().time_s);
    EXPECT_TRUE(std::isfinite(read.errors.noise.velocity_mps)) << NameOf(through);
    EXPECT_TRUE(std::isfinite(read.errors.interpolation_mps)) << NameOf(through);
  }
}

}  // namespace
}  // namespace sarblock
