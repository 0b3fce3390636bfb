// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/statistics.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <string>

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/special_functions/erf.hpp>

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

namespace {

constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15u;  // 2^64 / golden ratio, odd

// Finaliser of SplitMix64 (Steele, Lea and Flood, 2014): a bijection of the 64-bit numbers.
std::uint64_t Scramble(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t stream) {
  std::uint64_t counter = MixStream(seed, stream);
  // The four words come from four different counters through a bijection, so at most one of them
  // is zero: the one state xoshiro cannot leave does not occur.
  for (std::uint64_t& word : state_) {
    counter += kGolden;
    word = Scramble(counter);
  }
}

std::uint64_t RandomStream::Bits() {
  const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
  const std::uint64_t shifted = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= shifted;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double RandomStream::Uniform() {
  // 52 bits and a half: every value is exact in a double, and neither 0 nor 1 is among them.
  return (static_cast<double>(Bits() >> 12) + 0.5) * 0x1p-52;
}

double RandomStream::Normal() {
  // Double throughout: the width of long double differs between machines.
  using Policy = boost::math::policies::policy<boost::math::policies::promote_double<false>>;
  return -std::numbers::sqrt2 * boost::math::erfc_inv(2.0 * Uniform(), Policy());
}

std::uint64_t MixStream(std::uint64_t a, std::uint64_t b) {
  return Scramble(Scramble(a + kGolden) + b * kGolden);
}

}  // namespace sarblock
