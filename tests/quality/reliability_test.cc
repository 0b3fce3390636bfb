// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <cmath>
#include <limits>

#include "quality/verdict_tests.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

QualityOptions Options(double alpha, double power, FamilyWise family = FamilyWise::kNone) {
  QualityOptions options;
  options.alpha = alpha;
  options.power = power;
  options.family_wise = family;
  return options;
}

// Published values: Baarda (1968) has k = 3.29 and delta0 = 4.13 for alpha 0.001 and power 0.80;
// the other two stand in the usual tables of the standard normal distribution.
TEST(ReliabilityTest, CriticalValueAndNonCentralityAreBaardas) {
  const ReliabilityFigures usual = MakeReliability(Options(0.001, 0.80), 500, 200.0);
  EXPECT_NEAR(usual.critical_w, 3.2905, 5e-5);
  EXPECT_NEAR(usual.delta0, 4.1321, 5e-5);
  const ReliabilityFigures loose = MakeReliability(Options(0.05, 0.80), 500, 200.0);
  EXPECT_NEAR(loose.critical_w, 1.9600, 5e-5);
  EXPECT_NEAR(loose.delta0, 2.8016, 5e-5);
  EXPECT_NEAR(MakeReliability(Options(0.01, 0.90), 500, 200.0).delta0, 2.5758 + 1.2816, 5e-5);
}

// Invariance: the non-centrality is that of the power asked for, also where both tails count.
TEST(ReliabilityTest, TheShiftHasThePowerAskedFor) {
  for (const double alpha : {1e-6, 0.001, 0.3}) {
    for (const double power : {0.31, 0.5, 0.8, 0.999}) {
      const ReliabilityFigures figures = MakeReliability(Options(alpha, power), 3, 10.0);
      EXPECT_NEAR(TestPower(figures.delta0, figures.critical_w), power, 1e-12);
    }
  }
  EXPECT_NEAR(
      TestPower(0.0, MakeReliability(Options(0.001, 0.8), 3, 10.0).critical_w), 1e-3, 1e-12);
}

// Closed form: with two degrees of freedom tau = sqrt(2) t / sqrt(1 + t^2), t of one degree
// (Cauchy) tan(pi (1 - alpha) / 2), hence tau = sqrt(2) sin(pi (1 - alpha) / 2).
TEST(ReliabilityTest, TauIsThatOfPope) {
  const double alpha = 0.037;
  const ReliabilityFigures figures = MakeReliability(Options(alpha, 0.8), 10, 2.0);
  EXPECT_NEAR(figures.critical_tau, std::sqrt(2.0) * std::sin(0.5 * M_PI * (1.0 - alpha)), 1e-12);
  // No tau exceeds sqrt(f); with many degrees of freedom it is the normal test.
  EXPECT_LT(MakeReliability(Options(1e-9, 0.8), 10, 3.0).critical_tau, std::sqrt(3.0));
  const ReliabilityFigures many = MakeReliability(Options(0.001, 0.8), 10, 1e7);
  EXPECT_NEAR(many.critical_tau, many.critical_w, 1e-5);
  EXPECT_TRUE(std::isnan(MakeReliability(Options(0.001, 0.8), 10, 1.0).critical_tau));
}

// Closed forms: 1 - 0.95^(1/20) and 0.05 / 20.
TEST(ReliabilityTest, FamilyWiseLevelsAreSharedByAllTests) {
  const auto figures = [](FamilyWise family, std::size_t tests) {
    return MakeReliability(Options(0.05, 0.8, family), tests, 50.0);
  };
  EXPECT_NEAR(figures(FamilyWise::kSidak, 20).alpha_one, 1.0 - std::pow(0.95, 1.0 / 20.0), 1e-15);
  EXPECT_NEAR(figures(FamilyWise::kSidak, 20).alpha_all, 0.05, 1e-15);
  EXPECT_NEAR(figures(FamilyWise::kBonferroni, 20).alpha_one, 0.05 / 20.0, 1e-16);
  EXPECT_NEAR(
      figures(FamilyWise::kBonferroni, 20).alpha_all, 1.0 - std::pow(1.0 - 0.05 / 20.0, 20), 1e-14);
  EXPECT_NEAR(figures(FamilyWise::kNone, 20).alpha_one, 0.05, 0.0);
  EXPECT_NEAR(figures(FamilyWise::kNone, 20).alpha_all, 1.0 - std::pow(0.95, 20), 1e-14);
}

TEST(ReliabilityTest, BlundersThatShowNowhereHaveNoFigures) {  // hand values
  EXPECT_NEAR(MinimalDetectable(4.13, 0.5, 0.25), 4.13, 1e-15);
  EXPECT_NEAR(Influence_m(4.0, 0.3, 0.64), 1.5, 1e-15);
  EXPECT_TRUE(std::isnan(MinimalDetectable(4.13, 0.5, 0.0)));
  EXPECT_TRUE(std::isnan(MinimalDetectable(4.13, 0.5, std::numeric_limits<double>::quiet_NaN())));
}

TEST(ReliabilityTest, RefusesLevelsThatMakeNoTest) {
  EXPECT_THROW(static_cast<void>(MakeReliability(Options(0.0, 0.8), 5, 5.0)), InputError);
  EXPECT_THROW(static_cast<void>(MakeReliability(Options(0.9, 0.8), 5, 5.0)), InputError);
  EXPECT_THROW(static_cast<void>(MakeReliability(Options(0.1, 1.0), 5, 5.0)), InputError);
}

}  // namespace
}  // namespace sarblock
