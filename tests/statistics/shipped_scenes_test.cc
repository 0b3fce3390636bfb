// SPDX-License-Identifier: Apache-2.0
// The shipped scenes at their full size, each with its own [adjust].
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "geometry/track_axes.h"
#include "statistics/scene_statistics.h"
#include "support/scene_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr const char* kRefusedScene = "single-flight-squint";

std::vector<std::string> GoodSceneNames() {
  std::vector<std::string> names = test::SceneFiles();
  std::erase(names, kRefusedScene);
  return names;
}

class GoodSceneTest : public testing::TestWithParam<std::string> {};

TEST_P(GoodSceneTest, IsAdjustedAsItStands) {
  // Seeded statistics, one draw with the scene's own seed: v'Pv in its region at 99.9 percent.
  const Scene scene = test::ShippedScene(GetParam());
  const SimulatedBlock simulated = Simulate(scene);
  const AdjustResult result = Adjust(simulated.block, test::OptionsOf(scene, simulated.block));
  EXPECT_TRUE(result.usable());
  EXPECT_EQ(
      std::count(result.points.status.begin(), result.points.status.end(), PointStatus::kAdjusted),
      static_cast<std::ptrdiff_t>(simulated.block.points.size()));
  EXPECT_GT(result.redundancy(), 200.0);
  EXPECT_TRUE(ChiSquareInterval(0.999, result.redundancy()).Contains(2.0 * result.final_cost))
      << result.sigma0_squared;
  EXPECT_EQ(result.assessment.verdict, Verdict::kAccepted)
      << testing::PrintToString(result.assessment.reasons);
}

/// The path moved by a constant in its own track axes.
FlightPath Displaced(const Frame& frame, const FlightPath& path, const Eigen::Vector3d& track_m) {
  std::vector<StateVector> states = path.states();
  for (StateVector& state : states) {
    const TrackAxes axes = TrackAxesOf(frame, *path.At(state.time_s));
    state.position_m += axes.axes * track_m;
    state.velocity_mps += axes.rate * track_m;
  }
  return FlightPath(std::move(states));
}

// Invariance: 5 km wrong in the points' start values and 2 km in every flight path change nothing
// but the corrections. The priors of the constant terms are widened so that they allow the error;
// turning axes leave the small rest of the bound.
TEST_P(GoodSceneTest, ConvergesFromStartErrorsOfKilometres) {
  const Scene scene = test::ShippedScene(GetParam());
  const SimulatedBlock simulated = Simulate(scene);
  AdjustOptions options = test::OptionsOf(scene, simulated.block);
  for (CorrectionGroup& group : options.groups) {
    auto& position = std::get<PositionCorrection>(group.model);
    for (std::vector<double>& sigma_m : position.prior_sigma_m) sigma_m.at(0) = 1e5;
  }
  const AdjustResult plain = Adjust(simulated.block, options);
  ASSERT_TRUE(plain.usable()) << testing::PrintToString(plain.warnings);

  Block block = simulated.block;
  for (std::size_t i = 0; i < block.passes.size(); ++i) {
    const double angle_rad = 2.4 * static_cast<double>(i) + 0.3;  // another direction a pass
    const Eigen::Vector3d track_m(2000.0 * std::cos(angle_rad),
                                  1400.0 * std::sin(angle_rad),
                                  1400.0 * std::sin(1.0 + angle_rad));
    block.passes[i].path = Displaced(block.frame, block.passes[i].path, track_m);
  }
  for (std::size_t j = 0; j < block.points.size(); ++j) {
    if (block.points.role[j] != PointRole::kTie) continue;
    const double angle_rad = 1.7 * static_cast<double>(j);
    const Eigen::Vector3d enu_m(4920.0 * std::cos(angle_rad), 4920.0 * std::sin(angle_rad), 900.0);
    block.points.given_m[j] =
        simulated.truth.points_m[j] +
        block.frame.EnuFromFrame(simulated.truth.points_m[j]).transpose() * enu_m;
  }
  const AdjustResult moved = Adjust(block, options);
  EXPECT_TRUE(moved.usable()) << testing::PrintToString(moved.warnings);
  for (std::size_t j = 0; j < block.points.size(); ++j) {
    ASSERT_EQ(moved.points.status[j], PointStatus::kAdjusted) << moved.points.reason[j];
    const SymmetricEnu& q = plain.points.covariance_m2[j];
    const double sigma_m = std::sqrt(q[0] + q[1] + q[2]);
    EXPECT_LT((moved.points.position_m[j] - plain.points.position_m[j]).norm(), 0.02 * sigma_m)
        << block.points.ids[j];
  }
}

INSTANTIATE_TEST_SUITE_P(Datasets,
                         GoodSceneTest,
                         testing::ValuesIn(GoodSceneNames()),
                         [](const auto& scene) { return test::TestNameOf(scene.param); });

TEST(SingleFlightSquintTest, IsRefused) {
  // Leberl (1979), Fig. 5: both circles of every point coincide.
  const Scene scene = test::ShippedScene(kRefusedScene);
  const SimulatedBlock simulated = Simulate(scene);
  EXPECT_THROW(static_cast<void>(Adjust(simulated.block, test::OptionsOf(scene, simulated.block))),
               UndeterminedError);
}

}  // namespace
}  // namespace sarblock
