// SPDX-License-Identifier: Apache-2.0
#include "quality/variance_components.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"

#include <cmath>
#include <string>
#include <vector>

#include "quality/assess.h"
#include "solve/rank.h"
#include "solve/start.h"
#include "support/dense_normals.h"
#include "support/small_blocks.h"
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

/// Forty points in four passes, six of them control, noise of the looks' own standard deviations.
test::KnownBlock BlockOfGroups(const test::BlockPlan& given,
                               std::uint64_t seed,
                               std::size_t points) {
  test::BlockPlan plan = given;
  plan.points = points;
  test::KnownBlock known = test::MakeBlock(plan);
  for (const std::size_t point : {0U, 2U, 4U, 6U, 8U, 9U}) {
    test::AddKnownPoint(point, {0.1, 0.1, 0.1}, &known);
  }
  test::AddNoise(seed, 1.0, &known);
  return known;
}

AdjustOptions ConstantsOf() {
  PositionCorrection position;
  position.prior_sigma_m = {{{5.0}, {5.0}, {5.0}}};
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  return options;
}

/// What the adjustment assumes: the true standard deviations over `range` and `azimuth`.
void Tell(double range, double azimuth, Block* block) {
  for (Pass& pass : block->passes) {
    pass.sigma.range_m /= range;
    pass.sigma.azimuth /= azimuth;
  }
}

struct Residual {
  Eigen::MatrixXd r;  // of all equations, looks in measured components
  Eigen::VectorXd v;
  std::vector<int> component;  // by row; -1 control and priors
};

/// R = I - A (A'A)^-1 A' of the whole block as one dense matrix.
Residual DenseResidual(const AdjustmentProblem& problem, const BlockState& state) {
  const test::DenseEquations dense = test::MakeDenseEquations(problem, state);
  Residual out;
  Eigen::Index row = 0;
  const Looks& looks = problem.block.looks;
  for (std::size_t j = 0; j < problem.block.points.size(); ++j) {
    if (!problem.Solves(j)) continue;
    for (std::size_t i = looks.offsets[j]; i < looks.offsets[j + 1]; ++i, row += 2) {
      out.component.push_back(looks.pass[i] == 0 ? 0 : 2);
      out.component.push_back(looks.pass[i] == 0 ? 1 : 3);
    }
    if (problem.control_of[j] < 0) continue;
    const int rows = problem.control[static_cast<std::size_t>(problem.control_of[j])].rows;
    out.component.insert(out.component.end(), static_cast<std::size_t>(rows), -1);
    row += rows;
  }
  const Eigen::MatrixXd& a = dense.jacobian;
  out.component.resize(static_cast<std::size_t>(a.rows()), -1);
  out.r =
      Eigen::MatrixXd::Identity(a.rows(), a.rows()) - a * test::DenseCovariance(a) * a.transpose();
  out.v = dense.residual;
  return out;
}

