// SPDX-License-Identifier: Apache-2.0
#include "quality/montecarlo.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "normals/point.h"
#include "support/dense_normals.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// Twelve points in four squinted passes, three of them control (one correlated, one in height
/// only), constants with priors: every kind of observation is drawn.
test::KnownBlock NoisyBlock() {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan(15.0));
  test::AddKnownPoint(0, {0.5, 0.8, 0.6}, &known, PointRole::kControl, 0.6);
  test::AddKnownPoint(3, {kNotGiven, kNotGiven, 0.7}, &known);
  test::AddKnownPoint(7, {0.6, 0.6, 0.9}, &known);
  test::AddNoise(4, 1.0, &known);
  return known;
}

AdjustOptions MonteCarloOptions(int runs) {
  PositionCorrection position;
  position.prior_sigma_m = {{{2.0}, {3.0}, {2.5}}};
  RangeCorrection range;
  range.bias = true;
  range.bias_prior_sigma_m = 1.0;
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}, {"range", range, {}, true}};
  options.covariance = CovarianceLevel::kMonteCarlo;
  options.montecarlo_runs = runs;
  options.montecarlo_seed = 17;
  return options;
}

MonteCarloReport ReportOf(const AdjustmentProblem& problem,
                          const BlockState& state,
                          const AdjustOptions& options,
                          const std::vector<SymmetricEnu>& covariance_m2) {
  return ReportMonteCarlo(DrawMonteCarlo(problem, state, options, covariance_m2, nullptr),
                          options.montecarlo_seed,
                          covariance_m2);
}

// Seeded statistics: sums of e' Q^-1 e by point are chi-square, the runs inside an ellipsoid
// binomial; 99.9 percent for all points and levels together (Bonferroni).
TEST(MonteCarloTest, CoversWhatTheRigorousCovarianceSays) {
  constexpr int kRuns = 400;
  const test::KnownBlock known = NoisyBlock();
  const AdjustResult result = Adjust(known.block, MonteCarloOptions(kRuns));
  ASSERT_TRUE(result.usable() && result.montecarlo);
  const MonteCarloReport& report = *result.montecarlo;
  EXPECT_EQ(report.runs, kRuns);
  EXPECT_EQ(report.failed, 0);
  EXPECT_EQ(report.points, 12U);
  const double level = 1.0 - 0.001 / 48.0;
  const Interval region = ChiSquareInterval(level, 3.0 * kRuns);
  const double z = NormalQuantile(0.5 + 0.5 * level);
  for (std::size_t j = 0; j < 12; ++j) {
    EXPECT_TRUE(region.Contains(3.0 * kRuns * report.square[j])) << report.square[j];
    for (std::size_t i = 0; i < 3; ++i) {
      const double p = MonteCarloReport::kLevels[i];
      // Normal approximation; with 4 expected outside of 99 percent half a count is its error.
      EXPECT_NEAR(report.inside[i][j], kRuns * p, z * std::sqrt(kRuns * p * (1.0 - p)) + 0.5);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const double ratio = report.sample_m2[j][i] / result.points.covariance_m2[j][i];
      EXPECT_TRUE(ChiSquareInterval(level, kRuns).Contains(kRuns * ratio)) << j << " " << ratio;
    }
  }
  EXPECT_TRUE(report.square_ratio.Agrees());
  EXPECT_THAT(report.sentence, testing::StartsWith("the stated covariance is realistic"));
}

// The same where the Dopplers of all passes but one are the measurements.
TEST(MonteCarloTest, DrawsMeasuredDopplers) {
  constexpr int kRuns = 300;
  test::BlockPlan plan = test::AircraftPlan(15.0, true);
  plan.sigma = {0.7, 2.1, AzimuthUnit::kHertz};
  test::KnownBlock known = test::MakeBlock(plan);
  known.block.passes[2].sigma = {0.7, 1.3, AzimuthUnit::kMetres};
  test::AddKnownPoint(0, {0.5, 0.8, 0.6}, &known);
  test::AddKnownPoint(7, {0.6, 0.6, 0.9}, &known);
  test::AddNoise(8, 1.0, &known);
  const AdjustResult result = Adjust(known.block, MonteCarloOptions(kRuns));
  ASSERT_TRUE(result.usable() && result.montecarlo);
  EXPECT_EQ(result.montecarlo->runs, kRuns);
  const Interval region = ChiSquareInterval(1.0 - 0.001 / 12.0, 3.0 * kRuns);
  for (std::size_t j = 0; j < 12; ++j) {
    EXPECT_TRUE(region.Contains(3.0 * kRuns * result.montecarlo->square[j])) << j;
  }
  EXPECT_TRUE(result.montecarlo->square_ratio.Agrees());
}

// A mutation kept as a test: a covariance without the corrections' part is found out.
TEST(MonteCarloTest, TellsACovarianceThatIsTooSmallOrTooLarge) {
  test::KnownBlock known = NoisyBlock();
  AdjustOptions options = MonteCarloOptions(100);
  options.covariance = CovarianceLevel::kIntersection;  // paths held: too small
  const AdjustResult fixed = Adjust(known.block, options);
  AdjustmentProblem problem(known.block, options.groups);
  const BlockState state = test::StateOf(fixed, &problem);
  const MonteCarloReport small = ReportOf(problem, state, options, fixed.points.covariance_m2);
  EXPECT_THAT(small.sentence, testing::StartsWith("the stated covariance is too small"));
  std::vector<SymmetricEnu> wide = fixed.points.covariance_m2;
  for (SymmetricEnu& q : wide) {
    for (double& element : q) element *= 400.0;
  }
  const MonteCarloReport large = ReportOf(problem, state, options, wide);
  EXPECT_THAT(large.sentence, testing::StartsWith("the stated covariance is too large"));
}

