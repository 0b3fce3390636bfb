// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/files/block_file.h"
#include "sarblock/simulate/scene.h"

#include <cmath>
#include <string>
#include <vector>

#include "core/threads.h"
#include "simulate/small_scene.h"
#include "simulate/true_path.h"
#include "support/folder_test.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// The small scene in gusty air, exactly recorded.
Scene SceneWithTrajectoryErrors() {
  Scene scene = test::SmallScene();
  scene.trajectory_error.rms_m = {4.0, 6.0, 5.0};
  scene.trajectory_error.time_constant_s = {9.0, 7.0, 6.0};
  scene.recorder.emplace();
  scene.recorder->rate_hz = 12.5;
  return scene;
}

bool SameStates(const FlightPath& a, const FlightPath& b) {
  if (a.states().size() != b.states().size()) return false;
  for (std::size_t i = 0; i < a.states().size(); ++i) {
    const StateVector &x = a.states()[i], &y = b.states()[i];
    if (x.time_s != y.time_s || x.position_m != y.position_m || x.velocity_mps != y.velocity_mps) {
      return false;
    }
  }
  return true;
}

TEST(RecordedFlightTest, StatesLieOnTheFlightAtTheRateOfTheRecorder) {
  // Hand values: in Leberl's frame the flight is x = -500 + 173 t, y = 300, z = 9100 plus the
  // wander.
  const Scene scene = SceneWithTrajectoryErrors();
  const SimulatedBlock simulated = Simulate(scene);
  const std::vector<StateVector>& states = simulated.block.passes[0].path.states();
  for (std::size_t i = 0; i < states.size(); ++i) {
    const double k = std::round(states[i].time_s * 12.5);
    EXPECT_NEAR(states[i].time_s, k / 12.5, 1e-12);
    const TrajectoryError::Offset trajectory_error =
        simulated.TrajectoryErrorOf(0)->At(states[i].time_s);
    const Eigen::Vector3d straight_m(-500.0 + 173.0 * states[i].time_s, 300.0, 9100.0);
    EXPECT_LT((states[i].position_m - straight_m - trajectory_error.value_m).norm(), 1e-9);
    EXPECT_LT(
        (states[i].velocity_mps - Eigen::Vector3d(173, 0, 0) - trajectory_error.first_mps).norm(),
        1e-10);
  }
  EXPECT_LT(states.front().time_s, -4.0 / 12.5);
  EXPECT_GT(states.back().time_s, 21000.0 / 173.0 + 4.0 / 12.5);
}

TEST(RecordedFlightTest, LooksAreTheNearestPointsOfTheTruePath) {
  // Independent route: with squint 0 the look stands where the distance is least. Positions alone,
  // straight line plus wander by hand; bisection on the central difference of the square distance.
  Scene scene = SceneWithTrajectoryErrors();
  scene.looks.noise_scale = 0.0;
  scene.recorder->noise_m = 0.5;  // of the record, not of the flight
  const SimulatedBlock simulated = Simulate(scene);
  const Looks& looks = simulated.block.looks;
  for (std::size_t point = 0; point < 60; ++point) {
    const Eigen::Vector3d& p_m = simulated.truth.points_m[point];
    for (auto i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      const std::size_t pass = looks.pass[i];
      const auto distance_m = [&](double t) {
        const Eigen::Vector3d s_m =
            Eigen::Vector3d(
                -500.0 + 173.0 * t, 300.0 + 7300.0 * static_cast<double>(pass), 9100.0) +
            simulated.TrajectoryErrorOf(pass)->At(t).value_m;
        return (p_m - s_m).norm();
      };
      double low_s = looks.time_s[i] - 3.0, high_s = looks.time_s[i] + 3.0;
      while (high_s - low_s > 1e-10) {
        const double t = 0.5 * (low_s + high_s);
        (distance_m(t + 1e-4) < distance_m(t - 1e-4) ? low_s : high_s) = t;
      }
      EXPECT_NEAR(looks.time_s[i], low_s, 1e-6);  // rounding of the distances over 0.2 ms: 2e-7 s
      EXPECT_NEAR(looks.range_m[i], distance_m(low_s), 1e-9);
    }
  }
}

