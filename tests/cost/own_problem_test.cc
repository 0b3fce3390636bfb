// SPDX-License-Identifier: Apache-2.0
// The public cost functions in a ceres::Problem of one's own against Adjust(): two routes, which
// share the paths and the equations of a look, and neither start values, engine, normal equations
// nor covariances. Bounds: 1e-6 standard deviations of corrections and points, 1e-9 of covariances.
#include "cost/own_problem.h"

#include <string>
#include <vector>

#include "support/scene_blocks.h"
#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

void ExpectTheSolutionOfAdjust(const Block& block, AdjustOptions options) {
  // Far below the bound: what is compared is the solution, not where its iteration ended.
  options.tolerance = 1e-9;
  const AdjustResult result = Adjust(block, options);
  ASSERT_EQ(result.status, AdjustStatus::kConverged);
  test::OwnProblem own(block, options.groups, result);
  own.Solve();
  EXPECT_LT(own.LargestParameterDifference(), 1e-6);
  EXPECT_LT(own.LargestPointDifference(), 1e-6);
  EXPECT_LT(own.LargestCovarianceDifference(), 1e-9);
}

class OwnProblemTest : public testing::TestWithParam<std::string> {};

TEST_P(OwnProblemTest, HasTheSolutionOfAdjust) {
  const test::SceneBlock scene = test::SmallSceneBlock(GetParam());
  ExpectTheSolutionOfAdjust(scene.block, scene.options);
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         OwnProblemTest,
                         testing::Values("block-12-strips",
                                         "convergent-squint",
                                         "cross-wise",
                                         "different-altitudes",
                                         "earth-asc-desc",
                                         "earth-same-side",
                                         "moon-alse",
                                         "opposite-side",
                                         "venus-magellan"),
                         [](const auto& scene) { return test::TestNameOf(scene.param); });

/// Corrections of every kind with priors, some shared by all passes.
std::vector<CorrectionGroup> EveryKind(bool spline) {
  PositionCorrection position;
  position.degree = 1;
  position.prior_sigma_m = {std::vector<double>{4.0, 1.5}, {4.0, 1.5}, {3.0, 1.0}};
  if (spline) {
    position.basis = PositionCorrection::Basis::kSpline;
    position.knot_spacing_s = 90.0;
    position.prior_sigma_m = {std::vector<double>{4.0}, {4.0}, {3.0}};
  }
  VelocityCorrection velocity;
  velocity.prior_sigma = {2e-5, 3e-5};
  RangeCorrection bias;
  bias.bias = true;
  bias.bias_prior_sigma_m = 1.7;
  RangeCorrection scale;
  scale.scale = true;
  scale.scale_prior_sigma = 4e-6;
  TroposphereCorrection air;
  air.zenith_prior_sigma_m = 0.06;
  return {{"position", position, {}, false},
          {"velocity", velocity, {}, false},
          {"bias", bias, {}, false},
          {"scale", scale, {}, true},
          {"time", TimeCorrection{3e-3}, {}, false},
          {"squint", SquintCorrection{4e-5}, {}, true},
          {"air", air, {}, true}};
}

TEST(OwnProblemTest, HasThatOfEveryKindOfCorrection) {
  test::SceneBlock scene = test::SmallSceneBlock("block-12-strips");
  scene.options.groups = EveryKind(false);
  ExpectTheSolutionOfAdjust(scene.block, scene.options);
}

TEST(OwnProblemTest, HasThatOfSplines) {
  test::SceneBlock scene = test::SmallSceneBlock("block-12-strips");
  scene.options.groups = EveryKind(true);
  ExpectTheSolutionOfAdjust(scene.block, scene.options);
}

TEST(OwnProblemTest, HasThatOfEveryKindOfCorrectionInOrbit) {
  test::SceneBlock scene = test::SmallSceneBlock("earth-asc-desc");
  scene.options.groups = EveryKind(false);
  ExpectTheSolutionOfAdjust(scene.block, scene.options);
}

TEST(OwnProblemTest, HasThatOfASplineThatPassesShareInTheAxesOfTheFrame) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan(7.0));
  test::AddKnownPoint(0, {0.3, 0.3, 0.4}, &known);
  test::AddKnownPoint(7, {0.3, 0.3, 0.4}, &known);
  test::AddNoise(3, 1.0, &known);
  PositionCorrection position;
  position.basis = PositionCorrection::Basis::kSpline;
  position.axes = PositionCorrection::Axes::kFrame;
  position.knot_spacing_s = 20.0;
  position.components = {true, false, true};
  position.prior_sigma_m = {std::vector<double>{2.0}, {}, {1.3}};
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"drift", position, {}, true}};
  ExpectTheSolutionOfAdjust(known.block, options);
}

TEST(OwnProblemTest, HasThatOfMeasuredDopplers) {
  test::BlockPlan plan = test::AircraftPlan(11.0, true);
  plan.sigma = {0.7, 1.9, AzimuthUnit::kHertz};
  test::KnownBlock known = test::MakeBlock(plan);
  test::AddKnownPoint(2, {0.3, 0.3, 0.4}, &known);
  test::AddKnownPoint(9, {0.3, 0.3, 0.4}, &known);
  test::AddNoise(5, 1.0, &known);
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = EveryKind(false);
  ExpectTheSolutionOfAdjust(known.block, options);
}

}  // namespace
}  // namespace sarblock
