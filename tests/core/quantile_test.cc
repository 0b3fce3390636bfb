// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace sarblock {
namespace {

// Closed form: two degrees of freedom are an exponential distribution of mean 2.
TEST(ChiSquareTest, IsExponentialForTwoDegrees) {
  for (const double p : {0.0013, 0.317, 0.9731, 0.999917}) {
    const double x = -2.0 * std::log1p(-p);
    EXPECT_NEAR(ChiSquareQuantile(p, 2.0), x, 1e-12) << p;
    EXPECT_NEAR(ChiSquareProbability(x, 2.0), p, 1e-14) << p;
  }
}

// Closed form: one degree of freedom is a squared normal variable.
TEST(ChiSquareTest, IsASquaredNormalForOneDegree) {
  for (const double p : {0.271, 0.9545, 0.99731}) {
    const double z = NormalQuantile(0.5 + 0.5 * p);
    EXPECT_NEAR(ChiSquareQuantile(p, 1.0), z * z, 1e-11) << p;
  }
}

// Printed tables (Abramowitz and Stegun, table 26.8), five to six digits.
TEST(ChiSquareTest, ReproducesPrintedTables) {
  EXPECT_NEAR(ChiSquareQuantile(0.95, 3.0), 7.81473, 5e-6);
  EXPECT_NEAR(ChiSquareQuantile(0.99, 10.0), 23.2093, 5e-5);
  EXPECT_NEAR(ChiSquareQuantile(0.005, 30.0), 13.7867, 5e-5);
}

// Cornish-Fisher expansion of Wilson and Hilferty: x = f (1 - 2/9f + z sqrt(2/9f))^3. Its error in
// x is of order z^3/sqrt(f) at most, so 0.01 at ten million degrees is generous by a factor of 3.
TEST(ChiSquareTest, WorksForTenMillionDegrees) {
  const double f = 1.0000019e7;
  for (const double p : {0.025, 0.41, 0.975, 0.9995}) {
    const double c = 2.0 / (9.0 * f);
    const double root = 1.0 - c + NormalQuantile(p) * std::sqrt(c);
    EXPECT_NEAR(ChiSquareQuantile(p, f), f * root * root * root, 0.01) << p;
    EXPECT_NEAR(ChiSquareProbability(ChiSquareQuantile(p, f), f), p, 1e-10) << p;
  }
}

TEST(ChiSquareTest, IntervalLeavesTheSameProbabilityOnBothSides) {
  const Interval interval = ChiSquareInterval(0.951, 7.3);
  EXPECT_NEAR(ChiSquareProbability(interval.lower, 7.3), 0.0245, 1e-13);
  EXPECT_NEAR(ChiSquareProbability(interval.upper, 7.3), 0.9755, 1e-13);
  EXPECT_TRUE(interval.Contains(7.3));
  EXPECT_FALSE(interval.Contains(std::nextafter(interval.lower, 0.0)));
  EXPECT_FALSE(interval.Contains(std::numeric_limits<double>::quiet_NaN()));
}

// Second program: statistics.NormalDist().inv_cdf of Python, algorithm AS 241 (Wichura 1988).
TEST(NormalQuantileTest, IsThatOfAnotherProgram) {
  EXPECT_NEAR(NormalQuantile(0.975), 1.959963984540054, 1e-14);
  EXPECT_NEAR(NormalQuantile(0.0005), -3.290526731491895, 1e-14);
  EXPECT_EQ(NormalQuantile(0.5), 0.0);
}

TEST(QuantileTest, RefusesWhatHasNoAnswer) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double p : {0.0, 1.0, -0.2, 1.3, nan}) {
    EXPECT_THROW((void)ChiSquareQuantile(p, 3.0), InputError) << p;
    EXPECT_THROW((void)NormalQuantile(p), InputError) << p;
    EXPECT_THROW((void)ChiSquareInterval(p, 3.0), InputError) << p;
  }
  for (const double f : {0.0, -1.0, nan}) {
    EXPECT_THROW((void)ChiSquareQuantile(0.3, f), InputError) << f;
    EXPECT_THROW((void)ChiSquareProbability(0.3, f), InputError) << f;
  }
  EXPECT_THROW((void)ChiSquareProbability(-0.1, 3.0), InputError);
  EXPECT_EQ(ChiSquareProbability(0.0, 3.0), 0.0);
}

// Closed forms: with two numerator degrees P(X > x) = (1 + 2 x / f)^(-f / 2); F(1, 1) is the square
// of a Cauchy variable.
TEST(QuantileTest, FisherTailAgreesWithClosedForms) {
  EXPECT_NEAR(FisherTailProbability(3.7, 2.0, 10.0), std::pow(1.0 + 7.4 / 10.0, -5.0), 1e-15);
  EXPECT_NEAR(FisherTailProbability(1.0, 1.0, 1.0), 0.5, 1e-15);
  // Far in the tail, where 1 - P has no digits left.
  const double far = std::pow(1.0 + 2.0 * 90.0 / 40.0, -20.0);
  EXPECT_NEAR(FisherTailProbability(90.0, 2.0, 40.0) / far, 1.0, 1e-12);
  EXPECT_THROW((void)FisherTailProbability(-1.0, 2.0, 3.0), InputError);
  EXPECT_THROW((void)FisherTailProbability(1.0, 0.0, 3.0), InputError);
}

}  // namespace
}  // namespace sarblock
