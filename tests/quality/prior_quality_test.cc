// SPDX-License-Identifier: Apache-2.0
// Tests of priors, against the definition with dense matrices and by what they must add up to.
#include "sarblock/adjust/adjust.h"

#include <cmath>
#include <vector>

#include "quality/assess.h"
#include "support/dense_normals.h"
#include "support/share_sums.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

AdjustOptions WithPriors() {
  PositionCorrection position;
  position.degree = 1;
  position.prior_sigma_m.fill({2.9, 1.7});
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  return options;
}

test::KnownBlock NoisyBlockWithControl() {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  test::AddKnownPoint(0, {0.31, 0.47, 0.83}, &known);
  test::AddKnownPoint(3, {0.53, 0.29, kNotGiven}, &known);
  test::AddKnownPoint(7, {0.43, 0.61, 0.71}, &known);
  test::AddNoise(41, 1.0, &known);
  return known;
}

// Definition: the diagonal of I - A (A'A)^-1 A' at the rows of the priors, A all equations at the
// solution as one dense matrix, and v / sqrt(r) of these rows. The nominal paths are off by meters
// in kilometers, and the sums end at a step of 1e-6 sigma.
TEST(PriorQualityTest, RedundancyAndTestAreThoseOfTheDenseEquations) {
  const test::KnownBlock known = NoisyBlockWithControl();
  const AdjustOptions options = WithPriors();
  const AdjustResult result = Adjust(known.block, options);
  ASSERT_TRUE(result.usable());
  AdjustmentProblem problem(known.block, options.groups);
  const BlockState state = test::StateOf(result, &problem);
  const test::DenseEquations dense = test::MakeDenseEquations(problem, state);
  const Eigen::MatrixXd q = test::DenseCovariance(dense.jacobian);
  const auto priors = static_cast<Eigen::Index>(result.parameters.size());
  for (Eigen::Index i = 0; i < priors; ++i) {
    const Eigen::Index row = dense.jacobian.rows() - priors + i;
    const Eigen::RowVectorXd a = dense.jacobian.row(row);
    const double r = 1.0 - (a * q * a.transpose())(0);
    const ParameterResult& p = result.parameters[static_cast<std::size_t>(i)];
    const PriorTest test = TestsOfPriors(result)[static_cast<std::size_t>(i)];
    EXPECT_NEAR(test.redundancy, r, 1e-6) << p.owner << ' ' << p.name;
    EXPECT_NEAR(test.w, dense.residual[row] / std::sqrt(r), 1e-4) << p.owner << ' ' << p.name;
  }
}

// Invariance: redundancy numbers of looks, control and priors add to the redundancy of the block,
// w^2 r to v'Pv, and the shares of the passes with the control are both. Redundancy numbers of
// looks are floats.
TEST(PriorQualityTest, SharesAddToTheWholeBlock) {
  const test::KnownBlock known = NoisyBlockWithControl();
  const AdjustResult result = Adjust(known.block, WithPriors());
  const std::vector<PassShare> shares = SharesOf(known.block, result);
  ASSERT_EQ(shares.size(), known.block.passes.size());
  for (const PassShare& share : shares) {
    EXPECT_GT(share.prior_redundancy, 0.0);
    EXPECT_GT(share.variance_factor(), 0.0);
  }
  const test::ShareSums sums = test::SumShares(known.block, result);
  EXPECT_NEAR(sums.redundancy, result.redundancy(), 1e-4);
  EXPECT_NEAR(sums.square_sum, 2.0 * result.final_cost, 1e-3);
}

// The mistake that no test of looks sees: the path of a pass is not its own.
TEST(PriorQualityTest, AWrongPathContradictsThePriors) {
  test::KnownBlock known = NoisyBlockWithControl();
  const AdjustResult right = Adjust(known.block, WithPriors());
  EXPECT_THAT(right.assessment.reasons,
              Not(Contains(HasSubstr("the observations contradict those"))));
  EXPECT_EQ(SummarisePriors(WithPriors(), right).above, 0U);
  // Moved by ten times what the prior allows instead of exchanged: the looks still intersect.
  test::ShiftPath(0, {0.0, 23.0, 17.0}, &known.block);
  const AdjustResult wrong = Adjust(known.block, WithPriors());
  EXPECT_THAT(wrong.assessment.reasons, Contains(HasSubstr("the observations contradict those")));
  const PriorSummary summary = SummarisePriors(WithPriors(), wrong);
  EXPECT_GT(summary.above, 0U);
  EXPECT_EQ(wrong.parameters[summary.worst].owner, known.block.passes[0].id);
}

// Nothing was measured: redundancy is geometry, a residual does not exist.
TEST(PriorQualityTest, APredictionHasRedundanciesButNoTests) {
  const test::KnownBlock known = NoisyBlockWithControl();
  const AdjustResult result = Predict(known.block, WithPriors(), known.truth_m);
  ASSERT_EQ(TestsOfPriors(result).size(), result.parameters.size());
  for (const PriorTest& test : TestsOfPriors(result)) {
    EXPECT_GT(test.redundancy, 0.0);
    EXPECT_TRUE(std::isnan(test.w));
  }
}

}  // namespace
}  // namespace sarblock
