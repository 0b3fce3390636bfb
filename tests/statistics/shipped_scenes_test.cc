// SPDX-License-Identifier: Apache-2.0
// The shipped scenes at their full size, each with its own [adjust].
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/simulate/simulate.h"

#include <algorithm>
#include <string>

#include "statistics/scene_statistics.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr const char* kRefusedScene = "single-flight-squint";

std::vector<std::string> GoodSceneNames() {
  std::vector<std::string> names = test::ShippedSceneNames();
  names.erase(std::remove(names.begin(), names.end(), kRefusedScene), names.end());
  return names;
}

class GoodSceneTest : public testing::TestWithParam<std::string> {};

TEST_P(GoodSceneTest, IsAdjustedAsItStands) {
  // Seeded statistics, one draw with the scene's own seed: v'Pv in its region at 99.9 percent.
  const Scene scene = test::ShippedScene(GetParam());
  const SimulatedBlock simulated = Simulate(scene);
  const AdjustResult result = Adjust(simulated.block, test::OptionsOf(scene, simulated.block));
  EXPECT_TRUE(result.accepted);
  EXPECT_EQ(
      std::count(result.points.status.begin(), result.points.status.end(), PointStatus::kAdjusted),
      static_cast<std::ptrdiff_t>(simulated.block.points.size()));
  EXPECT_GT(result.redundancy(), 200.0);
  EXPECT_TRUE(ChiSquareInterval(0.999, result.redundancy())
                  .Contains(result.sigma0_squared * result.redundancy()))
      << result.sigma0_squared;
}

INSTANTIATE_TEST_SUITE_P(Datasets,
                         GoodSceneTest,
                         testing::ValuesIn(GoodSceneNames()),
                         [](const auto& scene) {
                           std::string name = scene.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(SingleFlightSquintTest, IsRefused) {
  // Leberl (1979), Fig. 5: both circles of every point coincide.
  const Scene scene = test::ShippedScene(kRefusedScene);
  const SimulatedBlock simulated = Simulate(scene);
  EXPECT_THROW(static_cast<void>(Adjust(simulated.block, test::OptionsOf(scene, simulated.block))),
               UndeterminedError);
}

}  // namespace
}  // namespace sarblock
