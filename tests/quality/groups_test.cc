// SPDX-License-Identifier: Apache-2.0
// Groups of observations: what looks and control have of v'Pv and of the redundancy, against dense
// matrices; which blocks their tests and those of priors let pass.
#include "sarblock/adjust/adjust.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "quality/assess.h"
#include "quality/verdict_tests.h"
#include "support/dense_normals.h"
#include "support/joint_priors.h"
#include "support/scene_blocks.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

test::KnownBlock BlockWithControl(std::uint64_t seed, double noise = 1.0) {
  test::BlockPlan plan = test::AircraftPlan();
  plan.points = 40;
  test::KnownBlock known = test::MakeBlock(plan);
  for (const std::size_t point : {0U, 9U, 21U, 33U}) {
    test::AddKnownPoint(point, {0.31, 0.47, 0.83}, &known, PointRole::kControl, 0.4);
  }
  test::AddNoise(seed, noise, &known);
  return known;
}

AdjustOptions WithPriors_m(double constant_m, double drift_m) {
  PositionCorrection position;
  position.degree = 1;
  position.prior_sigma_m.fill({constant_m, drift_m});
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  return options;
}

const ObservationGroup& GroupOf(const AdjustResult& result, const std::string& name) {
  for (const ObservationGroup& group : result.assessment.groups) {
    if (group.name == name) return group;
  }
  throw std::out_of_range(name);
}

class GroupsOfPriorsTest : public testing::TestWithParam<bool> {
 protected:
  /// Priors that leave some corrections open, others not.
  static AdjustOptions Options() {
    return GetParam() ? test::WithJointPrior(PositionCorrection::Axes::kTrack, 5)
                      : WithPriors_m(2.9, 0.7);
  }
};

// Definition, with all equations as one dense matrix A, priors last: of the rows of looks and
// control the squares of the residuals, the trace of Q = I - A (A'A)^-1 A', and that of its square
// as the test of priors that are wider than the errors needs it.
TEST_P(GroupsOfPriorsTest, AreThoseOfTheDenseEquations) {
  const test::KnownBlock known = BlockWithControl(43);
  const AdjustOptions options = Options();
  const AdjustResult result = Adjust(known.block, options);
  ASSERT_TRUE(result.usable());
  AdjustmentProblem problem(known.block, options.groups, {}, options.priors);
  const BlockState state = test::StateOf(result, &problem);
  const test::DenseEquations dense = test::MakeDenseEquations(problem, state);
  const Eigen::MatrixXd& a = dense.jacobian;
  const auto priors = static_cast<Eigen::Index>(result.parameters.size());
  const Eigen::Index measured = a.rows() - priors;
  const Eigen::MatrixXd q_vv =
      Eigen::MatrixXd::Identity(a.rows(), a.rows()) - a * test::DenseCovariance(a) * a.transpose();
  const Eigen::MatrixXd of_measured = q_vv.topLeftCorner(measured, measured);
  EXPECT_NEAR(result.test_redundancy, of_measured.trace(), 1e-6);
  EXPECT_NEAR(result.sigma0_squared * result.test_redundancy,
              dense.residual.head(measured).squaredNorm(),
              1e-5);
  const PriorSums sums = SumPriors(problem.layout, state.corrections, result.parameter_covariance);
  ASSERT_TRUE(sums.known);
  EXPECT_NEAR(sums.square_sum, dense.residual.tail(priors).squaredNorm(), 1e-5);
  EXPECT_NEAR(sums.redundancy, q_vv.bottomRightCorner(priors, priors).trace(), 1e-6);
  EXPECT_GT(sums.unsure, 0.1) << "nothing is left to tell";
  EXPECT_NEAR(of_measured.trace() - sums.unsure, (of_measured * of_measured).trace(), 1e-6);
}
INSTANTIATE_TEST_SUITE_P(Priors, GroupsOfPriorsTest, testing::Bool());

// Invariance: the groups add to all observations.
TEST(GroupsTest, AddToAllObservations) {
  const AdjustResult result = Adjust(BlockWithControl(44).block, WithPriors_m(2.9, 1.7));
  ASSERT_EQ(result.assessment.groups.size(), 5U);
  double square = 0.0, redundancy = 0.0;
  for (const char* name : {"ranges", "azimuths", "control", "priors"}) {
    square += GroupOf(result, name).square_sum;
    redundancy += GroupOf(result, name).redundancy;
  }
  EXPECT_NEAR(square, 2.0 * result.final_cost, 1e-6);
  EXPECT_NEAR(redundancy, result.redundancy(), 1e-9);
  EXPECT_NEAR(GroupOf(result, "all").square_sum, square, 1e-6);
}

// Priors are opinions: a thousand times wider ones change neither the variance factor of looks and
// control nor the verdict. With all observations in one the factor was pulled below its interval.
TEST(GroupsTest, WidePriorsDiluteNothing) {
  const test::KnownBlock known = BlockWithControl(45, 2.0);
  const AdjustResult narrow = Adjust(known.block, WithPriors_m(2.9, 1.7));
  const AdjustResult wide = Adjust(known.block, WithPriors_m(2900.0, 1700.0));
  EXPECT_NEAR(wide.sigma0_squared, narrow.sigma0_squared, 0.03 * narrow.sigma0_squared);
  EXPECT_FALSE(wide.chi_square_passed);
  EXPECT_NEAR(std::sqrt(wide.sigma0_squared), 2.0, 0.3);
  EXPECT_LT(GroupOf(wide, "priors").factor(), 1e-4);
  EXPECT_LT(GroupOf(wide, "all").factor(), wide.sigma0_squared);
  const AdjustResult good = Adjust(BlockWithControl(45).block, WithPriors_m(2900.0, 1700.0));
  EXPECT_THAT(good.assessment.reasons, IsEmpty());
}

