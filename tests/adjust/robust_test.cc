// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "model/problem.h"
#include "support/scene_blocks.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr RobustLoss kLosses[] = {RobustLoss::kHuber, RobustLoss::kCauchy, RobustLoss::kTukey};

// Hand arithmetic with a = 2, whitened lengths 1, 3 and 5.
TEST(RobustLossTest, AgreesWithHandValues) {
  const auto check = [](RobustLoss loss, double square, double value, double weight) {
    const RobustValue at = EvaluateLoss(loss, 2.0, square);
    EXPECT_NEAR(at.loss, value, 1e-14);
    EXPECT_NEAR(at.weight, weight, 1e-15);
  };
  check(RobustLoss::kNone, 25.0, 25.0, 1.0);
  check(RobustLoss::kHuber, 1.0, 1.0, 1.0);
  check(RobustLoss::kHuber, 9.0, 8.0, 2.0 / 3.0);  // 2*2*3 - 4
  check(RobustLoss::kHuber, 25.0, 16.0, 0.4);
  check(RobustLoss::kCauchy, 1.0, 4.0 * std::log(1.25), 0.8);
  check(RobustLoss::kCauchy, 9.0, 4.0 * std::log(3.25), 4.0 / 13.0);
  check(RobustLoss::kTukey, 1.0, 37.0 / 48.0, 9.0 / 16.0);  // 4/3 (1 - (3/4)^3)
  check(RobustLoss::kTukey, 9.0, 4.0 / 3.0, 0.0);
}

// Definition: the weight is the derivative of the loss; both are continuous at the scale.
TEST(RobustLossTest, WeightIsTheDerivativeAndBothAreContinuousAtTheScale) {
  for (const RobustLoss loss : kLosses) {
    for (const double square : {0.37, 2.9, 5.6, 11.3, 41.0}) {
      constexpr double kStep = 1e-4;
      const double slope = (EvaluateLoss(loss, 2.3, square + kStep).loss -
                            EvaluateLoss(loss, 2.3, square - kStep).loss) /
                           (2.0 * kStep);
      EXPECT_NEAR(EvaluateLoss(loss, 2.3, square).weight, slope, 1e-9) << square;
    }
    const double b = 2.3 * 2.3;
    const RobustValue below = EvaluateLoss(loss, 2.3, b * (1.0 - 1e-12));
    const RobustValue above = EvaluateLoss(loss, 2.3, b * (1.0 + 1e-12));
    EXPECT_NEAR(below.loss, above.loss, 1e-10);
    EXPECT_NEAR(below.weight, above.weight, 1e-10);
  }
}

/// Efficiency of a location estimate under a loss where errors are normal, psi = x w(x^2):
/// E[psi']^2 / E[psi^2], and E[psi'] = E[x psi].
double NormalEfficiency(RobustLoss loss, double scale) {
  double slope = 0.0, square = 0.0, one = 0.0;
  for (double x = -12.0; x < 12.0; x += 1e-3) {
    const double density = std::exp(-0.5 * x * x),
                 psi = x * EvaluateLoss(loss, scale, x * x).weight;
    one += density;
    slope += density * x * psi;
    square += density * psi * psi;
  }
  return slope * slope / (square * one);
}

// Definition: 95 percent efficiency, to the three decimals in which the scales are published
// (Holland and Welsch 1977).
TEST(RobustLossTest, TheScaleIsTheGivenOneOrTheLosssOwn) {
  AdjustOptions options;
  EXPECT_EQ(RobustScale(options), 0.0);
  for (const RobustLoss loss : kLosses) {
    options.robust = loss;
    EXPECT_NEAR(NormalEfficiency(loss, RobustScale(options)), 0.95, 2e-5);
  }
  options.robust_scale = 3.1;
  EXPECT_EQ(RobustScale(options), 3.1);
}

/// 60 points with control among them, ranges of some looks wrong by 40 sigmas.
struct GrossErrors {
  test::KnownBlock known;
  std::set<std::size_t> planted;
  AdjustOptions options;
};

