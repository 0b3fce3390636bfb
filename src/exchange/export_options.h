// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "products/block_builder.h"

namespace sarblock {

/// The file of the image of a pass.
struct ExportImage {
  std::string pass, file;
};

struct ExportOptions {
  /// Probability of the ellipses (quality/covariance.h); left out: standard ellipses, 39.3 percent.
  std::optional<double> confidence_1;
  bool ellipses = true;           ///< GeoJSON, KML, GeoPackage: as polygons too, 1 to 2 kB each
  bool cross_covariances = true;  ///< SINEX: also between the points of pairs.csv
  std::string agency = "SBK";     ///< SINEX: three characters
  std::string mission;            ///< orbit files; empty: from the ids of the passes
  std::string created_utc;        ///< of the file, "2022-10-16T01:50:44Z"; empty: not told
  /// Model states, SICD: images as they were imported, at most one a pass; others are left out.
  std::vector<ExportImage> images;
  /// Model states: how the block was imported, `import csm --range-polynomial`.
  RangePolynomialTimes range_polynomial = RangePolynomialTimes::kGiven;
};

/// What was written.
struct ExportReport {
  std::vector<std::filesystem::path> files;
  std::size_t points = 0;
  std::size_t points_left_out = 0;  ///< not solved
  std::size_t ellipses = 0;         ///< as polygons
  std::size_t paths = 0;
  std::vector<std::string> warnings;
  /// What the result holds and the files do not, a phrase each, with its size where it has one.
  std::vector<std::string> not_carried;
};

}  // namespace sarblock
