// SPDX-License-Identifier: Apache-2.0
// Expected texts by hand; shortest decimals by std::to_chars.
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>

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

TEST(NumberTextTest, WritesTheFewestDigitsThatReadBack) {
  EXPECT_EQ(NumberText(0.1), "0.1");
  EXPECT_EQ(NumberText(-1234.5678), "-1234.5678");
  EXPECT_EQ(NumberText(100000.0), "1e+05");
  EXPECT_EQ(NumberText(123456.0), "123456");
  EXPECT_EQ(NumberText(0.0001), "1e-04");
  EXPECT_EQ(NumberText(0.00012), "0.00012");
  EXPECT_EQ(NumberText(-5.577423783350028e-07), "-5.577423783350028e-07");
  EXPECT_EQ(NumberText(9007199254740993.0), "9007199254740992");
  EXPECT_EQ(NumberText(-0.0), "-0");
  EXPECT_EQ(NumberText(std::numeric_limits<double>::denorm_min()), "5e-324");
  EXPECT_EQ(NumberText(INFINITY), "inf");
}

/// Two routes: std::to_chars writes the same.
void ExpectAsToChars(double value) {
  std::array<char, 64> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  ASSERT_EQ(error, std::errc());
  ASSERT_EQ(NumberText(value), std::string(text.data(), end));
}

TEST(NumberTextTest, WritesWhatToCharsDoes) {
  std::mt19937_64 random(2026);
  const auto digits = [&](int count) {
    return static_cast<double>(random() % static_cast<std::uint64_t>(std::pow(10.0, count)));
  };
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = random();
    ExpectAsToChars(std::bit_cast<double>(bits));
    // The same fraction with an exponent of the numbers of tables, 2^-31 to 2^54.
    const std::uint64_t fraction = bits & 0x800fffffffffffff, exponent = 992 + random() % 86;
    ExpectAsToChars(std::bit_cast<double>(fraction | exponent << 52U));
  }
  for (int power = -42; power < 22; ++power) {
    for (int count = 1; count <= 17; ++count) {
      for (int i = 0; i < 20; ++i) {
        const double value = digits(count) * std::pow(10.0, power - count);
        ExpectAsToChars(value);
        ExpectAsToChars(-std::nextafter(value, INFINITY));
      }
    }
  }
  // Half as far from the number below as from the one above; and few bits, which end half way.
  for (int power = -130; power < 60; ++power) {
    const double value = std::ldexp(1.0, power);
    ExpectAsToChars(value);
    ExpectAsToChars(std::nextafter(value, 0.0));
    ExpectAsToChars(std::nextafter(value, INFINITY));
    for (unsigned bits = 1; bits <= 53; ++bits) {
      ExpectAsToChars(std::ldexp(static_cast<double>(random() >> (64U - bits)), power));
    }
  }
  for (int i = 0; i < 2000; ++i) {
    for (const double factor : {1.0, 0.5, 1e-3, 1e5, 1e9}) ExpectAsToChars(i * factor);
  }
}

}  // namespace
}  // namespace sarblock
