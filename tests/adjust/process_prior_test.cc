// SPDX-License-Identifier: Apache-2.0
// Splines whose coefficients have a random walk or a Gauss-Markov process as their prior, against
// dense algebra with the covariance of all coefficients, the other engine, 50 digits and repeated
// noise.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "model/problem.h"
#include "quality/assess.h"
#include "quality/montecarlo.h"
#include "studies/exact.h"
#include "support/dense_normals.h"
#include "support/joint_priors.h"
#include "support/share_sums.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Process = PositionCorrection::Process;
using testing::HasSubstr;

PositionCorrection SplineOf(Process process, double knot_spacing_s) {
  PositionCorrection position;
  position.basis = PositionCorrection::Basis::kSpline;
  position.knot_spacing_s = knot_spacing_s;
  position.prior_sigma_m = {std::vector{1.3}, std::vector{2.1}, std::vector{1.7}};
  position.process = process;
  if (process == Process::kGaussMarkov) position.correlation_time_s = 3.1 * knot_spacing_s;
  if (process == Process::kRandomWalk) position.start_sigma_m = {0.9, 1.1, 0.7};
  return position;
}

AdjustOptions With(const PositionCorrection& position) {
  RangeCorrection range;
  range.bias = true;
  range.bias_prior_sigma_m = 0.9;
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}, {"range", range, {}, false}};
  options.tolerance = 1e-10;
  options.quality.consensus = false;
  return options;
}

test::KnownBlock NoisyBlock(bool orbit) {
  return test::NoisyBlockWithControl(orbit ? test::OrbitPlan() : test::AircraftPlan(3.0));
}

class ProcessPriorTest : public testing::TestWithParam<std::tuple<bool, Process>> {
 protected:
  ProcessPriorTest() : known_(NoisyBlock(std::get<0>(GetParam()))) {
    const Pass& pass = known_.block.passes.front();
    options_ = With(SplineOf(std::get<1>(GetParam()), (pass.end_s - pass.start_s) / 4.0));
  }
  test::KnownBlock known_;
  AdjustOptions options_;
};

// Second route: no elimination, and the inverse of the covariance of all coefficients with each
// other in place of the steps between neighbours.
TEST_P(ProcessPriorTest, IsTheDenseLeastSquaresSolution) {
  const AdjustResult result = Adjust(known_.block, options_);
  ASSERT_EQ(result.status, AdjustStatus::kConverged);
  AdjustmentProblem problem(known_.block, options_.groups);
  const BlockState state = test::StateOf(result, &problem);
  test::ExpectDenseLeastSquares(problem, state, result, 1e-7);
}

TEST_P(ProcessPriorTest, BothEnginesAgree) {
  options_.engine = Engine::kReduced;
  const AdjustResult reduced = Adjust(known_.block, options_);
  options_.engine = Engine::kCeres;
  options_.covariance_method = CovarianceMethod::kCeres;
  const AdjustResult ceres = Adjust(known_.block, options_);
  ASSERT_EQ(ceres.status, AdjustStatus::kConverged);
  test::ExpectSameCorrections(ceres, reduced);
}

// Higher precision: 50 digits with steps of their own code.
TEST_P(ProcessPriorTest, FiftyDigitsAgree) {
  const AdjustResult result = Adjust(known_.block, options_);
  AdjustmentProblem problem(known_.block, options_.groups);
  const ExactComparison exact = CompareWithExact(problem, result);
  EXPECT_EQ(exact.failure, "");
  EXPECT_LT(exact.error_sigma, 1e-7);
  EXPECT_LT(exact.sigma_error, 1e-9);
}

// Invariance: redundancy and v'Pv add up over looks, control and priors.
TEST_P(ProcessPriorTest, SharesAddToTheWholeBlock) {
  const AdjustResult result = Adjust(known_.block, options_);
  const test::ShareSums sums = test::SumShares(known_.block, result);
  EXPECT_NEAR(sums.redundancy, result.redundancy(), 1e-4);
  EXPECT_NEAR(sums.square_sum, 2.0 * result.final_cost, 1e-3);
}

