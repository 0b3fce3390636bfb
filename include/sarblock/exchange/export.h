// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/io/result_reader.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sarblock {

/// Formats of other programs that a result can be written in (docs/export.md: conventions, and what
/// each of them cannot hold).
enum class ExportFormat {
  kGeoJson,     ///< points, error ellipses, flight paths; geocentric frames
  kKml,         ///< the same, styled by role; geocentric frames
  kGeoPackage,  ///< the same as layers of one SQLite file; local frames too
  kIsis,        ///< residuals.csv and bundleout_points.csv of ISIS jigsaw; geocentric frames
  kSinex,       ///< SINEX 2.02, estimates and covariance; geocentric frames
  kOrbitFiles,  ///< one Sentinel-1 orbit file a pass; WGS84, passes with an epoch in UTC
};

/// Names on the command line, in the order of the enumeration: geojson, kml, gpkg, isis, sinex,
/// eof.
[[nodiscard]] const std::vector<std::string>& ExportFormatNames();

/// Where a result goes unless told otherwise: `export.geojson`, `export.kml`, `export.gpkg`, folder
/// `isis`, `export.snx`, folder `eof`.
[[nodiscard]] const char* DefaultExportName(ExportFormat format);

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

/// Writes a result in one format: a file, or a folder for kIsis and kOrbitFiles. Files appear whole
/// or not at all. Points that are not solved are left out. Covariances are those of the result's
/// tables. The same result and options give the same bytes.
///
/// Throws InputError for what the format cannot hold (a local frame, no epoch in UTC, too many
/// points) and for options that make no sense, before anything is written.
ExportReport ExportResult(const ResultFile& result,
                          ExportFormat format,
                          const std::filesystem::path& out,
                          const ExportOptions& options);

}  // namespace sarblock
