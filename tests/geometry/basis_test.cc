// SPDX-License-Identifier: Apache-2.0
#include "geometry/basis.h"

#include "sarblock/core/error.h"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <boost/math/quadrature/gauss.hpp>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

template <std::size_t n>
struct Values {
  std::array<double, n> value{};
  std::array<double, n> first{};
  std::array<double, n> second{};
  std::array<double, n> third{};
  BasisValues out() { return {value, first, second, third}; }
};

// Closed forms of P_0 to P_5 and their derivatives, inside and a little outside [-1, 1].
TEST(LegendreTest, EqualsTheClosedFormsToDegreeFive) {
  for (const double x : {-1.0, -0.7313, 0.0, 0.2917, 0.9999, 1.0713}) {
    Values<6> legendre;
    LegendreValues(x, legendre.out());
    const double x2 = x * x, x3 = x2 * x, x4 = x2 * x2, x5 = x4 * x;
    const std::array<double, 6> value = {1.0,
                                         x,
                                         (3.0 * x2 - 1.0) / 2.0,
                                         (5.0 * x3 - 3.0 * x) / 2.0,
                                         (35.0 * x4 - 30.0 * x2 + 3.0) / 8.0,
                                         (63.0 * x5 - 70.0 * x3 + 15.0 * x) / 8.0};
    const std::array<double, 6> first = {0.0,
                                         1.0,
                                         3.0 * x,
                                         (15.0 * x2 - 3.0) / 2.0,
                                         (140.0 * x3 - 60.0 * x) / 8.0,
                                         (315.0 * x4 - 210.0 * x2 + 15.0) / 8.0};
    const std::array<double, 6> second = {
        0.0, 0.0, 3.0, 15.0 * x, (420.0 * x2 - 60.0) / 8.0, (1260.0 * x3 - 420.0 * x) / 8.0};
    const std::array<double, 6> third = {
        0.0, 0.0, 0.0, 15.0, 105.0 * x, (3780.0 * x2 - 420.0) / 8.0};
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_NEAR(legendre.value[k], value[k], 1e-14) << k << " at " << x;
      EXPECT_NEAR(legendre.first[k], first[k], 1e-13) << k << " at " << x;
      EXPECT_NEAR(legendre.second[k], second[k], 1e-12) << k << " at " << x;
      EXPECT_NEAR(legendre.third[k], third[k], 1e-11) << k << " at " << x;
    }
  }
}

// Orthogonality: the integral of P_j P_k is 2/(2k + 1) for j = k and else 0. Gauss-Legendre with 30
// points is exact to degree 59.
TEST(LegendreTest, IsOrthogonal) {
  constexpr std::size_t kCount = 13;
  for (std::size_t j = 0; j < kCount; ++j) {
    for (std::size_t k = 0; k < kCount; ++k) {
      const auto product = [j, k](double x) {
        Values<kCount> legendre;
        LegendreValues(x, legendre.out());
        return legendre.value[j] * legendre.value[k];
      };
      const double integral = boost::math::quadrature::gauss<double, 30>::integrate(product);
      const double expected = j == k ? 2.0 / (2.0 * static_cast<double>(k) + 1.0) : 0.0;
      EXPECT_NEAR(integral, expected, 1e-14) << j << " " << k;
    }
  }
}

// Legendre's equation (1 - x^2) P'' - 2 x P' + n (n + 1) P = 0 and its derivative tie the four
// outputs together at degrees beyond the closed forms above. P'' reaches 1e4 here, P''' 1e6.
TEST(LegendreTest, SolvesLegendresEquation) {
  Values<21> legendre;
  for (const double x : {-0.9713, -0.3307, 0.1709, 0.8893}) {
    LegendreValues(x, legendre.out());
    for (std::size_t k = 0; k < 21; ++k) {
      const auto n = static_cast<double>(k);
      EXPECT_NEAR((1.0 - x * x) * legendre.second[k] - 2.0 * x * legendre.first[k] +
                      n * (n + 1.0) * legendre.value[k],
                  0.0,
                  1e-10);
      EXPECT_NEAR((1.0 - x * x) * legendre.third[k] - 4.0 * x * legendre.second[k] +
                      (n * (n + 1.0) - 2.0) * legendre.first[k],
                  0.0,
                  1e-8);
    }
  }
}

TEST(LegendreTest, FillsAsManyAsAskedFor) {
  LegendreValues(0.3, {});
  Values<1> constant;
  LegendreValues(0.3, constant.out());
  EXPECT_EQ(constant.value[0], 1.0);
}

const UniformSpline kSpline(1.2e9 + 0.37, 1.2e9 + 7.91, 1.3);

TEST(UniformSplineTest, DividesTheSpan) {  // hand values: 7.54 / 1.3 = 5.8, so six pieces
  EXPECT_EQ(kSpline.count(), 9u);
  EXPECT_NEAR(kSpline.spacing_s(), 7.54 / 6.0, 1e-7);   // the ulp of 1.2e9 is 2.4e-7
  EXPECT_EQ(UniformSpline(0.0, 0.3, 0.1).count(), 6u);  // 0.3/0.1 is not 3 in binary
  EXPECT_EQ(UniformSpline(0.0, 0.3, 50.0).count(), 4u);
}