// Second route: sums, redundancies and Helmert's matrix against the dense R of the whole block,
// squinted looks in seconds, where range and azimuth are correlated in the equations.
TEST(VarianceSumsTest, AgreeWithTheDenseResidualMatrix) {
  test::KnownBlock known = BlockOfGroups(test::AircraftPlan(25.0), 5, 12);
  for (Pass& pass : known.block.passes) {
    pass.sigma.azimuth /= 180.0;
    pass.sigma.azimuth_unit = AzimuthUnit::kSeconds;
  }
  AdjustmentProblem problem(known.block, ConstantsOf().groups);
  problem.model.ScaleSigmas({{1.0, 1.0}, {1.5, 0.8}, {1.5, 0.8}, {1.5, 0.8}});
  const BlockState state = ComputeStartValues(&problem, nullptr).state;
  ReducedSystem system(problem);
  system.Form(state, {}, nullptr);
  FactorRegular(&system);
  const VarianceSums sums =
      SumVariances(problem, state, system, {{0, 1}, {2, 3}, {2, 3}, {2, 3}}, 4);

  const Residual dense = DenseResidual(problem, state);
  Eigen::Vector4d square = Eigen::Vector4d::Zero(), redundancy = square;
  Eigen::Matrix4d helmert = Eigen::Matrix4d::Zero();
  for (Eigen::Index i = 0; i < dense.r.rows(); ++i) {
    const int k = dense.component[static_cast<std::size_t>(i)];
    if (k < 0) continue;
    square[k] += dense.v[i] * dense.v[i];
    redundancy[k] += dense.r(i, i);
    for (Eigen::Index j = 0; j < dense.r.rows(); ++j) {
      const int l = dense.component[static_cast<std::size_t>(j)];
      if (l >= 0) helmert(k, l) += dense.r(i, j) * dense.r(i, j);
    }
  }
  // Rounding of R is 1e-12 or so; sums have some hundred terms.
  EXPECT_LT((sums.redundancy - redundancy).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LT((sums.helmert - helmert).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LT((sums.square - square).cwiseAbs().maxCoeff(), 1e-8 * square.maxCoeff());
  EXPECT_EQ(sums.looks, (std::vector<std::size_t>{12, 12, 36, 36}));
  EXPECT_GT(std::abs(helmert(0, 1)), 1e-3) << "the components are coupled: the test tells";
}

// Two routes: with the standard deviations that were estimated given from the start, the same
// blunders are detectable and move their points as far, and looks alone leave the points the same.
TEST(VarianceComponentsTest, GiveWhatTheirStandardDeviationsGive) {
  test::KnownBlock known = BlockOfGroups(test::AircraftPlan(), 7, 40);
  Tell(3.0, 0.5, &known.block);
  AdjustOptions options = ConstantsOf();
  options.variance_components = VarianceComponents::kRangeAzimuth;
  const AdjustResult estimated = Adjust(known.block, options);
  ASSERT_TRUE(estimated.usable() && estimated.variance_components);
  const auto& components = estimated.variance_components->components;
  Block again = known.block;
  Tell(1.0 / std::sqrt(components[0].factor), 1.0 / std::sqrt(components[1].factor), &again);
  options.variance_components = VarianceComponents::kNone;
  const AdjustResult given = Adjust(again, options);
  ASSERT_TRUE(given.usable());
  const BlunderSizes a(known.block, options, estimated, 1.0), b(again, options, given, 1.0);
  for (std::size_t point = 0; point < again.points.size(); ++point) {
    for (std::size_t i = again.looks.offsets[point]; i < again.looks.offsets[point + 1]; ++i) {
      for (std::size_t k = 0; k < 2; ++k) {
        const BlunderSize one = a.LookSizes(i, point)[k], two = b.LookSizes(i, point)[k];
        EXPECT_NEAR(one.detectable_m, two.detectable_m, 1e-5 * two.detectable_m);
        EXPECT_NEAR(one.influence_m, two.influence_m, 1e-5 * two.influence_m);
      }
    }
    const SymmetricEnu& one_m2 = estimated.points.fixed_path_covariance_m2[point];
    const SymmetricEnu& two_m2 = given.points.fixed_path_covariance_m2[point];
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(one_m2[k], two_m2[k], 1e-5 * two_m2[k]);
  }
}

// Closed form: at the end every estimated component has v'Pv = r, to the hundredth of a standard
// deviation where the estimation ends, and the redundancies add up to that of looks and control.
TEST(VarianceComponentsTest, EndWhereEverySquareSumIsItsRedundancy) {
  test::KnownBlock known = BlockOfGroups(test::AircraftPlan(), 7, 40);
  Tell(3.0, 0.5, &known.block);
  AdjustOptions options = ConstantsOf();
  options.variance_components = VarianceComponents::kRangeAzimuth;
  const AdjustResult result = Adjust(known.block, options);
  ASSERT_TRUE(result.usable());
  ASSERT_TRUE(result.variance_components.has_value());
  const VarianceComponentReport& report = *result.variance_components;
  EXPECT_TRUE(report.converged);
  ASSERT_EQ(report.components.size(), 2U);
  const VarianceComponent& range = report.components[0];
  const VarianceComponent& azimuth = report.components[1];
  EXPECT_EQ(range.group, "all");
  EXPECT_EQ(range.looks, 160U);
  EXPECT_EQ(range.unit, "m");
  EXPECT_TRUE(range.estimated && azimuth.estimated);
  // Planted: 9 and 0.25 in variance. Statistics of one seed, 3.3 sigma.
  EXPECT_NEAR(range.factor, 9.0, 3.3 * range.factor_deviation);
  EXPECT_NEAR(azimuth.factor, 0.25, 3.3 * azimuth.factor_deviation);
  EXPECT_LT(range.factor_deviation, 2.0) << "and it is told well";
  EXPECT_LT(azimuth.factor_deviation, 0.06);
  // What the two share makes them less certain than each redundancy alone, 2 / r, would say.
  for (const VarianceComponent& c : {range, azimuth}) {
    EXPECT_GT(c.factor_deviation / c.factor, 1.02 * std::sqrt(2.0 / c.redundancy));
  }
  EXPECT_FALSE(report.before.passed);
  EXPECT_TRUE(result.chi_square_passed);
  for (std::size_t k = 0; k < 2; ++k) {
    const VarianceComponent& c = report.components[k];
    const ObservationGroup& group = result.assessment.groups[k];
    EXPECT_EQ(group.name, k == 0 ? "ranges" : "azimuths");
    EXPECT_NEAR(group.redundancy, c.redundancy, 1e-4);  // of floats
    EXPECT_NEAR(group.factor(), 1.0, 0.01 * c.factor_deviation / c.factor);
  }
  // Other weights leave the priors another part of the redundancy; control keeps its own.
  EXPECT_NEAR(report.before.redundancy, result.test_redundancy, 1.0);
  double control = 0.0;
  for (const ControlQuality& of : result.control_quality) control += of.redundancy;
  EXPECT_NEAR(result.test_redundancy - range.redundancy - azimuth.redundancy, control, 1e-6);
}

// Invariance: what the files say at first changes nothing.
TEST(VarianceComponentsTest, DoNotDependOnTheVariancesGiven) {
  AdjustOptions options = ConstantsOf();
  options.variance_components = VarianceComponents::kRangeAzimuth;
  const test::KnownBlock known = BlockOfGroups(test::AircraftPlan(20.0), 11, 30);
  const AdjustResult plain = Adjust(known.block, options);
  Block reported = known.block;
  Tell(4.0, 0.3, &reported);
  const AdjustResult other = Adjust(reported, options);
  ASSERT_TRUE(plain.usable() && other.usable());
  for (std::size_t k = 0; k < 2; ++k) {
    const VarianceComponent& a = plain.variance_components->components[k];
    const VarianceComponent& b = other.variance_components->components[k];
    // Both stop within a hundredth of the standard deviation.
    EXPECT_NEAR(a.sigma_after(), b.sigma_after(), 0.03 * a.sigma_deviation());
    EXPECT_NEAR(a.sigma_deviation() / b.sigma_deviation(), 1.0, 0.01);
  }
  for (std::size_t j = 0; j < 30; ++j) {
    EXPECT_LT((plain.points.position_m[j] - other.points.position_m[j]).norm(), 0.01) << j;
  }
}

// Statistics of one seed: each group its own.
TEST(VarianceComponentsTest, OfGroupsAndPassesFollowWhatIsPlanted) {
  test::KnownBlock known = BlockOfGroups(test::AircraftPlan(), 3, 160);
  Block reported = known.block;
  reported.passes[1].sigma.range_m /= 3.0;
  reported.passes[3].sigma.range_m /= 3.0;
  AdjustOptions options = ConstantsOf();
  options.variance_components = VarianceComponents::kRangeAzimuth;
  options.variance_groups = {{reported.passes[1].id, reported.passes[3].id}};
  const AdjustResult grouped = Adjust(reported, options);
  ASSERT_TRUE(grouped.variance_components && grouped.usable());
  const auto& two = grouped.variance_components->components;
  ASSERT_EQ(two.size(), 4U);
  EXPECT_EQ(two[0].group, reported.passes[1].id + "+" + reported.passes[3].id);
  EXPECT_NEAR(two[0].factor, 9.0, 3.3 * two[0].factor_deviation);
  for (const std::size_t k : {1U, 2U, 3U}) {
    EXPECT_NEAR(two[k].factor, 1.0, 3.3 * two[k].factor_deviation) << k;
  }
  options.variance_groups.clear();
  options.variance_components = VarianceComponents::kPerPass;
  const AdjustResult each = Adjust(reported, options);
  ASSERT_TRUE(each.variance_components && each.usable());
  ASSERT_EQ(each.variance_components->components.size(), 8U);
  for (const VarianceComponent& c : each.variance_components->components) {
    const bool planted = c.component == 0 && (c.passes[0] == 1 || c.passes[0] == 3);
    EXPECT_NEAR(c.factor, planted ? 9.0 : 1.0, 3.3 * c.factor_deviation)
        << c.group << " " << c.component << " " << c.note;
  }
}

// Two looks per point leave one equation over for four: range and azimuth of few points are not
// determined.
TEST(VarianceComponentsTest, WithoutRedundancyKeepTheirFactorAndAreNamed) {
  test::BlockPlan plan = test::AircraftPlan();
  plan.points = 6;
  plan.looks_per_point = 2;
  test::KnownBlock known = test::MakeBlock(plan);
  test::AddNoise(2, 1.0, &known);
  AdjustOptions options;
  options.variance_components = VarianceComponents::kRangeAzimuth;
  const AdjustResult result = Adjust(known.block, options);
  ASSERT_TRUE(result.usable());
  for (const VarianceComponent& c : result.variance_components->components) {
    EXPECT_FALSE(c.estimated);
    EXPECT_EQ(c.factor, 1.0);
    EXPECT_TRUE(std::isnan(c.factor_deviation));
    EXPECT_THAT(c.note, HasSubstr("redundancy"));
  }
  EXPECT_THAT(result.warnings,
              testing::Contains(HasSubstr("2 of 2 variance components keep the variance given")));
  // The solution is that of the variances given, to the solver's last step.
  EXPECT_NEAR(result.sigma0_squared, result.variance_components->before.sigma0_squared, 1e-6);
}

// Outliers do not inflate the variances of a robust adjustment.
TEST(VarianceComponentsTest, UnderALossAreThoseOfTheLooksKept) {
  test::KnownBlock known = BlockOfGroups(test::AircraftPlan(), 21, 60);
  for (const std::size_t look : {45U, 90U, 150U}) known.block.looks.range_m[look] += 60.0;
  AdjustOptions options = ConstantsOf();
  options.variance_components = VarianceComponents::kRangeAzimuth;
  options.robust = RobustLoss::kHuber;
  const AdjustResult result = Adjust(known.block, options);
  ASSERT_TRUE(result.usable()) << testing::PrintToString(result.warnings);
  for (const VarianceComponent& c : result.variance_components->components) {
    EXPECT_NEAR(c.factor, 1.0, 3.3 * c.factor_deviation);
    EXPECT_LE(c.looks, 237U);
  }
}

TEST(VarianceComponentsTest, GroupsThatDoNotFitAreRefused) {
  const test::KnownBlock known = BlockOfGroups(test::AircraftPlan(), 1, 12);
  AdjustOptions options;
  options.variance_components = VarianceComponents::kRangeAzimuth;
  options.variance_groups = {{"A9"}};
  EXPECT_THROW(static_cast<void>(Adjust(known.block, options)), InputError);
  options.variance_groups = {{known.block.passes[0].id}, {known.block.passes[0].id}};
  EXPECT_THROW(static_cast<void>(Adjust(known.block, options)), InputError);
  options.variance_groups = {{known.block.passes[0].id}};
  options.variance_components = VarianceComponents::kPerPass;
  EXPECT_THROW(static_cast<void>(Adjust(known.block, options)), InputError);
}

}  // namespace
}  // namespace sarblock