TEST(RecordedFlightTest, ErrorsOfNavigationMoveTheFlightAgainstItsRecord) {
  // Hand values: without turning axes 3 m up are 3 m up; the axes follow the wandering flight.
  Scene scene = SceneWithTrajectoryErrors();
  scene.navigation.constant_sigma_m = {2.0, 3.0, 4.0};
  const SimulatedBlock simulated = Simulate(scene);
  const TruePath truth = TruePathOf(scene, simulated, 1);
  const FlightPath& record = simulated.block.passes[1].path;
  const StateVector& state = record.states()[700];
  const auto at = truth.At(state.time_s);
  ASSERT_TRUE(at.has_value());
  const Eigen::Vector3d moved_m = at->position_m - state.position_m;
  const Eigen::Vector3d along = state.velocity_mps.normalized();
  const Eigen::Vector3d across = Eigen::Vector3d::UnitZ().cross(along).normalized();
  EXPECT_NEAR(moved_m.dot(along), simulated.errors[1].constant_m[0], 1e-9);
  EXPECT_NEAR(moved_m.dot(across), simulated.errors[1].constant_m[1], 1e-9);
  EXPECT_NEAR(moved_m.dot(along.cross(across)), simulated.errors[1].constant_m[2], 1e-9);
}

TEST(RecordedFlightTest, VelocityAndAccelerationAreDerivatives) {
  // Numerical route on a low orbit, where the axes turn: central differences over 20 ms.
  Scene scene = SceneWithTrajectoryErrors();
  scene.frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  scene.centre.lat_rad = 0.4;
  scene.flights[0].pattern = SceneFlight::Pattern::kOrbit;
  scene.flights[0].speed_mps = kNotGiven;
  scene.flights[0].height_m = 500e3;
  scene.flights[0].inclination_rad = 1.1;
  scene.flights[0].swath = {SwathKind::kLookAngle, {0.4, 0.7}};
  scene.flights[0].count = 1;
  scene.flights[0].start_m.setZero();
  scene.points.east_m = {-3000.0, 3000.0};
  scene.points.north_m = {-3000.0, 3000.0};
  scene.points.min_looks = 1;
  scene.navigation.constant_sigma_m = {2.0, 3.0, 4.0};
  const SimulatedBlock simulated = Simulate(scene);
  const TruePath path = TruePathOf(scene, simulated, 0);
  const double h_s = 1e-2;
  const auto before = path.At(1.37 - h_s), at = path.At(1.37), after = path.At(1.37 + h_s);
  ASSERT_TRUE(before && at && after);
  // Positions of 7e6 m round at 2e-9 m; the third derivative of the gusts is 0.1 m/s3.
  EXPECT_LT(((after->position_m - before->position_m) / (2 * h_s) - at->velocity_mps).norm(), 1e-5);
  EXPECT_LT(
      ((after->velocity_mps - before->velocity_mps) / (2 * h_s) - at->acceleration_mps2).norm(),
      2e-3);
  EXPECT_GT((at->position_m - simulated.Planned(0).path.At(1.37)->position_m).norm(), 0.1);
}

TEST(RecorderTest, NoiseHasItsStandardDeviations) {
  // Seeded statistics of 3 x 1500 states, 99.9 percent each.
  Scene scene = SceneWithTrajectoryErrors();
  scene.recorder->noise_m = 0.03;
  scene.recorder->noise_mps = 0.011;
  const SimulatedBlock simulated = Simulate(scene);
  double positions = 0.0, velocities = 0.0, product = 0.0, n = 0.0;
  for (std::size_t pass = 0; pass < 2; ++pass) {
    for (const StateVector& state : simulated.block.passes[pass].path.states()) {
      const auto flown = FlownMotion(simulated.block.frame,
                                     simulated.Planned(pass).path,
                                     simulated.TrajectoryErrorOf(pass),
                                     state.time_s);
      ASSERT_TRUE(flown.has_value());
      const Eigen::Vector3d position = (state.position_m - flown->position_m) / 0.03;
      const Eigen::Vector3d velocity = (state.velocity_mps - flown->velocity_mps) / 0.011;
      positions += position.squaredNorm();
      velocities += velocity.squaredNorm();
      product += position.dot(velocity);
      n += 3.0;
    }
  }
  ASSERT_GT(n, 9000.0);
  EXPECT_TRUE(ChiSquareInterval(0.999, n).Contains(positions)) << positions << " of " << n;
  EXPECT_TRUE(ChiSquareInterval(0.999, n).Contains(velocities)) << velocities << " of " << n;
  EXPECT_LT(std::abs(product) / std::sqrt(n), NormalQuantile(0.9995));
}

