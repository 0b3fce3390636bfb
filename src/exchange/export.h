// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/files/result.h"
#include "sarblock/tables/output.h"

#include <filesystem>
#include <string>
#include <vector>

#include "formats.h"

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

/// Writes a result in one format: a file, or a folder for kIsis, kOrbitFiles, kCsmStates and kSicd.
/// Files appear whole or not at all. Points that are not solved are left out. Covariances are those
/// of the result's tables. The same result and options give the same bytes.
///
/// The report lists what the format leaves out. Throws InputError for what it cannot go without (a
/// local frame, no epoch in UTC, too many points, no image) and for options that make no sense,
/// before anything is written.
ExportReport ExportResult(const files::ResultFile& result,
                          ExportFormat format,
                          const std::filesystem::path& out,
                          const ExportOptions& options);

/// Throws InputError where ExportResult() must not write: `out` is a folder in place of a file or
/// the reverse, or (kRefuse) there are files that it did not write in this format.
void RequireTargetFor(ExportFormat format, const std::filesystem::path& out, ForeignFiles foreign);

}  // namespace sarblock
