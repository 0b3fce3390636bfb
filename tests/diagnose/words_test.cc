// SPDX-License-Identifier: Apache-2.0
#include "diagnose/mistakes.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

TEST(SizeOfTest, RoundsToTheSecondDigitOfSigma) {
  EXPECT_EQ(SizeOf(18.000312, 0.00123, "s").text, "18.0003 +- 0.0012 s");
  EXPECT_EQ(SizeOf(-999.4321, 7.83, "m").text, "-999.4 +- 7.8 m");
  EXPECT_EQ(SizeOf(12345.6, 678.0, "m").text, "12350 +- 680 m");
  EXPECT_EQ(SizeOf(7.2921e-5, 3.1e-10, "rad/s").text, "7.292100e-05 +- 3.1e-10 rad/s");
}

TEST(SizeOfTest, GivesSixDigitsWithoutASigma) {
  EXPECT_EQ(SizeOf(1000.0, kNotGiven, "1").text, "1000");
  EXPECT_EQ(SizeOf(0.0066712819, kNotGiven, "1").text, "0.00667128");
}

TEST(InFilesTest, GoesToTheSecondDigitOfSigma) {
  EXPECT_EQ(InFiles(123456.789, 0.12), "123456.79");
  EXPECT_EQ(InFiles(0.5, 0.1), "0.5");
  EXPECT_EQ(InFiles(2e6 / 299792458.0), "0.006671281904");  // 4 digits: 20 m of 700 km
}

TEST(EqualsTest, NamesTheNearestNumberWithinFourSigmas) {
  const std::vector<KnownNumber> numbers{{18.0, "eighteen"}, {19.0, "nineteen"}};
  EXPECT_EQ(Equals(numbers, 18.003, 0.001), "eighteen");  // within a thousandth
  EXPECT_EQ(Equals(numbers, 18.61, 0.2), "nineteen");     // within four sigmas of both
  EXPECT_EQ(Equals(numbers, 18.5, 0.01), "");
  EXPECT_EQ(Equals(numbers, 18.0, 3.0), "");  // a sigma that says nothing
}

TEST(PassWordsTest, ListsFourPassesAndCountsTheOthers) {
  EXPECT_EQ(PassWords({}), "all passes");
  EXPECT_EQ(PassWords({"A"}), "pass A");
  EXPECT_EQ(PassWords({"A", "B"}), "passes A and B");
  EXPECT_EQ(PassesPhrase({"A", "B", "C", "D", "E", "F"}), "of A, B, C, D and 2 more");
}

}  // namespace
}  // namespace sarblock
