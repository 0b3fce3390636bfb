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
  if (tests < 2) return options.alpha;
  const auto n = static_cast<double>(tests);
  switch (options.family_wise) {
    case FamilyWise::kNone:
      break;
    case FamilyWise::kSidak:
      return -std::expm1(std::log1p(-options.alpha) / n);
    case FamilyWise::kBonferroni:
      return options.alpha / n;
  }
  return options.alpha;
}

double UpperQuantile(double tail) {
  return boost::math::quantile(boost::math::complement(Normal(), tail));
}

double CriticalTau(double alpha, double redundancy) {
  if (!(redundancy > 1.0)) return kNaN;
  // With hardly any freedom the quantile is beyond all numbers, tau at its largest.
  using Unbounded = boost::math::policies::policy<
      boost::math::policies::overflow_error<boost::math::policies::ignore_error>>;
  const boost::math::students_t_distribution<double, Unbounded> student(redundancy - 1.0);
  const double t = boost::math::quantile(boost::math::complement(student, 0.5 * alpha));
  if (std::isinf(t)) return std::sqrt(redundancy);
  return std::sqrt(redundancy) * t / std::hypot(std::sqrt(redundancy - 1.0), t);
}

/// Newton's method; the power grows with the shift and its slope is a difference of densities.
double NonCentrality(double power, double critical) {
  double delta = critical + UpperQuantile(1.0 - power);
  delta = std::max(delta, 0.1);
  for (int i = 0; i < 60; ++i) {
    const double error = TestPower(delta, critical) - power;
    const double slope =
        boost::math::pdf(Normal(), critical - delta) - boost::math::pdf(Normal(), critical + delta);
    const double step = error / slope;
    delta = step < delta ? delta - step : 0.5 * delta;
    if (std::abs(step) < 1e-14 * delta) break;
  }
  return delta;
}

}  // namespace

double TestPower(double shift, double critical) {
  return boost::math::cdf(Normal(), shift - critical) +
         boost::math::cdf(Normal(), -shift - critical);
}

ReliabilityFigures MakeReliability(const QualityOptions& options,
                                   std::size_t tests,
                                   double redundancy) {
  if (!(options.alpha > 0.0 && options.alpha < 1.0)) {
    throw InputError("adjust.quality.alpha", "must lie between 0 and 1");
  }
  if (!(options.power > options.alpha && options.power < 1.0)) {
    throw InputError("adjust.quality.power", "must lie between alpha and 1");
  }
  ReliabilityFigures out;
  out.tests = tests;
  out.alpha_one = LevelOfOne(options, tests);
  out.alpha_all = -std::expm1(static_cast<double>(tests) * std::log1p(-out.alpha_one));
  out.critical_w = UpperQuantile(0.5 * out.alpha_one);
  out.critical_tau = CriticalTau(out.alpha_one, redundancy);
  out.delta0 = NonCentrality(options.power, out.critical_w);
  return out;
}

double MinimalDetectable(double delta0, double sigma_m, double redundancy) {
  return redundancy > kMinRedundancy ? delta0 * sigma_m / std::sqrt(redundancy) : kNaN;
}

double Influence_m(double delta0, double shift_m, double redundancy) {
  return MinimalDetectable(delta0, shift_m, redundancy);
}

double SquareLeftOut(std::size_t dropped, std::size_t looks, const AdjustResult& result) {
  constexpr double kMaxByChance = 0.01;
  const double limit = FarSquare();
  double square_sum = 0.0, count = 0.0;
  const auto add = [&](double number, double square_each) {
    square_sum += number * square_each;
    count += number;
  };
  add(static_cast<double>(dropped), limit);
  if (result.snooping) {
    add(static_cast<double>(result.snooping->robust.size()), limit);
    for (const BlunderFinding& finding : result.snooping->findings) {
      if (!LeavesOut(finding)) continue;
      // One statistic is for all the looks of a point that contradict each other.
      const double square = finding.w * finding.w;
      add(1.0, square < limit ? square : limit);  // no w of its own: NaN
    }
  }
  const double most = kMaxByChance * static_cast<double>(looks);
  return count > most ? square_sum * most / count : square_sum;
}

void FillChecks(const Block& block, const AdjustOptions& options, AdjustResult* result) {
  const double variance_factor = PosteriorFactor(options, *result);
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
    std::array<int, 3> fixed{};
    for (int i = 0; i < 3; ++i) {
      if (!known.fixed[static_cast<std::size_t>(i)]) continue;
      check.error_enu_m[i] = error_m[i];
      if (!result->points.covariance_m2.empty()) {
        check.sigma_enu_m[i] = std::sqrt(
            variance_factor * result->points.covariance_m2[point][static_cast<std::size_t>(i)] +
            known.covariance_enu_m2(i, i));
      }
      fixed[static_cast<std::size_t>(check.components++)] = i;
    }
    check.chi_square = kNotGiven;
    if (!result->points.covariance_m2.empty() && IsSolved(result->points.status[point]) &&
        check.components > 0) {
      const Eigen::Matrix3d full =
          variance_factor * MatrixOf(result->points.covariance_m2[point]) + known.covariance_enu_m2;
      Eigen::MatrixXd part(check.components, check.components);
      Eigen::VectorXd e(check.components);
      for (int i = 0; i < check.components; ++i) {
        e[i] = error_m[fixed[static_cast<std::size_t>(i)]];
        for (int j = 0; j < check.components; ++j) {
          part(i, j) = full(fixed[static_cast<std::size_t>(i)], fixed[static_cast<std::size_t>(j)]);
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
