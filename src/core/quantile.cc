// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/quantile.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <string>

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>

namespace sarblock {
namespace {

using ChiSquare = boost::math::chi_squared_distribution<double>;

void CheckProbability(const char* name, double value) {
  if (!(value > 0.0 && value < 1.0)) {  // written so that NaN fails too
    throw InputError(name, std::to_string(value) + " must lie between 0 and 1, both excluded");
  }
}

ChiSquare Distribution(double degrees) {
  if (!(std::isfinite(degrees) && degrees > 0.0)) {
    throw InputError("degrees of freedom", std::to_string(degrees) + " must be greater than 0");
  }
  return ChiSquare(degrees);
}

}  // namespace

double ChiSquareQuantile(double probability, double degrees) {
  CheckProbability("probability", probability);
  return boost::math::quantile(Distribution(degrees), probability);
}

double ChiSquareProbability(double value, double degrees) {
  const ChiSquare distribution = Distribution(degrees);
  if (!(std::isfinite(value) && value >= 0.0)) {
    throw InputError("chi-square value", std::to_string(value) + " must be finite and at least 0");
  }
  return boost::math::cdf(distribution, value);
}

double FisherTailProbability(double value, double numerator, double denominator) {
  for (const double degrees : {numerator, denominator}) {
    if (!(std::isfinite(degrees) && degrees > 0.0)) {
      throw InputError("degrees of freedom", std::to_string(degrees) + " must be greater than 0");
    }
  }
  if (!(std::isfinite(value) && value >= 0.0)) {
    throw InputError("F value", std::to_string(value) + " must be finite and at least 0");
  }
  const boost::math::fisher_f_distribution<double> distribution(numerator, denominator);
  return boost::math::cdf(boost::math::complement(distribution, value));
}

double NormalQuantile(double probability) {
  CheckProbability("probability", probability);
  return boost::math::quantile(boost::math::normal_distribution<double>(), probability);
}

Interval ChiSquareInterval(double level, double degrees) {
  CheckProbability("level", level);
  const ChiSquare distribution = Distribution(degrees);
  const double tail = 0.5 * (1.0 - level);
  // The complement keeps its digits where 1 - tail would lose them.
  return {.lower = boost::math::quantile(distribution, tail),
          .upper = boost::math::quantile(boost::math::complement(distribution, tail))};
}

}  // namespace sarblock
