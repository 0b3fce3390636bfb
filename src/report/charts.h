// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace sarblock {

/// Charts as data for report.js: values with five significant digits, what is not a number as null.

struct ChartAxis {
  std::string label;
  bool logarithmic = false;
  double least = std::numeric_limits<double>::quiet_NaN();  ///< NaN: as the data are
  double most = std::numeric_limits<double>::quiet_NaN();
};

/// One series. `style`: "points", "line", "dash", "steps" (filled), "band" (between low and high),
/// "bars" (points with a bar from low to high). `color`: a name of report.js.
struct ChartSeries {
  std::string label, style, color;
  std::vector<double> x, y, low, high;
  std::vector<std::string> names;  ///< of points, shown when pointed at; empty: none
  bool written = false;            ///< names are also written next to their points
};

struct XyChart {
  ChartAxis x, y;
  std::vector<ChartSeries> series;
};
[[nodiscard]] std::string ChartJson(const std::string& id, const XyChart& chart);
/// Gives the y axis the ends of the data with a margin; logarithmic where they span a factor of 5.
void FitY(XyChart* chart);

using ChartPlaces = std::vector<std::array<double, 2>>;  ///< in the unit of the map

/// A map with equal scales. Points are coloured by one of several values, each with its own scale.
struct MapChart {
  std::string unit;  ///< "km"
  struct Line {
    std::string name;
    ChartPlaces places;
  };
  std::vector<Line> tracks, swaths;
  ChartPlaces points;
  std::vector<std::string> point_names;
  struct Value {
    std::string label;
    std::vector<double> of_point;
    double low = 0.0, high = 0.0;    ///< ends of the colour scale
    double least = 0.0, most = 0.0;  ///< of the values that the scale covers
    bool weak_where_low = false;     ///< dark colours are for what is weak
  };
  std::vector<Value> values;
  std::size_t shown = 0;    ///< of `values`, at first
  bool logarithmic = true;  ///< colour scale
  double unit_m = 1.0;
  ChartPlaces control, checks;
  std::vector<std::string> control_names, check_names;
  /// Place, half axes and azimuth [rad] of the long one; true size, report.js enlarges.
  std::vector<std::array<double, 5>> ellipses;
  std::vector<std::array<double, 4>> errors;  ///< place and error, true size
  std::vector<Line> graticule;
};
[[nodiscard]] std::string ChartJson(const std::string& id, const MapChart& chart);

/// Figures of a report: small statistics of any values. NaN are left out everywhere.

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
  double expected = 0.0;
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
