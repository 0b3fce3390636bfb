// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"

#include <cmath>
#include <string>
#include <vector>

#include "model/problem.h"
#include "support/small_blocks.h"
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::Contains;
using testing::HasSubstr;

/// Twelve points in four passes, 48 looks; control of 3, 2 and 1 components; one check point.
test::KnownBlock CountedBlock() {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  test::AddKnownPoint(0, {0.2, 0.3, 0.4}, &known);
  test::AddKnownPoint(3, {0.2, 0.3, kNotGiven}, &known);
  test::AddKnownPoint(5, {kNotGiven, kNotGiven, 0.4}, &known);
  test::AddKnownPoint(8, {0.2, 0.2, 0.2}, &known, PointRole::kCheck);
  test::AddNoise(12, 1.0, &known);
  return known;
}

/// Three constants a pass, up with a prior; one range bias with a prior for all.
AdjustOptions CountedOptions() {
  PositionCorrection position;
  position.prior_sigma_m[2] = {3.0};
  RangeCorrection range;
  range.bias = true;
  range.bias_prior_sigma_m = 2.0;
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}, {"radar", range, {}, true}};
  return options;
}

TEST(CountsTest, AgreeWithThoseByHand) {
  const test::KnownBlock known = CountedBlock();
  const AdjustResult result = Adjust(known.block, CountedOptions());
  EXPECT_TRUE(result.usable());
  EXPECT_EQ(result.looks_used, 48U);
  EXPECT_EQ(result.observation_count,
            2U * 48U + (3U + 2U + 1U) + (4U + 1U));            // looks, control, priors
  EXPECT_EQ(result.parameter_count, 3U * 12U + 3U * 4U + 1U);  // points, corrections
  EXPECT_EQ(result.redundancy(), 107.0 - 49.0);
  ASSERT_FALSE(result.assessment.groups.empty());
  const ObservationGroup& all = result.assessment.groups.back();
  EXPECT_EQ(all.name, "all");
  EXPECT_EQ(all.redundancy, 58.0);
  EXPECT_NEAR(all.square_sum, 2.0 * result.final_cost, 1e-9);
  ASSERT_EQ(result.parameters.size(), 13U);
  EXPECT_EQ(result.parameters[0].owner, "radar");
  EXPECT_EQ(result.parameters[0].name, "range.bias");
  EXPECT_EQ(result.parameters[0].prior_sigma, 2.0);
  EXPECT_EQ(result.parameters[1].owner, "A1");
  EXPECT_EQ(result.parameters[1].name, "position.along.0");
  EXPECT_TRUE(std::isnan(result.parameters[1].prior_sigma));
  EXPECT_LT(result.parameters[0].sigma, 2.0) << "the observations add to the prior";
}

// Withheld: the check point's coordinates change nothing but its own error.
TEST(CountsTest, CheckPointsTakeNoPart) {
  test::KnownBlock known = CountedBlock();
  const AdjustResult before = Adjust(known.block, CountedOptions());
  ASSERT_EQ(before.checks.size(), 1U);
  EXPECT_EQ(before.checks[0].point, 8U);
  EXPECT_EQ(before.checks[0].components, 3);
  // In a local frame east, north and up are the axes.
  EXPECT_EQ(before.checks[0].error_enu_m,
            before.points.position_m[8] - known.block.points.given_m[8]);
  const Eigen::Vector3d shift_m(3.7, -2.1, 1.9);
  known.block.points.given_m[8] += shift_m;
  const AdjustResult after = Adjust(known.block, CountedOptions());
  for (std::size_t j = 0; j < 12; ++j) {
    EXPECT_EQ(after.points.position_m[j], before.points.position_m[j]) << j;
  }
  EXPECT_LT((after.checks[0].error_enu_m + shift_m - before.checks[0].error_enu_m).norm(), 1e-9);
  EXPECT_EQ(after.observation_count, before.observation_count);
}

