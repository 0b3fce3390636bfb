// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "solve/solve_block.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// `passes` passes that keep and lose as many deciding looks each, and one more.
std::vector<PassLooks> Beside(std::size_t passes, LookCounts each, LookCounts own) {
  std::vector<PassLooks> by_pass(passes, PassLooks{{}, each});
  by_pass.push_back({{}, own});
  return by_pass;
}

/// P(X >= lost) of `n` trials, term by term.
double BinomialTail(std::size_t lost, std::size_t n, double p) {
  double sum = 0.0;
  for (std::size_t k = lost; k <= n; ++k) {
    const auto x = static_cast<double>(k), all = static_cast<double>(n);
    sum += std::exp(std::lgamma(all + 1.0) - std::lgamma(x + 1.0) - std::lgamma(all - x + 1.0) +
                    x * std::log(p) + (all - x) * std::log1p(-p));
  }
  return sum;
}

// Second route: the binomial distribution summed term by term.
TEST(PassThatLosesMoreTest, IsOneThatLosesMoreThanChanceExplains) {
  constexpr std::size_t kPasses = 11, kOwn = 44;
  // 44 of 495 others' looks are lost; with one more of each kind 45 of 497.
  const double p = 45.0 / 497.0;
  std::size_t flagged = 0;
  for (std::size_t lost = 0; lost <= kOwn; ++lost) {
    const auto found = PassThatLosesMore(Beside(kPasses, {41, 4}, {kOwn - lost, lost}));
    const bool expected = BinomialTail(lost, kOwn, p) < 0.05 / (kPasses + 1.0) &&
                          static_cast<double>(lost) >= 0.2 * kOwn;
    EXPECT_EQ(found.has_value(), expected) << lost;
    if (!found) continue;
    EXPECT_EQ(*found, kPasses);
    ++flagged;
  }
  EXPECT_GT(flagged, 30U);
  EXPECT_LT(flagged, 36U);
}

TEST(PassThatLosesMoreTest, IsNoneWhereMatchesOfOneImageAreWorseThanOthers) {  // hand arithmetic
  // A thousand looks leave no doubt that 15 percent are not 5; nor 35 percent 20: not twice as
  // many.
  EXPECT_FALSE(PassThatLosesMore(Beside(9, {950, 50}, {850, 150})));
  EXPECT_FALSE(PassThatLosesMore(Beside(9, {800, 200}, {650, 350})));
  EXPECT_TRUE(PassThatLosesMore(Beside(9, {950, 50}, {750, 250})));
}

TEST(PassThatLosesMoreTest, IsNoneOfPassesWithoutLooks) {
  EXPECT_FALSE(PassThatLosesMore({}));
  EXPECT_FALSE(PassThatLosesMore(Beside(3, {}, {})));
  EXPECT_FALSE(PassThatLosesMore(Beside(0, {}, {3, 9})));
}

// Of four looks of pass B at points of three looks, two are left out: as many against as for it.
TEST(UndecidedPassTest, CountsLooksAtPointsOfThreeLooksAndMore) {  // hand arithmetic
  Block block;
  block.passes.resize(3);
  const std::vector<std::vector<std::uint32_t>> passes_of_points = {
      {0, 1, 2}, {0, 1, 2}, {0, 1, 2}, {0, 1, 2}, {0, 1}, {0, 1}, {1}};
  for (const auto& passes : passes_of_points) {
    for (const std::uint32_t pass : passes) {
      block.looks.pass.push_back(pass);
      block.looks.flags.push_back(0);
    }
    block.looks.offsets.push_back(block.looks.pass.size());
    block.points.role.push_back(PointRole::kTie);
  }
  std::vector<std::uint8_t> used(block.looks.size(), 1);
  used[1] = used[13] = 0;  // of pass 1 at the first point and at one of two looks
  const std::vector<PassLooks> one = CountPassLooks(block, used);
  EXPECT_EQ(one[1].deciding.kept, 3U);
  EXPECT_EQ(one[1].deciding.lost, 1U);
  EXPECT_EQ(one[1].all.kept, 4U);
  EXPECT_EQ(one[1].all.lost, 2U);
  EXPECT_FALSE(UndecidedPass(one));
  used[4] = 0;
  EXPECT_EQ(UndecidedPass(CountPassLooks(block, used)), 1U);
  block.looks.flags[4] = Looks::kRejected;  // by the file: not lost, and its point has two looks
  EXPECT_FALSE(UndecidedPass(CountPassLooks(block, used)));
}

}  // namespace
}  // namespace sarblock