TEST(RecorderTest, DriftAndVelocityBiasAreOneDrawAPass) {
  // Closed form on a straight flight; seeded statistics of 600 passes, 99.9 percent each.
  Scene scene = test::SmallScene();
  SceneRecorder recorder;
  recorder.drift_sigma_mps = {0.02, 0.03, 0.01};
  recorder.velocity_bias_sigma_mps = {0.004, 0.005, 0.006};
  const Pass planned = Simulate(scene).block.passes[0];
  const double middle_s = 0.5 * (planned.start_s + planned.end_s);
  constexpr int kPasses = 600;
  std::array<double, 3> drift{}, bias{};
  for (std::uint64_t seed = 1; seed <= kPasses; ++seed) {
    const FlightPath path = RecordFlight(scene.frame, recorder, 10.0, planned, nullptr, 3, seed);
    const StateVector &first = path.states().front(), &last = path.states().back();
    const auto error_m = [&](const StateVector& state) {
      return Eigen::Vector3d(state.position_m - planned.path.At(state.time_s)->position_m);
    };
    const Eigen::Vector3d rate_mps =
        (error_m(last) - error_m(first)) / (last.time_s - first.time_s);
    EXPECT_LT((error_m(first) - rate_mps * (first.time_s - middle_s)).norm(), 1e-9);
    EXPECT_LT((first.velocity_mps - last.velocity_mps).norm(), 1e-12);
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      drift[i] += std::pow(rate_mps[axis] / recorder.drift_sigma_mps[i], 2);
      const double velocity_mps = first.velocity_mps[axis] - (axis == 0 ? 173.0 : 0.0);
      bias[i] += std::pow(velocity_mps / recorder.velocity_bias_sigma_mps[i], 2);
    }
  }
  const Interval accepted = ChiSquareInterval(0.999, kPasses);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(accepted.Contains(drift[i])) << i << ": " << drift[i];
    EXPECT_TRUE(accepted.Contains(bias[i])) << i << ": " << bias[i];
  }
}

TEST(RecorderTest, JumpsStayUntilTheNextOne) {
  // Seeded statistics of 300 passes over 121 s, a jump every 20 s on average: Poisson's count, the
  // offsets' chi-square. Velocities do not jump.
  Scene scene = test::SmallScene();
  SceneRecorder recorder;
  recorder.jump_m = 0.4;
  recorder.jump_interval_s = 20.0;
  const Pass planned = Simulate(scene).block.passes[0];
  constexpr int kPasses = 300;
  double jumps = 0.0, square = 0.0, duration_s = 0.0;
  for (std::uint64_t seed = 1; seed <= kPasses; ++seed) {
    const FlightPath path = RecordFlight(scene.frame, recorder, 0.1, planned, nullptr, 0, seed);
    Eigen::Vector3d before_m = Eigen::Vector3d::Zero();
    for (const StateVector& state : path.states()) {
      const Eigen::Vector3d error_m = state.position_m - planned.path.At(state.time_s)->position_m;
      if (state.time_s <= planned.start_s) {
        EXPECT_LT(error_m.norm(), 1e-9);
      }
      EXPECT_LT((state.velocity_mps - Eigen::Vector3d(173, 0, 0)).norm(), 1e-12);
      if ((error_m - before_m).norm() < 1e-9) continue;
      jumps += 1.0;
      square += error_m.squaredNorm() / (0.4 * 0.4);
      before_m = error_m;
    }
    duration_s += path.end_s() - planned.start_s;
  }
  EXPECT_TRUE(ChiSquareInterval(0.999, 3.0 * jumps).Contains(square)) << square << " of " << jumps;
  // Two jumps between two states count once: 0.1/20 of them.
  const double expected = duration_s / 20.0;
  EXPECT_NEAR(jumps, expected, NormalQuantile(0.9995) * std::sqrt(expected) + 0.005 * expected);
}

