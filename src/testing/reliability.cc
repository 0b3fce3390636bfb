// SPDX-License-Identifier: Apache-2.0
#include "reliability.h"

#include "sarblock/core/error.h"
#include "sarblock/model/result.h"

#include <cmath>
#include <string>

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

}  // namespace sarblock