// The definition: e' (s0^2 C + K)^-1 e, as the standard deviations beside it are scaled.
TEST(CountsTest, CheckPointsAreJudgedByScaledCovariancesWhereScalingIsAskedFor) {
  const test::KnownBlock known = CountedBlock();
  AdjustOptions options = CountedOptions();
  options.scale_by_posterior = true;
  const AdjustResult result = Adjust(known.block, options);
  ASSERT_EQ(result.checks.size(), 1U);
  const CheckResult& check = result.checks[0];
  ASSERT_GT(std::abs(result.sigma0_squared - 1.0), 0.05) << "nothing would be scaled";
  const KnownPosition* given = known.block.points.FindKnown(check.point);
  ASSERT_NE(given, nullptr);
  const std::array<double, 6>& c = result.points.covariance_m2[check.point];
  Eigen::Matrix3d full;
  full << c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2];  // ee nn uu en eu nu
  full += given->covariance_enu_m2;                              // s0^2 is in C
  EXPECT_NEAR(check.chi_square, check.error_enu_m.dot(full.inverse() * check.error_enu_m), 1e-9);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(check.sigma_enu_m[i], std::sqrt(full(i, i)), 1e-9);
}

TEST(CountsTest, PointsThatCannotBeKnownAreLeftOutWithTheirReason) {
  test::KnownBlock known = CountedBlock();
  const auto reject = [&known](std::size_t point, std::size_t pass) {
    known.block.looks.flags[4 * point + pass] |= Looks::kRejected;
  };
  for (const std::size_t pass : {1U, 2U, 3U}) reject(1, pass);  // one look, no control
  for (const std::size_t pass : {0U, 1U, 2U, 3U}) reject(2, pass);
  for (const std::size_t pass : {0U, 2U, 3U}) reject(5, pass);  // one look and a height
  const AdjustResult result = Adjust(known.block, CountedOptions());
  EXPECT_EQ(result.points.status[1], PointStatus::kTooFewLooks);
  EXPECT_THAT(result.points.reason[1], HasSubstr("one look"));
  EXPECT_EQ(result.points.status[2], PointStatus::kNotSeen);
  EXPECT_FALSE(result.points.reason[2].empty());
  EXPECT_EQ(result.points.status[5], PointStatus::kAdjusted) << "2 equations and a height";
  EXPECT_TRUE(result.points.reason[5].empty());
  EXPECT_STREQ(NameOf(result.points.status[1]), "too-few-looks");
  EXPECT_TRUE(result.points.position_m[1].array().isNaN().all());
  EXPECT_TRUE(std::isnan(result.points.covariance_m2[2][0]));
  EXPECT_THAT(result.warnings, Contains(HasSubstr("2 of 12 points are not determined")));
  // 36 looks of point 0, 3, 4, 6..11 and one of point 5; points 1 and 2 leave six unknowns.
  EXPECT_EQ(result.looks_used, 37U);
  EXPECT_EQ(result.observation_count, 74U + 6U + 5U);
  EXPECT_EQ(result.parameter_count, 43U);
  // Residuals of looks that count stand, those of points left out do not.
  EXPECT_TRUE(std::isnan(result.looks.range_residual_m[4]));
  EXPECT_TRUE(std::isfinite(result.looks.range_residual_m[0]));
}

TEST(CountsTest, ABlockWithoutAnyPointToSolveIsRefusedByName) {
  test::BlockPlan plan = test::AircraftPlan();
  plan.points = 3;
  plan.looks_per_point = 1;
  const test::KnownBlock known = test::MakeBlock(plan);
  try {
    static_cast<void>(Adjust(known.block, {}));
    FAIL() << "three points of one look were solved";
  } catch (const UndeterminedError& error) {
    EXPECT_THAT(error.names(), testing::ElementsAre("P1", "P2", "P3"));
    EXPECT_THAT(error.what(), HasSubstr("one look and no control"));
  }
}