/// Eight passes, because a loss cannot detect a blunder in a look that nothing else controls; with
/// `few_passes` only four of them.
GrossErrors MakeGrossErrors(double noise, bool few_passes = false) {
  test::BlockPlan plan = test::AircraftPlan();
  plan.points = 60;
  for (const test::PassPlan& pass : test::AircraftPlan().passes) {
    if (few_passes) break;
    plan.passes.push_back(pass);
    plan.passes.back().ground_range_m += 2930.0;
    plan.passes.back().heading_deg += 181.7;
    plan.passes.back().side = pass.side == LookSide::kLeft ? LookSide::kRight : LookSide::kLeft;
  }
  GrossErrors out{test::MakeBlock(plan), {}, {}};
  for (const std::size_t j : {1U, 17U, 31U, 44U})
    test::AddKnownPoint(j, {0.2, 0.2, 0.2}, &out.known);
  test::AddNoise(77, noise, &out.known);
  for (const std::size_t i : {22U, 75U, 111U, 150U, 229U, 266U, 309U, 360U, 421U, 473U}) {
    if (i >= out.known.block.looks.size()) break;
    // Of four passes only one looks right: nothing would control a blunder in it.
    if (few_passes && i % 4 == 2) continue;
    out.known.block.looks.range_m[i] += (i % 2 == 0 ? 40.0 : -40.0) * 0.83;
    out.planted.insert(i);
  }
  PositionCorrection position;
  position.prior_sigma_m.fill({5.0});
  out.options.corrections = CorrectionChoice::kGiven;
  out.options.groups = {{"position", position, {}, false}};
  return out;
}

/// Largest error of a point in its own sigmas, sqrt(e' Q^-1 e / 3).
double WorstPoint(const GrossErrors& errors, const AdjustResult& result) {
  double worst = 0.0;
  for (std::size_t j = 0; j < errors.known.truth_m.size(); ++j) {
    worst = std::max(worst,
                     test::DistanceInSigmas(errors.known.block.frame,
                                            result.points.position_m[j],
                                            errors.known.truth_m[j],
                                            result.points.covariance_m2[j]));
  }
  return worst / std::sqrt(3.0);
}

std::set<std::size_t> Dropped(const AdjustResult& result) {
  std::set<std::size_t> dropped;
  for (std::size_t i = 0; i < result.looks.rejected.size(); ++i) {
    if (result.looks.rejected[i] != 0) dropped.insert(i);
  }
  return dropped;
}

// Seeded statistics: of 60 chi-square variables of 3 degrees none is above the quantile
// 1 - 0.001/60 with probability 0.999. Least squares is pulled off far beyond. Of 470 good looks
// the threshold of 99.9 percent takes 0.5 by chance, more than 4 in one draw of 6000.
TEST(GrossErrorTest, RobustLossesRecoverTheTruthWithinItsSigmas) {
  GrossErrors errors = MakeGrossErrors(1.0);
  const double bound = std::sqrt(ChiSquareQuantile(1.0 - 0.001 / 60.0, 3.0) / 3.0);
  errors.options.quality.consensus = false;
  const AdjustResult plain = Adjust(errors.known.block, errors.options);
  EXPECT_EQ(plain.status, AdjustStatus::kConverged);
  EXPECT_GT(plain.sigma0_squared, 10.0);
  EXPECT_FALSE(plain.usable());
  EXPECT_GT(WorstPoint(errors, plain), 2.0 * bound);
  for (const RobustLoss loss : kLosses) {
    errors.options.robust = loss;
    const AdjustResult result = Adjust(errors.known.block, errors.options);
    EXPECT_TRUE(result.usable()) << static_cast<int>(loss)
                                 << testing::PrintToString(result.warnings);
    EXPECT_LT(WorstPoint(errors, result), bound) << static_cast<int>(loss);
    EXPECT_TRUE(result.chi_square_passed) << static_cast<int>(loss);
    const std::set<std::size_t> dropped = Dropped(result);
    EXPECT_TRUE(std::includes(
        dropped.begin(), dropped.end(), errors.planted.begin(), errors.planted.end()));
    EXPECT_LE(dropped.size(), errors.planted.size() + 4);
    EXPECT_EQ(result.looks_used, 480 - dropped.size());
  }
}

