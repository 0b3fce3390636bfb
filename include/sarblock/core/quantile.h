// SPDX-License-Identifier: Apache-2.0
#pragma once

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

}  // namespace sarblock