TEST(CountsTest, TwoLooksAndNoCorrectionsHaveRedundancyOne) {
  test::BlockPlan plan = test::OrbitPlan();
  plan.points = 7;
  plan.looks_per_point = 2;
  test::KnownBlock known = test::MakeBlock(plan);
  test::AddNoise(3, 1.0, &known);
  const AdjustResult result = Adjust(known.block, {});
  EXPECT_EQ(result.redundancy(), 7.0);  // four equations of three unknowns each
  EXPECT_EQ(result.observation_count, 4U * 7U);
}

// Closed form: an azimuth of sigma_a metres at the target is sigma_a / |q| seconds there, q by
// docs/theory/observations.md, eq. (9).
TEST(WeightsTest, TurnMetresOfAzimuthIntoSecondsAtTheTarget) {
  test::BlockPlan plan = test::AircraftPlan(31.0);
  plan.sigma = {0.83, 1.7, AzimuthUnit::kMetres};
  const test::KnownBlock known = test::MakeBlock(plan);
  AdjustmentProblem problem(known.block, {});
  BlockState state;
  state.start_m = known.truth_m;
  state.displacement_m.assign(12, Eigen::Vector3d::Zero());
  UpdateWeights(state, &problem);
  const Motion motion = *known.block.passes[1].path.At(known.block.looks.time_s[5]);
  const TimeRates rates = LookTimeRates(known.truth_m[1],
                                        motion.position_m,
                                        motion.velocity_mps,
                                        motion.acceleration_mps2,
                                        known.block.ConeOf(5));
  EXPECT_NEAR(problem.weights[5].azimuth_per_unit, rates.along_mps / 1.7, 1e-9);
  // A nearly straight flight: its own speed at 31 degrees of squint, of which e_d shows cos^2.
  EXPECT_NEAR(rates.along_mps, motion.velocity_mps.norm(), 1e-3 * motion.velocity_mps.norm());
  EXPECT_LT(-rates.doppler_mps, 0.75 * rates.along_mps);
  EXPECT_DOUBLE_EQ(problem.weights[5].range_per_m, 1.0 / 0.83);
  EXPECT_LT(UpdateWeights(state, &problem), 1e-15) << "nothing moved";
}

TEST(WeightsTest, LeaveSecondsAsTheyAre) {
  test::BlockPlan plan = test::AircraftPlan(31.0);
  plan.sigma = {0.83, 7.3e-3, AzimuthUnit::kSeconds};
  const test::KnownBlock known = test::MakeBlock(plan);
  AdjustmentProblem problem(known.block, {});
  BlockState state;
  state.start_m = known.truth_m;
  state.displacement_m.assign(12, Eigen::Vector3d(400.0, -300.0, 200.0));
  UpdateWeights(state, &problem);
  EXPECT_DOUBLE_EQ(problem.weights[5].azimuth_per_unit, 1.0 / 7.3e-3);
}

TEST(WeightsTest, TheSolutionFromFarHasTheWeightsOfTheSolution) {
  test::BlockPlan plan = test::AircraftPlan(31.0);
  plan.sigma = {0.83, 1.7, AzimuthUnit::kMetres};
  test::KnownBlock known = test::MakeBlock(plan);
  test::AddNoise(8, 1.0, &known);
  const AdjustResult near = Adjust(known.block, {});
  for (std::size_t j = 0; j < 12; ++j) {
    known.block.points.given_m[j] = known.truth_m[j] + Eigen::Vector3d(900.0, 1300.0, 700.0);
  }
  const AdjustResult far = Adjust(known.block, {});
  ASSERT_TRUE(far.usable());
  for (std::size_t j = 0; j < 12; ++j) {
    // Sigmas are about a metre: weights of the start would shift points by centimetres.
    EXPECT_LT((far.points.position_m[j] - near.points.position_m[j]).norm(), 1e-5);
    EXPECT_NEAR(far.points.covariance_m2[j][0],
                near.points.covariance_m2[j][0],
                1e-6 * near.points.covariance_m2[j][0]);
  }
}

}  // namespace
}  // namespace sarblock