// With half the noise no good look comes near the threshold (it would need 7.4 sigmas): what is
// dropped is what was planted.
TEST(GrossErrorTest, TheLooksDroppedAreThePlantedOnes) {
  GrossErrors errors = MakeGrossErrors(0.5);
  for (const RobustLoss loss : kLosses) {
    errors.options.robust = loss;
    const AdjustResult result = Adjust(errors.known.block, errors.options);
    EXPECT_EQ(Dropped(result), errors.planted) << static_cast<int>(loss);
    EXPECT_THAT(result.warnings, testing::Contains(testing::HasSubstr("10 looks were dropped")));
    for (const std::size_t i : errors.planted) EXPECT_LT(result.looks.weight[i], 0.1F);
  }
}

// Tukey's loss does not feel looks beyond its scale. From a least-squares start a blunder puts all
// four looks of its point there, and the point would be lost with them; from Huber's it is not.
TEST(GrossErrorTest, TukeyLosesNoPointToTheBlunderOfOneLook) {
  GrossErrors errors = MakeGrossErrors(1.0, true);
  errors.options.robust = RobustLoss::kTukey;
  const AdjustResult result = Adjust(errors.known.block, errors.options);
  EXPECT_TRUE(result.usable()) << testing::PrintToString(result.warnings);
  for (std::size_t j = 0; j < errors.known.truth_m.size(); ++j) {
    EXPECT_EQ(result.points.status[j], PointStatus::kAdjusted) << result.points.reason[j];
  }
}

// Any two of three looks on parallel strips meet: with a range that is wrong by 40 sigma nothing
// says which it is. A loss keeps two of them, the point is left out; the passes are named.
TEST(RobustAdjustTest, ThreeLooksOnParallelPathsDoNotSayWhichIsWrong) {
  test::SceneBlock scene =
      test::SimulatedSceneBlock("scenes", "block-12-strips", {"points.count=300"});
  Block& block = scene.block;
  std::vector<std::size_t> spoiled;
  for (std::size_t j = 0; j < block.points.size() && spoiled.size() < 5; ++j) {
    const std::size_t begin = block.looks.offsets[j], end = block.looks.offsets[j + 1];
    if (block.points.role[j] != PointRole::kTie || end - begin != 3) continue;
    bool parallel = true;
    for (std::size_t i = begin; i < end; ++i) {
      parallel = parallel && block.passes[block.looks.pass[i]].id.front() == 'S';
    }
    if (!parallel) continue;
    block.looks.range_m[begin + j % 3] += 40.0 * block.SigmaOf(begin).range_m;
    spoiled.push_back(j);
  }
  ASSERT_EQ(spoiled.size(), 5U);
  for (const RobustLoss loss : {RobustLoss::kCauchy, RobustLoss::kTukey}) {
    scene.options.robust = loss;
    const AdjustResult result = Adjust(block, scene.options);
    EXPECT_TRUE(result.usable()) << testing::PrintToString(result.assessment.reasons);
    for (const std::size_t j : spoiled) {
      EXPECT_EQ(result.points.status[j], PointStatus::kApart) << j;
      EXPECT_THAT(result.points.reason[j],
                  testing::HasSubstr("none can be identified as wrong: S"));
    }
  }
}

// Invariance: on data without blunders a robust solution drops nothing and differs by less than
// its own loss of efficiency; at noise zero it is the least-squares solution.
TEST(RobustAdjustTest, ChangesNothingWithoutNoise) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  for (const std::size_t j : {1U, 4U, 9U}) test::AddKnownPoint(j, {0.2, 0.2, 0.2}, &known);
  AdjustOptions options;
  const AdjustResult plain = Adjust(known.block, options);
  for (const RobustLoss loss : kLosses) {
    options.robust = loss;
    const AdjustResult result = Adjust(known.block, options);
    EXPECT_EQ(result.looks_used, plain.looks_used);
    for (std::size_t j = 0; j < known.truth_m.size(); ++j) {
      EXPECT_LT((result.points.position_m[j] - plain.points.position_m[j]).norm(), 1e-7);
    }
    for (const float weight : result.looks.weight) EXPECT_EQ(weight, 1.0F);
  }
}

}  // namespace
}  // namespace sarblock
