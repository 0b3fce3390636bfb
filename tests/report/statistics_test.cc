// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "report/page.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::ElementsAre;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr float kFloatNaN = std::numeric_limits<float>::quiet_NaN();

TEST(SampleQuantileTest, InterpolatesBetweenOrderStatistics) {  // hand: 0.3 * 3 = 0.9 of the way
  EXPECT_NEAR(SampleQuantile({7.5, 1.25, 3.5, 2.0}, 0.3), 1.25 + 0.9 * 0.75, 1e-15);
  EXPECT_EQ(SampleQuantile({7.5, 1.25, 3.5}, 0.5), 3.5);
  EXPECT_EQ(SampleQuantile({7.5, 1.25, 3.5}, 1.0), 7.5);
}

TEST(SampleQuantileTest, LeavesOutWhatIsNotGiven) {
  EXPECT_EQ(SampleQuantile({kNaN, 4.5, kNaN, 1.5}, 0.5), 3.0);
  EXPECT_TRUE(std::isnan(SampleQuantile({kNaN}, 0.5)));
  EXPECT_TRUE(std::isnan(SampleQuantile({}, 0.5)));
}

TEST(CountInBinsTest, PutsWhatLiesOutsideIntoTheOutermostBinsAndSaysHowMany) {
  const std::vector<float> values{-9.0F, -0.99F, -0.01F, 0.0F, 0.6F, 1.0F, 1.5F, kFloatNaN};
  const Histogram h = CountInBins(values, -1.0, 1.0, 4);
  EXPECT_THAT(h.counts, ElementsAre(2u, 1u, 1u, 3u));
  EXPECT_EQ(h.below, 1u);
  EXPECT_EQ(h.above, 1u);
  EXPECT_EQ(h.total(), 7u);
}

TEST(NormalQuantilePlotTest, TakesTheMiddleOfEachRank) {  // tables: of 1/6, 1/2, 5/6
  const std::vector<float> values{2.5F, -1.0F, kFloatNaN, 0.25F};
  const std::vector<QuantilePoint> plot = NormalQuantilePlot(values, 10);
  ASSERT_EQ(plot.size(), 3u);
  EXPECT_NEAR(plot[0].expected, -0.967421566101701, 1e-12);
  EXPECT_NEAR(plot[1].expected, 0.0, 1e-12);
  EXPECT_EQ(plot[0].value, -1.0);
  EXPECT_EQ(plot[2].value, 2.5);
}

TEST(NormalQuantilePlotTest, KeepsEveryPointOfTheTailsWhenItThins) {
  std::vector<float> values;
  for (int i = 0; i < 10007; ++i) values.push_back(static_cast<float>((i * 7919) % 10007));
  const std::vector<QuantilePoint> plot = NormalQuantilePlot(values, 400);
  ASSERT_EQ(plot.size(), 400u);
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(plot[i].value, static_cast<double>(i));
    EXPECT_EQ(plot[399 - i].value, 10006.0 - static_cast<double>(i));
  }
  for (std::size_t i = 1; i < plot.size(); ++i) {
    EXPECT_GT(plot[i].expected, plot[i - 1].expected);
    EXPECT_GT(plot[i].value, plot[i - 1].value);
  }
}

TEST(SampleIndicesTest, IsAscendingRepeatableAndSpreadOverTheWhole) {
  const std::vector<std::uint32_t> sample = SampleIndices(100003, 1000);
  ASSERT_EQ(sample.size(), 1000u);
  EXPECT_EQ(sample, SampleIndices(100003, 1000));
  EXPECT_TRUE(std::is_sorted(sample.begin(), sample.end()));
  EXPECT_EQ(std::set<std::uint32_t>(sample.begin(), sample.end()).size(), 1000u);
  // Quarters of the indices: 250 each, binomial deviation 13.7; five of them.
  std::array<int, 4> quarter{};
  for (const std::uint32_t i : sample) ++quarter[4 * i / 100003];
  for (const int count : quarter) EXPECT_NEAR(count, 250, 69);
}

TEST(SampleIndicesTest, TakesAllOfFew) {
  EXPECT_THAT(SampleIndices(3, 5), ElementsAre(0u, 1u, 2u));
  EXPECT_TRUE(SampleIndices(0, 5).empty());
}

TEST(MedianInBinsTest, GivesTheMedianOfEachStripWithEnoughValues) {
  const std::vector<double> x{0.0, 0.5, 1.0, 7.0, 9.5, 9.75, 10.0};
  const std::vector<double> y{3.0, 1.0, 2.0, 50.0, 7.0, kNaN, 9.0};
  const std::vector<BinnedMedian> bins = MedianInBins(x, y, 4, 2);
  ASSERT_EQ(bins.size(), 2u);  // 0 to 2.5 with three, 7.5 to 10 with two; 7.0 is alone
  EXPECT_EQ(bins[0].x, 1.25);
  EXPECT_EQ(bins[0].value, 2.0);
  EXPECT_EQ(bins[1].x, 8.75);
  EXPECT_EQ(bins[1].value, 8.0);
  EXPECT_EQ(bins[1].count, 2u);
}

TEST(RoundDown125Test, GivesScalesThatPeopleRead) {
  EXPECT_NEAR(RoundDown125(1999.0), 1000.0, 1e-9);
  EXPECT_NEAR(RoundDown125(2000.0), 2000.0, 1e-9);
  EXPECT_NEAR(RoundDown125(0.0731), 0.05, 1e-15);
  EXPECT_NEAR(RoundDown125(9.99), 5.0, 1e-12);
  EXPECT_EQ(RoundDown125(0.0), 1.0);
}

TEST(ConvexHullTest, HoldsWhatLiesBetweenItsPlaces) {
  const ConvexHull hull({{0, 0}, {8, 1}, {3, 3}, {7, 9}, {-1, 6}, {0, 0}});
  ASSERT_TRUE(hull.HasArea());
  EXPECT_TRUE(hull.Contains(3, 3));
  EXPECT_TRUE(hull.Contains(8, 1));
  EXPECT_TRUE(hull.Contains(4, 0.5));  // on the edge from (0, 0) to (8, 1)
  EXPECT_FALSE(hull.Contains(4, 0.4));
  EXPECT_FALSE(hull.Contains(8, 8));
}

TEST(ConvexHullTest, HasNoAreaOnALine) {
  EXPECT_FALSE(ConvexHull({{0, 0}, {1, 1}, {5, 5}}).HasArea());
  EXPECT_FALSE(ConvexHull({{0, 0}, {1, 1}}).Contains(0.5, 0.5));
}

}  // namespace
}  // namespace sarblock