TEST(RecorderTest, TimeStampsAreOffByAConstant) {
  Scene scene = SceneWithTrajectoryErrors();
  scene.recorder->time_offset_s = 0.37;
  const SimulatedBlock simulated = Simulate(scene);
  for (const StateVector& state : simulated.block.passes[1].path.states()) {
    const auto flown = FlownMotion(simulated.block.frame,
                                   simulated.Planned(1).path,
                                   simulated.TrajectoryErrorOf(1),
                                   state.time_s - 0.37);
    ASSERT_TRUE(flown.has_value());
    EXPECT_LT((state.position_m - flown->position_m).norm(), 1e-9);
  }
}

class RecordedFilesTest : public test::FolderTest {};

TEST_F(RecordedFilesTest, BlocksAreReadAsTheirFilesAre) {  // two routes, to the last bit
  Scene scene = SceneWithTrajectoryErrors();
  scene.trajectory_error.time_constant_s = {40.0, 40.0, 40.0};
  scene.recorder->noise_m = 0.03;
  scene.recorder->noise_mps = 0.02;
  scene.recorder->reading = {PathThrough::kSmooth, {0.03, 0.02}};
  const SimulatedBlock simulated = Simulate(scene);
  files::WriteBlock(folder_ / "block", simulated.block, {}, &simulated.truth);
  const Block read = files::ReadBlock(folder_ / "block").block;
  for (std::size_t pass = 0; pass < 2; ++pass) {
    const Pass& made = simulated.block.passes[pass];
    EXPECT_EQ(read.passes[pass].recorded.asked.through, PathThrough::kSmooth);
    EXPECT_EQ(read.passes[pass].recorded.asked.sigma.velocity_mps, 0.02);
    EXPECT_TRUE(SameStates(read.passes[pass].path, made.path));
    EXPECT_TRUE(SameStates(FlightPath(read.passes[pass].RecordedStates()),
                           FlightPath(made.RecordedStates())));
    // Smoothed, it is nearer to the flight than its states are.
    const StateVector& state = made.RecordedStates()[900];
    const Motion flown = *TruePathOf(scene, simulated, pass).At(state.time_s);
    EXPECT_LT((made.path.At(state.time_s)->velocity_mps - flown.velocity_mps).norm(), 0.02);
    EXPECT_FALSE(SameStates(made.path, FlightPath(made.RecordedStates())));
  }
  SimulatedBlock again = simulated;  // round trip
  Redraw(scene, 991, {}, &again);
  EXPECT_FALSE(SameStates(again.block.passes[0].path, simulated.block.passes[0].path));
  Redraw(scene, scene.seed, {}, &again);
  EXPECT_TRUE(SameStates(again.block.passes[0].path, simulated.block.passes[0].path));
}

TEST(RecordedFlightTest, SameSeedGivesTheSameBytesForAnyThreads) {
  Scene scene = SceneWithTrajectoryErrors();
  scene.recorder->noise_m = 0.03;
  scene.recorder->jump_m = 0.1;
  scene.recorder->jump_interval_s = 30.0;
  const auto with = [&](int threads) {
    const ThreadLimit limit(threads);
    return Simulate(scene);
  };
  const SimulatedBlock one = with(1), two = with(2);
  EXPECT_EQ(one.block.looks.time_s, two.block.looks.time_s);
  EXPECT_EQ(one.block.looks.range_m, two.block.looks.range_m);
  for (std::size_t pass = 0; pass < 2; ++pass) {
    EXPECT_TRUE(SameStates(one.block.passes[pass].path, two.block.passes[pass].path));
    EXPECT_TRUE(SameStates(one.truth.paths[pass], two.truth.paths[pass]));
  }
}

