// SPDX-License-Identifier: Apache-2.0
// Expected texts by hand.
#include <cmath>

#include "core/text.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

TEST(ValueWithSigmaTest, RoundsBothToTheSecondDigitOfTheSigma) {
  EXPECT_EQ(ValueWithSigma(7.08244, 0.1934), "7.08 +- 0.19");
  EXPECT_EQ(ValueWithSigma(-0.999784, 0.000312), "-0.99978 +- 0.00031");
  EXPECT_EQ(ValueWithSigma(1234567.0, 123.0), "1234570 +- 120");
  EXPECT_EQ(ValueWithSigma(18.00042, 0.0010), "18.0004 +- 0.0010");
  EXPECT_EQ(ValueWithSigma(0.0, 1.0), "0.0 +- 1.0");
}

TEST(ValueWithSigmaTest, WritesPowersOfTenWhereDecimalsWouldNotBeRead) {
  EXPECT_EQ(ValueWithSigma(1.23456e-10, 2.34e-12), "1.235e-10 +- 2.3e-12");
  EXPECT_EQ(ValueWithSigma(7.292115e-5, 3.21e-10), "7.292115e-05 +- 3.2e-10");
  EXPECT_EQ(ValueWithSigma(4.5678e9, 1.23e7), "4.568e+09 +- 1.2e+07");
}

TEST(ValueWithSigmaTest, KeepsManyDecimalsOfANumberOfOrdinarySize) {
  EXPECT_EQ(ValueWithSigma(0.03000000012, 4.5e-10), "0.03000000012 +- 0.00000000045");
}

TEST(ValueWithSigmaTest, WithoutASigmaTellsSixDigits) {
  EXPECT_EQ(ValueWithSigma(3.14159265, std::nan("")), "3.14159");
  EXPECT_EQ(ValueWithSigma(3.14159265, 0.0), "3.14159");
  EXPECT_EQ(ValueWithSigma(2.5, INFINITY), "2.5");
}

TEST(DigitsTest, CountsSignificantDigits) {
  EXPECT_EQ(Digits(0.012345, 2), "0.012");
  EXPECT_EQ(Digits(1234567.0, 4), "1.235e+06");
  EXPECT_EQ(Digits(2.5, 4), "2.5");
}

}  // namespace
}  // namespace sarblock