// A known position that was left out as a blunder is left out of the runs too: with it they would
// scatter less than the covariance without it says.
TEST(MonteCarloTest, RepeatsWhatTookPart) {
  test::KnownBlock known = NoisyBlock();
  for (const std::size_t point : {5U, 9U, 11U}) test::AddKnownPoint(point, {0.2, 0.2, 0.2}, &known);
  known.block.points.given_m[11] += Eigen::Vector3d(40.0, -30.0, 50.0);
  AdjustOptions options = MonteCarloOptions(300);
  options.quality.snooping = Snooping::kIterative;
  const AdjustResult result = Adjust(known.block, options);
  ASSERT_TRUE(result.snooping.has_value());
  ASSERT_EQ(result.snooping->findings.size(), 1U);
  ASSERT_EQ(result.snooping->findings[0].action, BlunderFinding::Action::kControlReleased);
  ASSERT_EQ(result.snooping->findings[0].point, 11U);
  EXPECT_TRUE(result.montecarlo->square_ratio.Agrees()) << result.montecarlo->sentence;
  // Of the point itself: chi-square at 99.9 percent.
  EXPECT_TRUE(ChiSquareInterval(0.999, 900.0).Contains(900.0 * result.montecarlo->square[11]));
}

// Invariance: the same bytes whatever the threads; other numbers for another seed.
TEST(MonteCarloTest, DoesNotDependOnThreads) {
  const test::KnownBlock known = NoisyBlock();
  AdjustOptions options = MonteCarloOptions(40);
  options.threads = 1;
  const AdjustResult one = Adjust(known.block, options);
  options.threads = 2;
  const AdjustResult two = Adjust(known.block, options);
  EXPECT_EQ(one.montecarlo->sample_m2, two.montecarlo->sample_m2);
  EXPECT_EQ(one.montecarlo->square, two.montecarlo->square);
  EXPECT_EQ(one.montecarlo->inside, two.montecarlo->inside);
  EXPECT_EQ(one.montecarlo->square_ratio.mean, two.montecarlo->square_ratio.mean);
  options.montecarlo_seed = 18;
  const AdjustResult other = Adjust(known.block, options);
  EXPECT_NE(one.montecarlo->sample_m2, other.montecarlo->sample_m2);
}

// Hand values: sums in standard deviations become a covariance with those of Q; a run that did not
// converge counts apart.
TEST(MonteCarloTest, ReportsSumsInTheUnitsOfTheCovariance) {
  MonteCarloDraws draws;
  draws.runs = {{true, {1.5, 0.5, 1.0}, 1.25, {1.0, 1.0, 1.0}},
                {false, {}, 0.0, {}},
                {true, {0.5, 1.5, 1.0}, 0.75, {0.0, 1.0, 1.0}}};
  MonteCarloPoint& sums = draws.points.emplace_back();
  sums.point = 1;
  for (std::size_t k = 0; k < 6; ++k) sums.product[k] = 0.25 * static_cast<double>(k + 1);
  sums.square = 6.75;
  sums.inside = {1, 2, 2};
  const SymmetricEnu none{kNotGiven, kNotGiven, kNotGiven, kNotGiven, kNotGiven, kNotGiven};
  const MonteCarloReport report =
      ReportMonteCarlo(draws, 9, {none, SymmetricEnu{4.0, 9.0, 16.0, 0.0, 0.0, 0.0}});
  EXPECT_EQ(report.runs, 2);
  EXPECT_EQ(report.failed, 1);
  EXPECT_EQ(report.points, 1U);
  EXPECT_TRUE(std::isnan(report.square[0]));
  // ee 4 x 0.25/2, nn 9 x 0.5/2, uu 16 x 0.75/2, en 6 x 1/2, eu 8 x 1.25/2, nu 12 x 1.5/2.
  EXPECT_EQ(report.sample_m2[1], (std::array<double, 6>{0.5, 2.25, 6.0, 3.0, 5.0, 9.0}));
  EXPECT_EQ(report.square[1], 1.125);
  EXPECT_EQ(report.inside[1][1], 2U);
  EXPECT_EQ(report.square_ratio.mean, 1.0);
  EXPECT_EQ(report.coverage[0].mean, 0.5);
}

// Closed form: with the noise-free readings both equations of every look vanish at the solution.
TEST(MonteCarloTest, ExactReadingsAreThoseOfTheSolution) {
  const test::KnownBlock known = NoisyBlock();
  const AdjustOptions options = MonteCarloOptions(1);
  const AdjustResult solved = Adjust(known.block, options);
  AdjustmentProblem problem(known.block, options.groups);
  const BlockState state = test::StateOf(solved, &problem);
  const ExactReadings exact = ReadExactly(problem, state);
  Block block = known.block;
  block.looks.time_s = exact.azimuth;
  block.looks.range_m = exact.range_m;
  AdjustmentProblem again(block, options.groups);
  UpdateWeights(state, &again);
  WhitenedLook look;
  for (std::size_t j = 0; j < 12; ++j) {
    for (std::size_t i = block.looks.offsets[j]; i < block.looks.offsets[j + 1]; ++i) {
      ASSERT_TRUE(EvaluateWhitened(again, state, {}, j, i, &look));
      EXPECT_LT(look.whitened_error.norm(), 1e-6) << i;
    }
  }
}

TEST(MonteCarloTest, BelongsToAdjustments) {
  const test::KnownBlock known = NoisyBlock();
  const AdjustOptions options = MonteCarloOptions(1);
  EXPECT_THROW(static_cast<void>(IntersectBlock(known.block, options)), InputError);
  EXPECT_THROW(static_cast<void>(Predict(known.block, options, known.truth_m)), InputError);
}

}  // namespace
}  // namespace sarblock