TEST(RecordedFlightTest, RedrawDoesNotDependOnEarlierDraws) {  // round trip
  Scene scene = SceneWithTrajectoryErrors();
  scene.recorder->noise_m = 0.03;
  const SimulatedBlock first = Simulate(scene);
  SimulatedBlock again = first;
  Redraw(scene, 991, {.navigation = false}, &again);
  EXPECT_TRUE(SameStates(first.block.passes[0].path, again.block.passes[0].path));
  Redraw(scene, 991, {}, &again);
  EXPECT_FALSE(SameStates(first.block.passes[0].path, again.block.passes[0].path));
  Redraw(scene, scene.seed, {}, &again);
  EXPECT_TRUE(SameStates(first.block.passes[0].path, again.block.passes[0].path));
  EXPECT_EQ(first.block.looks.time_s, again.block.looks.time_s);
}

TEST(RecordedFlightTest, APassDoesNotDependOnWhatElseTheSceneHolds) {
  // Another flight behind it, and noise that widens the planned paths: the states in common agree.
  Scene scene = SceneWithTrajectoryErrors();
  scene.recorder->noise_m = 0.03;
  const SimulatedBlock plain = Simulate(scene);
  scene.flights.push_back(scene.flights[0]);
  scene.flights[1].id = "B";
  scene.looks.azimuth.azimuth = 60.0;
  const SimulatedBlock wider = Simulate(scene);
  const std::vector<StateVector>& few = plain.block.passes[1].path.states();
  const std::vector<StateVector>& many = wider.block.passes[1].path.states();
  ASSERT_GT(many.size(), few.size());
  std::size_t i = 0;
  while (many[i].time_s < few[0].time_s) ++i;
  for (std::size_t k = 0; k < few.size(); ++k) {
    EXPECT_EQ(few[k].time_s, many[i + k].time_s);
    EXPECT_LT((few[k].position_m - many[i + k].position_m).norm(), 1e-8);
  }
}

TEST(RecordedFlightTest, TablesAddToTheProcess) {
  // Hand value: an offset that stays is a flight beside its line.
  Scene scene = test::SmallScene();
  scene.trajectory_error.table_time_s = {-10.0, 200.0};
  scene.trajectory_error.table_m = {{0.0, 7.0, -3.0}, {0.0, 7.0, -3.0}};
  EXPECT_TRUE(IsRecorded(scene));
  const SimulatedBlock simulated = Simulate(scene);
  const StateVector& state = simulated.block.passes[0].path.states()[40];
  EXPECT_NEAR(state.position_m.y(), 307.0, 1e-9);
  EXPECT_NEAR(state.position_m.z(), 9097.0, 1e-9);
  scene.trajectory_error.rms_m = {0.0, 2.0, 0.0};
  scene.trajectory_error.time_constant_s[1] = 5.0;
  const SimulatedBlock both = Simulate(scene);
  Scene process = scene;
  process.trajectory_error.table_time_s.clear();
  process.trajectory_error.table_m.clear();
  const TrajectoryError alone(process.trajectory_error, both.Planned(0), 0, scene.seed);
  EXPECT_NEAR(
      both.TrajectoryErrorOf(0)->At(31.3).value_m.y(), 7.0 + alone.At(31.3).value_m.y(), 1e-12);
}

TEST(RecordedFlightTest, ScenesWithoutRecorderHoldNoSecondPaths) {
  const SimulatedBlock simulated = Simulate(test::SmallScene());
  EXPECT_TRUE(simulated.planned.empty());
  EXPECT_TRUE(simulated.trajectory_error == nullptr);
}

TEST(RecordedFlightTest, RefusesAWanderThatBendsThePathTooMuch) {
  // 60 m in 3 s turn by 7 m/s2, eight times what 10 km at 173 m/s allow.
  Scene scene = SceneWithTrajectoryErrors();
  scene.trajectory_error.rms_m = {0.0, 60.0, 0.0};
  scene.trajectory_error.time_constant_s[1] = 3.0;
  try {
    (void)Simulate(scene);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                testing::HasSubstr("trajectory errors that bend the path less than 1/range"));
  }
}

}  // namespace
}  // namespace sarblock
