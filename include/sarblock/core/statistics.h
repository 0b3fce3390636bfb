// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sarblock {

/// Quantile of the chi-square distribution: P(X <= result) = `probability` for `degrees` > 0
/// degrees of freedom (any real number). Throws InputError outside 0 < probability < 1.
[[nodiscard]] double ChiSquareQuantile(double probability, double degrees);

/// P(X <= value) of the chi-square distribution; value >= 0, degrees > 0.
[[nodiscard]] double ChiSquareProbability(double value, double degrees);

/// P(X > value) of Fisher's F distribution with `numerator` and `denominator` > 0 degrees of
/// freedom; value >= 0. Keeps its digits in the tail.
[[nodiscard]] double FisherTailProbability(double value, double numerator, double denominator);

/// Quantile of the standard normal distribution, 0 < probability < 1.
[[nodiscard]] double NormalQuantile(double probability);

/// A two-sided acceptance interval.
struct Interval {
  double lower = 0.0;
  double upper = 0.0;
  [[nodiscard]] bool Contains(double value) const { return lower <= value && value <= upper; }
};

/// Two-sided interval holding a chi-square variable of `degrees` with probability `level`.
[[nodiscard]] Interval ChiSquareInterval(double level, double degrees);

/// Median of values, none of which may be NaN: for an even number the upper of the two middle ones;
/// NaN without values. Changes their order.
template <typename T>
[[nodiscard]] T MedianInPlace(std::vector<T>* values) {
  if (values->empty()) return std::numeric_limits<T>::quiet_NaN();
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

/// The same on a copy.
template <typename T>
[[nodiscard]] T Median(std::vector<T> values) {
  return MedianInPlace(&values);
}

/// A reproducible stream of random numbers: same (seed, stream) gives the same numbers on every
/// machine, compiler and thread count. One stream per thing that is random (a pass, a point, a
/// look), so that work may be shared among threads without changing a number.
/// Generator: SplitMix64 seeding of xoshiro256++ (Blackman and Vigna, 2019); normals by the
/// inverse distribution function, one uniform each.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t stream);
  [[nodiscard]] std::uint64_t Bits();
  [[nodiscard]] double Uniform();  ///< in the open interval (0, 1)
  [[nodiscard]] double Normal();   ///< mean 0, standard deviation 1

 private:
  std::uint64_t state_[4];
};

/// Mixes numbers (for example a kind and an index) into one stream number.
[[nodiscard]] std::uint64_t MixStream(std::uint64_t a, std::uint64_t b);

}  // namespace sarblock
