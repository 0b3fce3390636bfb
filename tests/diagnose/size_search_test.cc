// SPDX-License-Identifier: Apache-2.0
#include "diagnose/mistakes.h"
#include "diagnose/sample.h"
#include "diagnose/trial_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// Two routes inside: a size found by solutions of changed blocks, and the same as a correction.
TEST(SearchSizeTest, FindsARangeBiasAndItsSigmaAsACorrectionDoes) {
  test::TrialBlock made = test::MakeTrialBlock("moon-alse", 4);
  constexpr double kBias_m = 431.7;
  for (std::size_t i = 0; i < made.block.looks.size(); ++i) {
    if (made.block.looks.pass[i] == 1) made.block.looks.range_m[i] += kBias_m;
  }
  const Sample sample = TakeSample(made.block, nullptr);
  Trials trials(sample.block,
                made.options.groups,
                Work(sample.block, sample.block, DiagnosisBounds{}.adjustments),
                nullptr);
  const Hypothesis hypothesis = RangeBias({made.block.passes[1].id}, 400.0, 1.0);
  const Fit first = trials.With(hypothesis, hypothesis.value, {});
  const Solved solved = SearchSize(hypothesis, first, {}, &trials);

  std::vector<CorrectionGroup> groups = made.options.groups;
  groups.push_back({"range", RangeCorrection{.bias = true}, {made.block.passes[1].id}, false});
  Trials corrected(sample.block,
                   groups,
                   Work(sample.block, sample.block, DiagnosisBounds{}.adjustments),
                   nullptr);
  const Fit with = corrected.SolveGiven();
  AdjustmentProblem problem(sample.block, groups);
  int column = -1;
  for (int i = 0; i < problem.layout.size(); ++i) {
    if (problem.layout.parameters[static_cast<std::size_t>(i)].kind == ParameterKind::kRangeBias) {
      column = i;
    }
  }
  ASSERT_GE(column, 0);
  // The correction is added to what is predicted, the size taken off what was measured.
  EXPECT_NEAR(solved.value, with.state.corrections[column], 0.1 * solved.sigma);
  EXPECT_NEAR(solved.value, kBias_m, 4.0 * solved.sigma);
  EXPECT_NEAR(solved.fit.square_sum, with.square_sum, 0.02);
}

TEST(SearchSizeTest, LeavesASizeThatIsNotFree) {
  const test::TrialBlock made = test::MakeTrialBlock("moon-alse", 4);
  const Sample sample = TakeSample(made.block, nullptr);
  Trials trials(sample.block,
                made.options.groups,
                Work(sample.block, sample.block, DiagnosisBounds{}.adjustments),
                nullptr);
  Hypothesis hypothesis = RangeBias({}, 3.0, 1.0);
  hypothesis.free = false;
  const Solved solved = SearchSize(hypothesis, trials.With(hypothesis, 3.0, {}), {}, &trials);
  EXPECT_EQ(solved.value, 3.0);
  EXPECT_TRUE(std::isnan(solved.sigma));
  EXPECT_EQ(trials.solutions(), 1);
}

}  // namespace
}  // namespace sarblock