// A spline with knots 5 s apart under priors of 1,000 m, where the flights are off by 10 to 50 m:
// check points are nearer than expected, which is said and is no mistake of the block. Where looks
// are better than stated it is one.
TEST(GroupsTest, WidePriorsFailNoCheckPoints) {
  test::SceneBlock made = test::SimulatedSceneBlock(
      "scenes",
      "convergent-squint",
      {"seed=619300", "points.count=40", "control.count=9", "control.layout=\"perimeter\""});
  PositionCorrection spline;
  spline.basis = PositionCorrection::Basis::kSpline;
  spline.knot_spacing_s = 5.0;
  spline.prior_sigma_m.fill({1000.0});
  made.options.groups = {{"position", spline, {}, false}};
  const auto of_checks = HasSubstr("check points: errors are");
  const AdjustResult wide = Adjust(made.block, made.options);
  EXPECT_LT(wide.assessment.checks.chi_square, wide.assessment.checks.chi_square_interval.lower);
  EXPECT_THAT(wide.assessment.reasons, IsEmpty());
  EXPECT_THAT(wide.warnings,
              Contains(AllOf(of_checks, HasSubstr("times wider than what came out"))));
  const test::SceneBlock better = test::SimulatedSceneBlock(
      "scenes", "convergent-squint", {"seed=619300", "looks.noise_scale=0.2", "check.count=100"});
  EXPECT_THAT(Adjust(better.block, better.options).assessment.reasons,
              Contains(AllOf(of_checks, HasSubstr("standard deviations are stated too large"))));
}

// Paths 31 m off beside priors of 3 m: the first reason names the terms and how many times too
// tight they are; priors of a third of the error are used without a word.
TEST(GroupsTest, PriorsThatAreTooTightAreTheFirstReason) {
  test::KnownBlock known = BlockWithControl(46);
  for (std::size_t pass = 0; pass < known.block.passes.size(); ++pass) {
    test::ShiftPath(pass, {0.0, 0.0, 31.0}, &known.block);
  }
  const AdjustResult tight = Adjust(known.block, WithPriors_m(3.0, 1.0));
  ASSERT_FALSE(tight.assessment.reasons.empty());
  EXPECT_EQ(tight.assessment.verdict, Verdict::kTestsFailed);
  EXPECT_THAT(tight.assessment.reasons.front(),
              AllOf(HasSubstr("priors: the observations contradict those of position.up.0 ("),
                    HasSubstr("times too tight"),
                    Not(HasSubstr("position.up.1"))));
  const AdjustResult third = Adjust(known.block, WithPriors_m(31.0 / 2.9, 1.0));
  EXPECT_THAT(third.assessment.reasons, IsEmpty());
}

// Statistics: the band of a group is where v'Pv of a good block lies but once in 9,000, and never
// less than 2 % of the standard deviations: closed forms of the chi-square.
TEST(GroupsTest, ABandIsThatOfItsLevelAndOfASizeThatMatters) {
  const AdjustResult result = Adjust(BlockWithControl(47).block, WithPriors_m(2.9, 1.7));
  const ObservationGroup& ranges = GroupOf(result, "ranges");
  const double tail = 0.5 * (1.0 - 0.999) / 9.0;
  EXPECT_NEAR(ranges.band.upper * ranges.redundancy,
              ChiSquareQuantile(1.0 - tail, ranges.redundancy),
              1e-9);
  EXPECT_NEAR(LevelOfOneTest(0.999), 1.0 - 0.001 / 9.0, 1e-15);
  const double many = 1e6;  // the chi-square alone would leave 0.3 % of the standard deviation
  const GlobalTest test = TestMeasurements({.observations = 1000000}, {}, {.kept = many}, 0.999);
  EXPECT_NEAR(test.chi_square.lower, 0.98 * 0.98 * many, 1e-9 * many);
  EXPECT_NEAR(test.chi_square.upper, 1.02 * 1.02 * many, 1e-9 * many);
}

// Where covariances of the corrections were not asked for, priors cannot be told apart.
TEST(GroupsTest, WithoutCovariancesAllObservationsAreTested) {
  AdjustOptions options = WithPriors_m(2.9, 1.7);
  options.covariance = CovarianceLevel::kNone;
  const AdjustResult result = Adjust(BlockWithControl(48).block, options);
  ASSERT_EQ(result.assessment.groups.size(), 1U);
  EXPECT_EQ(result.assessment.groups.front().name, "all");
  EXPECT_NEAR(result.test_redundancy, result.redundancy(), 1e-12);
}

// Priors of kilometres for flights that are known to centimetres elsewhere say nothing, and where
// looks and control leave a correction open, that costs accuracy: a warning, no failed test.
TEST(GroupsTest, EmptyPriorsAreANoteWithTheirCost) {
  test::KnownBlock known = BlockWithControl(49);
  const AdjustResult wide = Adjust(known.block, WithPriors_m(2900.0, 1700.0));
  EXPECT_THAT(wide.warnings, Contains(HasSubstr("priors far wider than what came out")));
  EXPECT_EQ(wide.assessment.verdict, Verdict::kAccepted);
}

}  // namespace
}  // namespace sarblock
