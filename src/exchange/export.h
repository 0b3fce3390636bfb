// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/files/result.h"
#include "sarblock/tables/output.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "products/block_builder.h"

namespace sarblock {

/// Formats of other programs that a result can be written in (docs/export.md: conventions, and
/// what each of them cannot represent).
enum class ExportFormat {
  kGeoJson,     ///< points, error ellipses, flight paths; geocentric frames
  kKml,         ///< the same, styled by role; geocentric frames
  kGeoPackage,  ///< the same as layers of one SQLite file; local frames too
  kIsis,        ///< residuals.csv and bundleout_points.csv of ISIS jigsaw; geocentric frames
  kSinex,       ///< SINEX 2.02, estimates and covariance; geocentric frames
  kOrbitFiles,  ///< one Sentinel-1 orbit file per pass; WGS84, passes with an epoch in UTC
  kCsmStates,   ///< a model state of USGSCSM an image given; geocentric, passes with an epoch
  kSicd,        ///< the XML of a SICD image given, with AdjustableParameterOffsets; one per image
};

/// Names on the command line, in the order of the enumeration: geojson, kml, gpkg, isis, sinex,
/// eof, csm, sicd.
[[nodiscard]] const std::vector<std::string>& ExportFormatNames();

/// Default place of an export: `export.geojson`, `export.kml`, `export.gpkg`, folder
/// `isis`, `export.snx`, folders `eof`, `csm` and `sicd`.
[[nodiscard]] const char* DefaultExportName(ExportFormat format);

/// The file of the image of a pass.
struct ExportImage {
  std::string pass, file;
};

struct ExportOptions {
  /// Probability of the ellipses (quality/covariance.h); left out: standard ellipses, 39.3 percent.
  std::optional<double> confidence;
  bool ellipses = true;           ///< GeoJSON, KML, GeoPackage: as polygons too, 1 to 2 kB each
  bool cross_covariances = true;  ///< SINEX: also between the points of pairs.csv
  std::string agency = "SBK";     ///< SINEX: three characters
  std::string mission;            ///< orbit files; empty: from the ids of the passes
  std::string created_utc;        ///< of the file, "2022-10-16T01:50:44Z"; empty: not given
  /// Model states, SICD: images as they were imported, at most one per pass; others are left out.
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
  /// Content of the result that the files do not carry, a phrase each, with its size where it has
  /// one.
  std::vector<std::string> not_carried;
};

/// Writes a result in one format: a file, or a folder for kIsis, kOrbitFiles, kCsmStates and kSicd.
/// Files appear whole or not at all. Points that are not solved are left out. Covariances are those
/// of the result's tables. The same result and options give the same bytes.
///
/// The report lists what the format leaves out. Throws InputError where the format cannot represent
/// the result or lacks something (a local frame, no epoch in UTC, too many points, no image) and
/// for options that make no sense, before anything is written.
ExportReport ExportResult(const files::ResultFile& result,
                          ExportFormat format,
                          const std::filesystem::path& out,
                          const ExportOptions& options);

/// Throws InputError where ExportResult() must not write: `out` is a folder in place of a file or
/// the reverse, or (kRefuse) there are files that it did not write in this format.
void RequireTargetFor(ExportFormat format, const std::filesystem::path& out, ForeignFiles foreign);

/// What the writers of the single formats share.
struct ExportView {
  const files::ResultFile& result;
  const ExportOptions& options;
  double ellipse_scale = 1.0;
  std::vector<std::uint32_t> points;  ///< solved ones, in their order

  [[nodiscard]] bool HasCovariance(std::uint32_t point) const;
  /// What positions refer to: "ITRF2014 at 2022.79"; empty: not known.
  [[nodiscard]] std::string Realization() const;
  [[nodiscard]] const Eigen::Vector3d& Position_m(std::uint32_t point) const {
    return result.points.results.position_m[point];
  }
  [[nodiscard]] const SymmetricEnu& Covariance_m2(std::uint32_t point) const {
    return result.points.results.covariance_m2[point];
  }
};

inline bool ExportView::HasCovariance(std::uint32_t point) const {
  return !result.points.results.covariance_m2.empty() &&
         !std::isnan(result.points.results.covariance_m2[point][0]);
}

/// KML (docs/export.md).
void WriteKml(const std::filesystem::path& file, const ExportView& view, ExportReport* report);

/// GeoPackage, one SQLite file (docs/export.md).
void WriteGeoPackage(const std::filesystem::path& file,
                     const ExportView& view,
                     ExportReport* report);

/// The table of points and their site codes beside a SINEX file.
[[nodiscard]] std::filesystem::path SitesOf(std::filesystem::path sinex);

/// SINEX 2.02 (docs/export.md).
void WriteSinex(const std::filesystem::path& file, const ExportView& view, ExportReport* report);

/// Tables of ISIS jigsaw (docs/export.md).
void WriteIsisTables(const std::filesystem::path& folder,
                     const ExportView& view,
                     ExportReport* report);

/// A model state of USGSCSM's SAR model for each image given (docs/export.md).
void WriteCsmStates(const std::filesystem::path& folder,
                    const ExportView& view,
                    ExportReport* report);

/// The XML of each SICD image given, with the result's offsets (docs/export.md).
void WriteSicdOffsets(const std::filesystem::path& folder,
                      const ExportView& view,
                      ExportReport* report);

/// One Sentinel-1 orbit file per pass (docs/export.md).
void WriteOrbitFiles(const std::filesystem::path& folder,
                     const ExportView& view,
                     ExportReport* report);

}  // namespace sarblock
