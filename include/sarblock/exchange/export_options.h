// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sarblock {

struct ExportOptions {
  /// Probability of the ellipses (error_ellipse.h); left out: standard ellipses, 39.3 percent.
  std::optional<double> confidence_1;
  bool ellipses = true;           ///< GeoJSON, KML, GeoPackage: as polygons too, 1 to 2 kB each
  bool cross_covariances = true;  ///< SINEX: also between the points of pairs.csv
  std::string agency = "SBK";     ///< SINEX: three characters
  std::string mission;            ///< orbit files; empty: from the ids of the passes
  std::string created_utc;        ///< of the file, "2022-10-16T01:50:44Z"; empty: not told
};

/// What was written.
struct ExportReport {
  std::vector<std::filesystem::path> files;
  std::size_t points = 0;
  std::size_t points_left_out = 0;  ///< not solved
  std::size_t ellipses = 0;         ///< as polygons
  std::size_t paths = 0;
  std::vector<std::string> warnings;
};

}  // namespace sarblock
