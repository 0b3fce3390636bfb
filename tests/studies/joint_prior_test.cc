// SPDX-License-Identifier: Apache-2.0
// Joint priors in the studies. Evidence: the same adjustment in 50 digits, whose factor of the
// prior is its own, and two more routes of the covariance.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/model/result.h"

#include <optional>
#include <vector>

#include "solve/start.h"
#include "studies/densification.h"
#include "studies/exact.h"
#include "studies/stability.h"
#include "support/joint_priors.h"
#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

class JointPriorStudyTest : public testing::Test {
 protected:
  JointPriorStudyTest()
      : known_(test::MakeBlock(test::OrbitPlan())),
        options_(test::WithJointPrior(PositionCorrection::Axes::kFrame, 53)) {
    test::AddKnownPoint(0, {0.31, 0.47, 0.83}, &known_);
    test::AddNoise(71, 1.0, &known_);
    options_.tolerance = 1e-10;
    result_ = Adjust(known_.block, options_);
    problem_.emplace(known_.block, options_.groups, Simplified{}, options_.priors);
    state_ = ComputeStartValues(&*problem_, nullptr).state;
    for (std::size_t i = 0; i < state_.start_m.size(); ++i) {
      state_.displacement_m[i] = result_.points.position_m[i] - state_.start_m[i];
    }
    for (std::size_t i = 0; i < result_.parameters.size(); ++i) {
      state_.corrections[static_cast<Eigen::Index>(i)] = result_.parameters[i].value;
    }
    UpdateWeights(state_, &*problem_);
  }
  test::KnownBlock known_;
  AdjustOptions options_;
  AdjustResult result_;
  std::optional<AdjustmentProblem> problem_;
  BlockState state_;
};

TEST_F(JointPriorStudyTest, AgreesWithFiftyDigits) {
  ASSERT_EQ(result_.status, AdjustStatus::kConverged);
  const ExactComparison exact = CompareWithExact(*problem_, result_);
  ASSERT_EQ(exact.failure, "");
  EXPECT_LT(exact.error_sigma, 1e-6);
  EXPECT_LT(exact.covariance_error, 1e-8);
  EXPECT_LT(exact.sigma_error, 1e-8);
  const std::vector<SymmetricEnu> normals =
      CovariancesByNormals(*problem_, state_, Precision::kDouble);
  EXPECT_LT(CovarianceError(normals, exact.covariance_m2), 1e-6);
  // A mutation kept as a test: without the correlations the digits are gone.
  AdjustOptions plain = options_;
  const Eigen::VectorXd variance = options_.priors[0].covariance.matrix().diagonal();
  plain.priors[0].covariance = variance.asDiagonal();
  EXPECT_GT(CompareWithExact(*problem_, Adjust(known_.block, plain)).covariance_error, 1e-3);
}

TEST(JointPriorNavigationTest, PriorsOfAStudyAreDrawnFromTheirMatrix) {
  AdjustOptions options = test::WithJointPrior(PositionCorrection::Axes::kFrame, 59);
  const SceneNavigation drawn = NavigationFromPriors(options, SceneNavigation{});
  ASSERT_EQ(drawn.joint.size(), 1U);
  EXPECT_EQ(drawn.joint[0].covariance, options.priors[0].covariance);
  EXPECT_EQ(drawn.range_bias_sigma_m, 0.0);
  AdjustOptions part = options;
  part.priors[0].parameters.erase(part.priors[0].parameters.begin());
  part.priors[0].covariance = Eigen::MatrixXd::Identity(6, 6);
  EXPECT_THROW(static_cast<void>(NavigationFromPriors(part, SceneNavigation{})), InputError);
  options.priors[0].passes = {"A1"};
  EXPECT_THROW(static_cast<void>(NavigationFromPriors(options, SceneNavigation{})), InputError);
}

}  // namespace
}  // namespace sarblock
