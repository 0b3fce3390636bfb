// SPDX-License-Identifier: Apache-2.0
// The scenes of datasets/scenes, each on its own.
#include "sarblock/files/scene_file.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "simulate/true_path.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// Those of datasets/scenes, and of its folder `recorded` with its name before theirs.
std::vector<std::string> SceneNames() {
  const std::filesystem::path folder = std::string(SARBLOCK_DATASETS) + "/scenes";
  std::vector<std::string> names;
  for (const std::string part : {"", "recorded/"}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder / part)) {
      if (entry.path().extension() == ".toml") names.push_back(part + entry.path().stem().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

Scene Shipped(const std::string& name, const std::vector<std::string>& overrides = {}) {
  return files::ReadScene(std::string(SARBLOCK_DATASETS) + "/scenes/" + name + ".toml", overrides);
}

class ShippedSceneTest : public testing::TestWithParam<std::string> {};

TEST_P(ShippedSceneTest, IsNamedAsItsFileAndHasAPurpose) {
  const Scene scene = Shipped(GetParam());
  EXPECT_EQ(scene.name, std::filesystem::path(GetParam()).filename());
  EXPECT_GT(scene.purpose.size(), 40u);
  EXPECT_EQ(scene.purpose.back(), '.');
  EXPECT_NE(scene.adjust_toml.find("[adjust]"), std::string::npos);
}

TEST_P(ShippedSceneTest, ExactLooksLieOnSphereAndConeOfTheTruePath) {
  // Two routes: the observation equations at the simulator's own true path (1e-6 m), and at the
  // Hermite path through truth_passes (its velocity loses the acceleration jumps of the nominal
  // path times the errors: 1e-5 m in the cone at Venus; of gusts 3e-3 m between its states).
  const Scene scene = Shipped(GetParam(), {"looks.noise_scale=0", "points.count=150"});
  const SimulatedBlock simulated = Simulate(scene);
  const Looks& looks = simulated.block.looks;
  for (std::size_t point = 0; point < simulated.block.points.size(); ++point) {
    const Eigen::Vector3d& p_m = simulated.truth.points_m[point];
    for (auto i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      const std::uint32_t pass = looks.pass[i];
      const TruePath path = TruePathOf(scene, simulated, pass);
      Cone cone;
      cone.squint_rad = looks.cone.empty() ? 0.0 : looks.cone[i];
      const auto expect_on =
          [&](const std::optional<Motion>& motion, double bound_m, double cone_bound_m) {
            ASSERT_TRUE(motion.has_value());
            LookEquations equations;
            ASSERT_TRUE(EvaluateLookEquations(
                p_m, motion->position_m, motion->velocity_mps, cone, 0.0, &equations));
            EXPECT_NEAR(equations.rho_m, looks.range_m[i], bound_m);
            EXPECT_NEAR(equations.doppler_error_m, 0.0, cone_bound_m);
          };
      const bool gusts = simulated.trajectory_error != nullptr;
      expect_on(path.At(looks.time_s[i]), 1e-6, 1e-6);
      expect_on(simulated.truth.paths[pass].At(looks.time_s[i]),
                gusts ? 1e-5 : 1e-6,
                gusts ? 3e-3 : 1e-5);
    }
  }
}

TEST_P(ShippedSceneTest, ShowsItsPointsAndControlInStereo) {
  const Scene scene = Shipped(GetParam());
  const SimulatedBlock simulated = Simulate(scene);
  const Points& points = simulated.block.points;
  const Looks& looks = simulated.block.looks;
  std::size_t ties = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t count = looks.offsets[i + 1] - looks.offsets[i];
    EXPECT_GE(count, 2u) << points.ids[i];
    ties += points.role[i] == PointRole::kTie ? 1u : 0u;
  }
  EXPECT_GE(static_cast<double>(ties), 0.9 * static_cast<double>(scene.points.count));
  for (const Pass& pass : simulated.block.passes) EXPECT_LT(pass.start_s, pass.end_s) << pass.id;
  std::vector<std::size_t> of_pass(simulated.block.passes.size());
  for (const std::uint32_t pass : looks.pass) ++of_pass[pass];
  EXPECT_GE(*std::min_element(of_pass.begin(), of_pass.end()), 10u);
}

INSTANTIATE_TEST_SUITE_P(Datasets,
                         ShippedSceneTest,
                         testing::ValuesIn(SceneNames()),
                         [](const auto& scene) {
                           std::string name = scene.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           std::replace(name.begin(), name.end(), '/', '_');
                           return name;
                         });

TEST(BlockOfStripsTest, SeesEveryPointAsOftenAsItsOverlapSays) {
  // Hand arithmetic: strip k images y from 13000 + 4800 k to 25000 + 4800 k (60 percent overlap);
  // W images x from 2000 to 14000, E from 46000 to 58000. In the interior 12000/4800 = 2.5 strips.
  const SimulatedBlock simulated = Simulate(Shipped("block-12-strips", {"points.min_looks=0"}));
  const Looks& looks = simulated.block.looks;
  double interior = 0.0, interior_looks = 0.0;
  for (std::size_t i = 0; i < simulated.block.points.size(); ++i) {
    const Eigen::Vector3d& p_m = simulated.truth.points_m[i];
    std::size_t strips = 0;
    for (int k = 0; k < 12; ++k) {
      strips += p_m.y() >= 13000 + 4800 * k && p_m.y() <= 25000 + 4800 * k ? 1u : 0u;
    }
    const bool west = p_m.x() >= 2000 && p_m.x() <= 14000;
    const bool east = p_m.x() >= 46000 && p_m.x() <= 58000;
    EXPECT_EQ(looks.offsets[i + 1] - looks.offsets[i],
              strips + (west ? 1u : 0u) + (east ? 1u : 0u));
    if (p_m.y() > 25000 && p_m.y() < 65800) {
      interior += 1.0;
      interior_looks += static_cast<double>(strips);
    }
  }
  EXPECT_NEAR(interior_looks / interior, 2.5, 4.0 * 0.5 / std::sqrt(interior));
}

TEST(SingleFlightSquintTest, BothCirclesOfAPointCoincide) {
  // Leberl (1979), Fig. 5: same plane across the line, same radius. Without noise to 1e-6 m.
  const SimulatedBlock simulated =
      Simulate(Shipped("single-flight-squint", {"looks.noise_scale=0"}));
  const Looks& looks = simulated.block.looks;
  for (std::size_t i = 0; i < simulated.block.points.size(); ++i) {
    ASSERT_EQ(looks.offsets[i + 1] - looks.offsets[i], 2u);
    const std::size_t f = looks.offsets[i], b = f + 1;
    const auto centre_x_m = [&](std::size_t k) {
      return -12000.0 + 180.0 * looks.time_s[k] + looks.range_m[k] * std::sin(looks.cone[k]);
    };
    EXPECT_NEAR(centre_x_m(f), centre_x_m(b), 1e-6);
    EXPECT_NEAR(looks.range_m[f], looks.range_m[b], 1e-6);
    EXPECT_LT(looks.time_s[f], looks.time_s[b]);  // forward first
  }
}

}  // namespace
}  // namespace sarblock
