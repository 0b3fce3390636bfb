// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sarblock {

/// Figures of a report: small statistics of whatever the values are. NaN are left out everywhere.

/// Quantile by linear interpolation between order statistics: position p (n - 1), p in [0, 1].
/// NaN without values.
[[nodiscard]] double SampleQuantile(std::vector<double> values, double probability);

/// Several quantiles of the same values with one sort.
[[nodiscard]] std::vector<double> SampleQuantiles(std::vector<double> values,
                                                  std::span<const double> probabilities);

/// Counts of values in equal bins over [lower, upper]. The first and last bin also take what lies
/// outside, so that nothing vanishes from a picture.
struct Histogram {
  double lower = 0.0, upper = 0.0;
  std::vector<std::size_t> counts;
  std::size_t below = 0, above = 0;  ///< of those, how many lay outside
  [[nodiscard]] std::size_t total() const;
};
[[nodiscard]] Histogram CountInBins(std::span<const float> values,
                                    double lower,
                                    double upper,
                                    std::size_t bins);

/// One point of a quantile plot: the normal quantile expected of an ordered value, and the value.
struct QuantilePoint {
  double expected_1 = 0.0;
  double value = 0.0;
};
/// Normal quantile plot, expected quantiles at (i - 0.5) / n (Hazen). Above `most` points the tails
/// are kept one by one and the middle is thinned evenly.
[[nodiscard]] std::vector<QuantilePoint> NormalQuantilePlot(std::span<const float> values,
                                                            std::size_t most);

/// A sample of `most` of `count` indices, ascending: the same for the same numbers, without regard
/// to the order of the data (the smallest hashes of the indices). All of them where count <= most.
[[nodiscard]] std::vector<std::uint32_t> SampleIndices(std::size_t count, std::size_t most);

/// Medians of y in equal bins of x. A bin with fewer than `least` values is left out.
struct BinnedMedian {
  double x = 0.0;  ///< middle of the bin
  double value = 0.0;
  std::size_t count = 0;
};
[[nodiscard]] std::vector<BinnedMedian> MedianInBins(std::span<const double> x,
                                                     std::span<const double> values,
                                                     std::size_t bins,
                                                     std::size_t least);

/// The largest of 1, 2, 5 times a power of ten that is not above a positive value.
[[nodiscard]] double RoundDown125(double value);

/// True for (x, y) inside or on the convex hull of other places.
class ConvexHull {
 public:
  explicit ConvexHull(std::vector<std::array<double, 2>> places_m);
  [[nodiscard]] bool Contains(double x_m, double y_m) const;
  /// False with fewer than three places that are not on one line.
  [[nodiscard]] bool HasArea() const { return corners_m_.size() > 2; }

 private:
  std::vector<std::array<double, 2>> corners_m_;  // counter-clockwise
};

}  // namespace sarblock