TEST(UniformSplineTest, SumsToOne) {
  Values<4> four;
  for (const double dt_s : {0.37, 0.91, 3.77, 6.13, 7.91}) {
    (void)kSpline.Evaluate(1.2e9 + dt_s, four.out());
    double value = 0.0, first = 0.0, second = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_GE(four.value[k], 0.0);
      value += four.value[k];
      first += four.first[k];
      second += four.second[k];
    }
    EXPECT_NEAR(value, 1.0, 1e-15);
    EXPECT_NEAR(first, 0.0, 1e-15);
    EXPECT_NEAR(second, 0.0, 2e-15);
  }
}

// Value and three derivatives of a spline of given coefficients.
std::array<double, 4> Curve(const UniformSpline& spline,
                            const std::vector<double>& coefficients,
                            double time_s) {
  Values<4> four;
  const std::size_t index = spline.Evaluate(time_s, four.out());
  std::array<double, 4> sum{};
  for (std::size_t k = 0; k < 4; ++k) {
    sum[0] += coefficients.at(index + k) * four.value[k];
    sum[1] += coefficients.at(index + k) * four.first[k];
    sum[2] += coefficients.at(index + k) * four.second[k];
    sum[3] += coefficients.at(index + k) * four.third[k];
  }
  return sum;
}

const std::vector<double> kCoefficients = {0.71, -1.93, 2.37, 0.11, -0.57, 3.19, -2.71, 1.07, 0.3};

// Across a knot the value and two derivatives are continuous and the third jumps (it must, or the
// pieces would be one polynomial). Knots are k * 0.7 exactly representable enough: 1e-12 aside.
TEST(UniformSplineTest, IsTwiceContinuouslyDifferentiable) {
  const UniformSpline spline(0.0, 4.2, 0.7);
  ASSERT_EQ(spline.count(), 9u);
  for (int knot = 1; knot < 6; ++knot) {
    const double t_s = 0.7 * knot;
    const auto before = Curve(spline, kCoefficients, t_s - 1e-12);
    const auto after = Curve(spline, kCoefficients, t_s + 1e-12);
    for (std::size_t d = 0; d < 3; ++d) EXPECT_NEAR(before[d], after[d], 1e-9) << knot << " " << d;
    const double third_before = Curve(spline, kCoefficients, t_s - 0.1)[2] - before[2];
    const double third_after = after[2] - Curve(spline, kCoefficients, t_s + 0.1)[2];
    EXPECT_GT(std::abs(third_before - third_after), 0.1);
  }
}

// Central differences, step 1e-4: exact for the second derivative of a cubic and for the third by
// the second, truncation 1e-7 times the third derivative (at most 60) for the first; rounding
// 1e-12, 1e-8 and 1e-11.
TEST(UniformSplineTest, DerivativesBelongToTheValue) {
  const UniformSpline spline(0.0, 4.2, 0.7);
  const double h = 1e-4;
  for (const double t_s : {-0.31, 0.13, 1.77, 2.91, 4.19, 4.57}) {  // continued outside the span
    const auto before = Curve(spline, kCoefficients, t_s - h);
    const auto here = Curve(spline, kCoefficients, t_s);
    const auto after = Curve(spline, kCoefficients, t_s + h);
    EXPECT_NEAR(here[1], (after[0] - before[0]) / (2.0 * h), 1e-6);
    EXPECT_NEAR(here[2], (after[0] - 2.0 * here[0] + before[0]) / (h * h), 1e-5);
    EXPECT_NEAR(here[3], (after[2] - before[2]) / (2.0 * h), 1e-9);
  }
}

// Closed form: a uniform cubic B-spline with coefficients equal to the knots' places (Greville) is
// the straight line.
TEST(UniformSplineTest, ReproducesAStraightLine) {
  const UniformSpline spline(0.0, 4.2, 0.7);
  std::vector<double> places;
  for (int k = 0; k < 9; ++k) places.push_back(0.7 * (k - 1));
  for (const double t_s : {0.0, 0.43, 2.1, 3.97, 4.2}) {
    const auto line = Curve(spline, places, t_s);
    EXPECT_NEAR(line[0], t_s, 3e-15);
    EXPECT_NEAR(line[1], 1.0, 3e-15);
    EXPECT_NEAR(line[2], 0.0, 3e-14);
  }
}

TEST(UniformSplineTest, RefusesWhatCannotBeASpline) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(UniformSpline(3.0, 3.0, 1.0), InputError);
  EXPECT_THROW(UniformSpline(3.0, 2.0, 1.0), InputError);
  EXPECT_THROW(UniformSpline(nan, 2.0, 1.0), InputError);
  EXPECT_THROW(UniformSpline(0.0, 2.0, 0.0), InputError);
  EXPECT_THROW(UniformSpline(0.0, 2.0, -0.1), InputError);
  EXPECT_THROW(UniformSpline(0.0, 2.0, nan), InputError);
  EXPECT_THROW(UniformSpline(0.0, 2.0, 1e-9), InputError);
}

}  // namespace
}  // namespace sarblock
