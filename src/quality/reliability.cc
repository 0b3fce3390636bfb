// SPDX-License-Identifier: Apache-2.0
#include "reliability.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "linear/dense.h"
#include "model/problem.h"
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace sarblock {
namespace {

using Normal = boost::math::normal_distribution<double>;

double LevelOfOne(const QualityOptions& options, std::size_t tests) {
  if (tests < 2) return options.alpha_1;
  const auto n = static_cast<double>(tests);
  switch (options.family_wise) {
    case FamilyWise::kNone:
      break;
    case FamilyWise::kSidak:
      return -std::expm1(std::log1p(-options.alpha_1) / n);
    case FamilyWise::kBonferroni:
      return options.alpha_1 / n;
  }
  return options.alpha_1;
}

double UpperQuantile(double tail_1) {
  return boost::math::quantile(boost::math::complement(Normal(), tail_1));
}

double CriticalTau(double alpha_1, double redundancy) {
  if (!(redundancy > 1.0)) return kNaN;
  const boost::math::students_t_distribution<double> student(redundancy - 1.0);
  const double t = boost::math::quantile(boost::math::complement(student, 0.5 * alpha_1));
  return std::sqrt(redundancy) * t / std::hypot(std::sqrt(redundancy - 1.0), t);
}

/// Newton's method; the power grows with the shift and its slope is a difference of densities.
double NonCentrality(double power_1, double critical_1) {
  double delta = critical_1 + UpperQuantile(1.0 - power_1);
  delta = std::max(delta, 0.1);
  for (int i = 0; i < 60; ++i) {
    const double error = TestPower(delta, critical_1) - power_1;
    const double slope = boost::math::pdf(Normal(), critical_1 - delta) -
                         boost::math::pdf(Normal(), critical_1 + delta);
    const double step = error / slope;
    delta = step < delta ? delta - step : 0.5 * delta;
    if (std::abs(step) < 1e-14 * delta) break;
  }
  return delta;
}

}  // namespace

double TestPower(double shift_1, double critical_1) {
  return boost::math::cdf(Normal(), shift_1 - critical_1) +
         boost::math::cdf(Normal(), -shift_1 - critical_1);
}

ReliabilityFigures MakeReliability(const QualityOptions& options,
                                   std::size_t tests,
                                   double redundancy) {
  if (!(options.alpha_1 > 0.0 && options.alpha_1 < 1.0)) {
    throw InputError("adjust.quality.alpha", "must lie between 0 and 1");
  }
  if (!(options.power_1 > options.alpha_1 && options.power_1 < 1.0)) {
    throw InputError("adjust.quality.power", "must lie between alpha and 1");
  }
  ReliabilityFigures out;
  out.tests = tests;
  out.alpha_one_1 = LevelOfOne(options, tests);
  out.alpha_all_1 = -std::expm1(static_cast<double>(tests) * std::log1p(-out.alpha_one_1));
  out.critical_w_1 = UpperQuantile(0.5 * out.alpha_one_1);
  out.critical_tau_1 = CriticalTau(out.alpha_one_1, redundancy);
  out.delta0_1 = NonCentrality(options.power_1, out.critical_w_1);
  return out;
}

double MinimalDetectable(double delta0_1, double sigma_m, double redundancy_1) {
  return redundancy_1 > kLeastRedundancy_1 ? delta0_1 * sigma_m / std::sqrt(redundancy_1) : kNaN;
}

double Influence_m(double delta0_1, double shift_m, double redundancy_1) {
  return MinimalDetectable(delta0_1, shift_m, redundancy_1);
}

double SquareLeftOut(std::size_t dropped, std::size_t looks, const AdjustResult& result) {
  constexpr double kMostByChance_1 = 0.01;
  const double limit_1 = FarSquare_1();
  double square_1 = 0.0, count = 0.0;
  const auto add = [&](double number, double each_1) {
    square_1 += number * each_1;
    count += number;
  };
  add(static_cast<double>(dropped), limit_1);
  if (result.snooping) {
    add(static_cast<double>(result.snooping->robust.size()), limit_1);
    for (const BlunderFinding& finding : result.snooping->findings) {
      if (!LeavesOut(finding)) continue;
      // One statistic tells of all the looks of a point that contradict each other.
      const double square = finding.w_1 * finding.w_1;
      add(1.0, square < limit_1 ? square : limit_1);  // no w of its own: NaN
    }
  }
  const double most = kMostByChance_1 * static_cast<double>(looks);
  return count > most ? square_1 * most / count : square_1;
}

GlobalTest TestGlobally(const AdjustmentProblem& problem,
                        double level,
                        double square_sum_1,
                        double left_out_1) {
  const ProblemCounts counts = CountProblem(problem);
  GlobalTest test;
  test.redundancy_1 = counts.redundancy();
  if (!(test.redundancy_1 > 0.0)) return test;
  test.sigma0_squared = square_sum_1 / test.redundancy_1;
  test.chi_square = ChiSquareInterval(level, test.redundancy_1);
  test.chi_square.lower = std::max(0.0, test.chi_square.lower - left_out_1);
  test.passed = test.chi_square.Contains(square_sum_1);
  return test;
}

void FillChecks(const Block& block, const AdjustOptions& options, AdjustResult* result) {
  const double factor_1 = CovarianceFactor(options, *result);
  for (const KnownPosition& known : block.points.known) {
    const std::size_t point = known.point;
    if (block.points.role[point] != PointRole::kCheck) continue;
    if (!result->points.position_m[point].allFinite()) continue;
    CheckResult check;
    check.point = known.point;
    const Eigen::Vector3d error_m =
        block.frame.EnuFromFrame(block.points.given_m[point]) *
        (result->points.position_m[point] - block.points.given_m[point]);
    check.error_enu_m.setConstant(kNotGiven);
    std::array<int, 3> held{};
    for (int i = 0; i < 3; ++i) {
      if (!known.held[static_cast<std::size_t>(i)]) continue;
      check.error_enu_m[i] = error_m[i];
      if (!result->points.covariance_m2.empty()) {
        check.sigma_enu_m[i] =
            std::sqrt(factor_1 * result->points.covariance_m2[point][static_cast<std::size_t>(i)] +
                      known.covariance_enu_m2(i, i));
      }
      held[static_cast<std::size_t>(check.components++)] = i;
    }
    check.chi_square = kNotGiven;
    if (!result->points.covariance_m2.empty() && IsSolved(result->points.status[point]) &&
        check.components > 0) {
      const Eigen::Matrix3d full =
          factor_1 * MatrixOf(result->points.covariance_m2[point]) + known.covariance_enu_m2;
      Eigen::MatrixXd part(check.components, check.components);
      Eigen::VectorXd e(check.components);
      for (int i = 0; i < check.components; ++i) {
        e[i] = error_m[held[static_cast<std::size_t>(i)]];
        for (int j = 0; j < check.components; ++j) {
          part(i, j) = full(held[static_cast<std::size_t>(i)], held[static_cast<std::size_t>(j)]);
        }
      }
      const dense::Cholesky factor(part);
      if (factor.positive_definite()) {
        check.chi_square = factor.SolveLower(e).squaredNorm();
      }
    }
    result->checks.push_back(check);
  }
}

}  // namespace sarblock
