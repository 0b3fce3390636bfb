// SPDX-License-Identifier: Apache-2.0
// The estimate beside the progress bar, on sequences of stages made up here.
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cli/terminal.h"
#include <gtest/gtest.h>

namespace sarblock::cli {
namespace {

/// Shown times depart by at most a quarter, and roundings.
constexpr double kLargestStep = 1.25 + 1e-9;

struct Estimate {
  double now_s = 0.0;
  std::optional<double> left_s;
  double true_s = 0.0;  ///< until the stage ends
};

/// One stage whose parts take `parts_s`, reported every 0.1 s.
std::vector<Estimate> Follow(const std::string& stage,
                             const std::vector<double>& parts_s,
                             double begin_s,
                             RemainingTime* remaining) {
  std::vector<double> ends_s;
  double end_s = begin_s;
  for (const double part_s : parts_s) ends_s.push_back(end_s += part_s);
  std::vector<Estimate> reported;
  std::size_t done = 0;
  for (double now_s = begin_s; now_s < end_s; now_s += 0.1) {
    while (done < ends_s.size() && ends_s[done] <= now_s) ++done;
    reported.push_back(
        {now_s, remaining->Update(stage, done, parts_s.size(), now_s), end_s - now_s});
  }
  return reported;
}

/// Largest factor between one estimate and the one shown before it, less the time between them.
double LargestJump(const std::vector<Estimate>& reported) {
  double largest = 1.0;
  for (std::size_t i = 1; i < reported.size(); ++i) {
    if (!reported[i].left_s || !reported[i - 1].left_s) continue;
    const double expected_s = *reported[i - 1].left_s - (reported[i].now_s - reported[i - 1].now_s);
    if (expected_s < 2.0) continue;
    largest =
        std::max({largest, *reported[i].left_s / expected_s, expected_s / *reported[i].left_s});
  }
  return largest;
}

std::size_t CountEstimates(const std::vector<Estimate>& reported) {
  std::size_t count = 0;
  for (const Estimate& of : reported) count += of.left_s ? 1U : 0U;
  return count;
}

TEST(RemainingTimeTest, ASteadyStageHasAnEstimateAfterThreeSecondsThatRunsDown) {
  RemainingTime remaining;
  const auto reported = Follow("solve", std::vector<double>(97, 0.41), 5.3, &remaining);
  for (const Estimate& of : reported) {
    EXPECT_FALSE(of.now_s < 8.2 && of.left_s) << of.now_s;
    if (of.now_s < 9.5) continue;
    ASSERT_TRUE(of.left_s) << of.now_s;
    EXPECT_NEAR(*of.left_s, of.true_s, 0.25 * of.true_s + 2.1) << of.now_s;
  }
}

TEST(RemainingTimeTest, PartsThatGrowFivefoldAreNotShownAsAJump) {
  RemainingTime remaining;
  std::vector<double> parts_s(40, 0.37);
  parts_s.insert(parts_s.end(), 40, 1.9);
  const auto reported = Follow("study", parts_s, 0.0, &remaining);
  EXPECT_GT(CountEstimates(reported), reported.size() / 4);
  EXPECT_LE(LargestJump(reported), kLargestStep);
}

TEST(RemainingTimeTest, AFirstPartOfFortyTimesTheCostIsNotTakenForTheOthers) {
  RemainingTime remaining;
  std::vector<double> parts_s(200, 0.53);
  parts_s.front() = 21.2;  // extrapolated from it alone the stage takes 70 minutes
  const auto reported = Follow("study", parts_s, 0.0, &remaining);
  EXPECT_GT(CountEstimates(reported), reported.size() / 4);
  for (const Estimate& of : reported) {
    EXPECT_LT(of.left_s.value_or(0.0), 2.0 * of.true_s + 2.1) << of.now_s;
  }
  EXPECT_LE(LargestJump(reported), kLargestStep);
}

TEST(RemainingTimeTest, ANewStageAndARepeatedOneBeginWithoutAnEstimate) {
  RemainingTime remaining;
  ASSERT_GT(CountEstimates(Follow("linearise", std::vector<double>(30, 0.5), 0.0, &remaining)), 0u);
  const auto repeated = Follow("linearise", std::vector<double>(30, 0.05), 20.0, &remaining);
  EXPECT_EQ(CountEstimates(repeated), 0u);  // it ends within three seconds
  const auto other = Follow("covariance", std::vector<double>(30, 0.6), 30.0, &remaining);
  for (const Estimate& of : other) {
    EXPECT_FALSE(of.now_s < 33.0 && of.left_s) << of.now_s;
  }
  EXPECT_GT(CountEstimates(other), 0u);
}

TEST(RemainingTimeTest, AStageOfUnknownLengthHasNoEstimate) {
  RemainingTime remaining;
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(remaining.Update("read", 7, 0, 0.3 * i));
}

}  // namespace
}  // namespace sarblock::cli
