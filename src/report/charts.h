// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>
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
  bool written = false;            ///< names also stand beside their points
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
    double least = 0.0, most = 0.0;  ///< of the values that the scale stands for
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

}  // namespace sarblock
