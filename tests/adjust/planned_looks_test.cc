// SPDX-License-Identifier: Apache-2.0
// A plan without rows of looks: every pass looks at what its swath shows.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "support/scene_blocks.h"
#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

/// The block as its files are, but with the header of its looks alone, read as a plan.
Block WithoutRows(const test::SceneBlock& scene) {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string("sarblock-plan-") + test->name() + std::to_string(::getpid());
  std::replace(name.begin(), name.end(), '/', '_');
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / name;
  files::WriteBlock(folder, scene.block, scene.options);
  std::ofstream(folder / "observations.csv") << "pass,point\n";
  files::ReadOptions read;
  read.measurements = files::Measurements::kOptional;
  Block plan = files::ReadBlock(folder, read).block;
  std::filesystem::remove_all(folder);
  return plan;
}

std::array<double, 3> MedianSigmas_m(const AdjustResult& result) {
  std::array<double, 3> median_m{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> sigmas_m;
    for (std::size_t j = 0; j < result.points.status.size(); ++j) {
      if (!std::isnan(result.points.covariance_m2[j][axis])) {
        sigmas_m.push_back(std::sqrt(result.points.covariance_m2[j][axis]));
      }
    }
    const auto middle = sigmas_m.begin() + static_cast<std::ptrdiff_t>(sigmas_m.size() / 2);
    std::nth_element(sigmas_m.begin(), middle, sigmas_m.end());
    median_m[axis] = *middle;
  }
  return median_m;
}

test::SceneBlock Small(const std::string& name) {
  test::SceneBlock scene = test::SmallSceneBlock(name);
  scene.options.covariance = CovarianceLevel::kBlock;
  if (scene.options.corrections == CorrectionChoice::kAuto) {
    scene.options.corrections = CorrectionChoice::kGiven;
  }
  return scene;
}

class PlanOfShippedSceneTest : public testing::TestWithParam<std::string> {};

// Two routes: the looks of the simulation on the paths as planned, and those of the swaths on the
// paths of the block as its files give them. They differ where a point lies on the border of a
// swath: by less than 2 % of the looks, and of the medians.
TEST_P(PlanOfShippedSceneTest, PredictsTheSameWithoutItsRows) {
  const test::SceneBlock scene = Small(GetParam());
  const Block plan = WithoutRows(scene);
  const auto looks = static_cast<double>(scene.block.looks.size());
  const Block filled = FillMeasurements(plan, scene.truth.points_m);
  EXPECT_NEAR(static_cast<double>(filled.looks.size()), looks, 0.02 * looks);
  for (std::size_t i = 0; i < plan.passes.size(); ++i) {
    EXPECT_EQ(plan.passes[i].recorded.effect.through, scene.block.passes[i].recorded.effect.through)
        << "the flight is read in another way";
  }
  if (GetParam() == "single-flight-squint") {  // one flight is no stereo, planned or not
    EXPECT_THROW(static_cast<void>(Predict(plan, scene.options, scene.truth.points_m)),
                 UndeterminedError);
    return;
  }
  const AdjustResult with = Predict(scene.block, scene.options, scene.truth.points_m);
  const AdjustResult without = Predict(plan, scene.options, scene.truth.points_m);
  const auto a = MedianSigmas_m(with), b = MedianSigmas_m(without);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(b[axis], a[axis], 0.02 * a[axis]);
}

std::vector<std::string> ScenesAndRecorded() {
  std::vector<std::string> names = test::SceneFiles();
  for (const std::string& name : test::SceneFiles("scenes/recorded")) {
    names.push_back("recorded/" + name);
  }
  return names;
}

INSTANTIATE_TEST_SUITE_P(Datasets,
                         PlanOfShippedSceneTest,
                         testing::ValuesIn(ScenesAndRecorded()),
                         [](const auto& scene) { return test::TestNameOf(scene.param); });

TEST(PlannedLooksTest, WithoutASwathThePlanSaysHowOftenItSeesAPoint) {
  test::SceneBlock scene = Small("block-12-strips");
  Block plan = WithoutRows(scene);
  for (Pass& pass : plan.passes) pass.swath.reset();
  const AdjustResult result = Predict(plan, scene.options, scene.truth.points_m);
  EXPECT_THAT(
      result.warnings,
      testing::Contains(HasSubstr("not every pass has a swath: each such pass sees all that "
                                  "is on its look side, ")));
  // By count: what a pass flies by between its first and last time, on its side.
  std::size_t seen = 0;
  for (const Pass& pass : plan.passes) {
    for (const Eigen::Vector3d& p_m : scene.truth.points_m) {
      const auto time_s = FindConeTime(pass.path, p_m, Cone{}, pass.start_s, pass.end_s);
      if (!time_s) continue;
      const Motion motion = *pass.path.At(*time_s);
      const double left = motion.velocity_mps.cross(p_m - motion.position_m).z();
      seen += (left > 0.0) == (pass.side == LookSide::kLeft) ? 1U : 0U;
    }
  }
  EXPECT_GT(seen, 2 * scene.block.looks.size());
  EXPECT_EQ(FillMeasurements(plan, scene.truth.points_m).looks.size(), seen);
}

TEST(PlannedLooksTest, LooksOutsideTheSwathAreWarnedOf) {
  test::SceneBlock scene = Small("leberl-aircraft");
  const auto outside = testing::Contains(HasSubstr("outside the swath of their pass"));
  EXPECT_THAT(Adjust(scene.block, scene.options).warnings, testing::Not(outside));
  std::swap(scene.block.passes[0].swath, scene.block.passes[1].swath);
  const AdjustResult adjusted = Adjust(scene.block, scene.options);
  EXPECT_THAT(adjusted.warnings, outside);
  EXPECT_THAT(CheckBlock(scene.block, scene.options).findings,
              testing::Contains(testing::AllOf(HasSubstr("outside the swath of their pass"),
                                               HasSubstr("swath_ground_m = ["))));
  EXPECT_THAT(IntersectBlock(scene.block, scene.options).warnings, outside);
}

// leberl-voir's paths are a kilometre off: intersected on them its points lie 15 km off.
TEST(PlannedLooksTest, AGoodBlockIsNotWarnedOfItsSwaths) {
  for (const char* name : {"leberl-aircraft", "leberl-voir", "moon-alse"}) {
    const test::SceneBlock scene = Small(name);
    EXPECT_THAT(CheckBlock(scene.block, scene.options).findings,
                testing::Not(testing::Contains(HasSubstr("outside the swath"))))
        << name;
  }
}

}  // namespace
}  // namespace sarblock
