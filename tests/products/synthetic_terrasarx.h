// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "products/synthetic_annotation.h"

namespace sarblock::test {

/// An annotation of TerraSAR-X and its GEOREF.xml, made from the orbit of SyntheticAnnotation: 2001
/// lines of 0.01 s from 23:59:50.25 on, 1001 samples of 5 m from 850123.5 m on, both as annotated.
/// Annotated minus geometric is, with x the annotated two-way time less 5.7e-3 s:
///
///     range time     1.5e-8 s + 2e-5 x (ATMOS) + 2e-10 s (IONO)
///     azimuth time  -1.8e-4 s + 0.01 x (TIMING)
struct SyntheticTerraSarX {
  SyntheticAnnotation orbit;
  double first_line_s = 50.25;

  static constexpr int kLines = 2001, kSamples = 1001;
  static constexpr double kLineInterval_s = 0.01;
  static constexpr double kNearRange_m = 850123.5;
  static constexpr double kPixel_m = 5.0;
  /// "Heights" of the rows of the grid, which has points at lines 0, 1000, 2000 and samples 0, 500,
  /// 1000.
  static double Height_m(int row) { return 100.0 + 1217.0 * row; }

  [[nodiscard]] std::string Xml() const;
  [[nodiscard]] std::string GeorefXml() const;
  /// Of an annotated range.
  [[nodiscard]] static double RangeDelay_m(double range_m);
  [[nodiscard]] static double AzimuthShift_s(double range_m);
};

}  // namespace sarblock::test
