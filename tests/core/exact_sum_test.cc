// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace sarblock {
namespace {

ExactSum SumOf(const std::vector<double>& terms) {
  ExactSum sum;
  for (const double term : terms) sum.Add(term);
  return sum;
}

/// Squares of normal numbers times powers of two from 2^-40 to 2^24, both signs: their sum in
/// doubles depends on the order.
std::vector<double> WideTerms(std::size_t count) {
  RandomStream random(5, 1);
  std::vector<double> terms;
  for (std::size_t i = 0; i < count; ++i) {
    const double normal = random.Normal();
    terms.push_back(std::ldexp(normal * std::abs(normal), static_cast<int>(i * 7 % 65) - 40));
  }
  return terms;
}

double PlainSum(const std::vector<double>& terms) {
  double sum = 0.0;
  for (const double term : terms) sum += term;
  return sum;
}

// Invariance: order and division of the terms change no bit, where they do of doubles.
TEST(ExactSumTest, DoesNotDependOnOrderOrDivision) {
  const std::vector<double> terms = WideTerms(1000);
  const ExactSum sum = SumOf(terms);
  std::vector<double> backwards(terms.rbegin(), terms.rend());
  EXPECT_EQ(SumOf(backwards), sum);
  EXPECT_NE(PlainSum(terms), PlainSum(backwards));
  for (const std::size_t parts : {3U, 4U, 999U}) {
    std::vector<ExactSum> of(parts);
    for (std::size_t i = 0; i < terms.size(); ++i) of[i % parts].Add(terms[i]);
    ExactSum joined;
    for (auto part = of.rbegin(); part != of.rend(); ++part) joined.Add(*part);
    EXPECT_EQ(joined, sum) << parts;
  }
}

// Hand values; terms with at most 53 bits above 2^-60 are held whole.
TEST(ExactSumTest, AddsWithoutRounding) {
  EXPECT_EQ(SumOf({0x1p34, 0x1p-60, -0x1p34}).Value(), 0x1p-60);
  EXPECT_EQ(SumOf({0.1, 0.2, -0.1, -0.2}).Value(), 0.0);
  EXPECT_EQ(SumOf({0.1}).Value(), 0.1);
  EXPECT_EQ(SumOf({-1.7345e6}).Value(), -1.7345e6);
  EXPECT_EQ(SumOf({}).Value(), 0.0);
  EXPECT_EQ(SumOf({0x1.8p-61, 0x1.8p-61}).Value(), 0.0);  // below the unit: nothing
}

TEST(ExactSumTest, WhatIsTooLargeOrNoNumberCountsAsTheMost) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const double term : {1e12, 1e300, kInfinite, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(SumOf({term}).Value(), ExactSum::kMax) << term;
  }
  EXPECT_EQ(SumOf({-1e12, -kInfinite}).Value(), -2.0 * ExactSum::kMax);
  EXPECT_TRUE(SumOf({1e12, 1e12}).HasTerms(2));
  EXPECT_FALSE(SumOf({1e12, 1e12}).HasTerms(1));
  EXPECT_FALSE(SumOf({-1e12, -1e12}).HasTerms(1));
  EXPECT_TRUE(ExactSum().HasTerms(0));
  EXPECT_FALSE(SumOf({0.5}).HasTerms(0));
}

// Round trip, and 2^60 by hand.
TEST(ExactSumTest, IsWrittenAsAnInteger) {
  EXPECT_EQ(SumOf({1.0}).Text(), "1152921504606846976");
  EXPECT_EQ(SumOf({-0.5}).Text(), "-576460752303423488");
  EXPECT_EQ(ExactSum().Text(), "0");
  ExactSum most;
  for (int i = 0; i < 3; ++i) most.Add(-ExactSum::kMax);
  for (const ExactSum& sum : {SumOf(WideTerms(50)), most, ExactSum()}) {
    EXPECT_EQ(ExactSum::FromText(sum.Text()), sum) << sum.Text();
  }
  for (const char* text : {"",
                           "-",
                           "1.5",
                           "1e3",
                           "+1",
                           " 1",
                           "1 ",
                           "--1",
                           "0x1",
                           "100000000000000000000000000000000000000"}) {
    EXPECT_FALSE(ExactSum::FromText(text)) << text;
  }
}

}  // namespace
}  // namespace sarblock