// Seeded statistics: looks, control and priors drawn anew fill the covariance of the adjustment.
TEST_P(ProcessPriorTest, RepeatedNoiseFillsTheCovariance) {
  options_.covariance = CovarianceLevel::kMonteCarlo;
  options_.montecarlo_runs = 200;
  const AdjustResult result = Adjust(known_.block, options_);
  ASSERT_TRUE(result.montecarlo.has_value());
  EXPECT_EQ(result.montecarlo->failed, 0U);
  EXPECT_TRUE(result.montecarlo->square_ratio.Agrees()) << result.montecarlo->sentence;
}

INSTANTIATE_TEST_SUITE_P(
    Blocks,
    ProcessPriorTest,
    testing::Combine(testing::Bool(), testing::Values(Process::kRandomWalk, Process::kGaussMarkov)),
    [](const auto& of) {
      return std::string(std::get<0>(of.param) ? "Orbit" : "Aircraft") +
             (std::get<1>(of.param) == Process::kRandomWalk ? "Walk" : "Markov");
    });

// Closed forms: sigma of coefficient q is what a walk has gained there, and that of a Gauss-Markov
// process is the same everywhere.
TEST(ProcessLayoutTest, StandardDeviationsOfCoefficientsAreThoseOfTheProcess) {
  const test::KnownBlock known = NoisyBlock(false);
  const Pass& pass = known.block.passes.front();
  const double spacing_s = (pass.end_s - pass.start_s) / 4.0;  // 7 coefficients
  const CorrectionGroup walk{"position", SplineOf(Process::kRandomWalk, spacing_s), {}, false};
  const CorrectionGroup markov{"position", SplineOf(Process::kGaussMarkov, spacing_s), {}, false};
  const ParameterLayout walks = MakeParameterLayout(known.block, {walk});
  const ParameterLayout markovs = MakeParameterLayout(known.block, {markov});
  for (std::size_t q = 0; q < 7; ++q) {
    const Parameter& across = walks.parameters[3 * q + 1];
    const double gained = static_cast<double>(q) / 6.0;
    EXPECT_DOUBLE_EQ(across.prior_sigma, std::sqrt(1.1 * 1.1 + 2.1 * 2.1 * gained));
    EXPECT_EQ(across.before, q == 0 ? -1 : static_cast<int>(3 * q) - 2);
    const Parameter& up = markovs.parameters[3 * q + 2];
    EXPECT_DOUBLE_EQ(up.prior_sigma, 1.7);
    if (q == 0) continue;
    EXPECT_NEAR(up.carried, std::exp(-1.0 / 3.1), 1e-15);
    EXPECT_NEAR(up.step_sigma, 1.7 * std::sqrt(1.0 - std::exp(-2.0 / 3.1)), 1e-15);
  }
}

TEST(ProcessLayoutTest, RefusesWhatIsNoProcess) {
  const test::KnownBlock known = NoisyBlock(false);
  const auto refusal = [&](const PositionCorrection& position, CorrectionChoice choice) {
    AdjustOptions options = With(position);
    options.corrections = choice;
    try {
      (void)Adjust(known.block, options);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const auto given = CorrectionChoice::kGiven;
  PositionCorrection walk = SplineOf(Process::kRandomWalk, 10.0);
  EXPECT_THAT(refusal(walk, CorrectionChoice::kAuto), HasSubstr("priors that are independent"));
  walk.start_sigma_m[1] = kNotGiven;
  EXPECT_THAT(refusal(walk, given), HasSubstr("start_sigma_m"));
  PositionCorrection markov = SplineOf(Process::kGaussMarkov, 10.0);
  markov.correlation_time_s = 1e13;
  EXPECT_THAT(refusal(markov, given), HasSubstr("neighbours are one number"));
  markov.correlation_time_s = -1.0;
  EXPECT_THAT(refusal(markov, given), HasSubstr("correlation_time_s"));
  markov = SplineOf(Process::kGaussMarkov, 10.0);
  markov.prior_sigma_m = {};
  EXPECT_THAT(refusal(markov, given), HasSubstr("sigma_m"));
  markov = SplineOf(Process::kGaussMarkov, 10.0);
  markov.basis = PositionCorrection::Basis::kPolynomial;
  EXPECT_THAT(refusal(markov, given), HasSubstr("coefficients of a spline"));
}

}  // namespace
}  // namespace sarblock
