// SPDX-License-Identifier: Apache-2.0
#include "export.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "files/result_tables.h"
#include "quality/covariance.h"

namespace sarblock {

std::string ExportView::Realization() const {
  if (result.realization.empty() || std::isnan(result.epoch_year)) return result.realization;
  return result.realization + " at " + NumberText(result.epoch_year);
}

namespace {

void RequireGeocentric(const files::ResultFile& result, const char* format) {
  if (result.frame.kind() == FrameKind::kGeocentric) return;
  throw InputError("format",
                   std::string(format) +
                       " needs a place on a body; the frame of this result is local (gpkg takes "
                       "its x, y, z as they are)");
}

void WriteGeoJsonFile(const std::filesystem::path& file,
                      const ExportView& view,
                      ExportReport* report) {
  const files::ResultFile& result = view.result;
  files::GeoJsonContent content{.frame = result.frame,
                                .name = result.summary.block,
                                .ids = result.points.ids,
                                .role = result.points.role,
                                .points = result.points.results,
                                .polygons = view.options.ellipses,
                                .confidence = view.options.confidence,
                                .checks = &result.points.checks};
  for (const files::ResultPass& pass : result.passes)
    content.paths.emplace_back(pass.id, &pass.path);
  files::WriteGeoJson(file, content);
  for (const std::uint32_t point : view.points) {
    report->ellipses += view.options.ellipses && view.HasCovariance(point) ? 1U : 0U;
  }
  report->paths = result.passes.size();
  report->files.push_back(file);
}

// What maps of points, ellipses and paths leave out.
const char* LeftOutOfMaps(const files::ResultFile& result) {
  return result.parameters.empty() ? "residuals, covariances of different points"
                                   : "residuals, parameters of passes, covariances of different "
                                     "points";
}

}  // namespace

const std::vector<std::string>& ExportFormatNames() {
  static const std::vector<std::string> names{
      "geojson", "kml", "gpkg", "isis", "sinex", "eof", "csm", "sicd"};
  return names;
}

const char* DefaultExportName(ExportFormat format) {
  switch (format) {
    case ExportFormat::kGeoJson:
      return "export.geojson";
    case ExportFormat::kKml:
      return "export.kml";
    case ExportFormat::kGeoPackage:
      return "export.gpkg";
    case ExportFormat::kIsis:
      return "isis";
    case ExportFormat::kSinex:
      return "export.snx";
    case ExportFormat::kOrbitFiles:
      return "eof";
    case ExportFormat::kCsmStates:
      return "csm";
    case ExportFormat::kSicd:
      return "sicd";
  }
  return "";
}

ExportReport ExportResult(const files::ResultFile& result,
                          ExportFormat format,
                          const std::filesystem::path& out,
                          const ExportOptions& options) {
  ExportView view{result, options, 1.0, {}};
  if (options.confidence) view.ellipse_scale = EllipseScale(*options.confidence);
  const auto count = static_cast<std::uint32_t>(result.points.size());
  for (std::uint32_t point = 0; point < count; ++point) {
    if (IsSolved(result.points.results.status[point])) view.points.push_back(point);
  }
  ExportReport report;
  report.points = view.points.size();
  report.points_left_out = result.points.size() - view.points.size();
  switch (format) {
    case ExportFormat::kGeoJson:
      RequireGeocentric(result, "GeoJSON");
      WriteGeoJsonFile(out, view, &report);
      report.not_carried.emplace_back(LeftOutOfMaps(result));
      break;
    case ExportFormat::kKml:
      RequireGeocentric(result, "KML");
      WriteKml(out, view, &report);
      report.not_carried.emplace_back(LeftOutOfMaps(result));
      break;
    case ExportFormat::kGeoPackage:
      WriteGeoPackage(out, view, &report);
      report.not_carried.emplace_back(LeftOutOfMaps(result));
      break;
    case ExportFormat::kIsis:
      RequireGeocentric(result, "ISIS");
      WriteIsisTables(out, view, &report);
      report.not_carried.emplace_back(
          "parameters and flight paths of passes, covariances of different points, quality "
          "figures");
      break;
    case ExportFormat::kSinex:
      RequireGeocentric(result, "SINEX");
      WriteSinex(out, view, &report);
      break;
    case ExportFormat::kOrbitFiles:
      report.points = report.points_left_out = 0;
      WriteOrbitFiles(out, view, &report);
      break;
    case ExportFormat::kCsmStates:
      report.points = report.points_left_out = 0;
      WriteCsmStates(out, view, &report);
      break;
    case ExportFormat::kSicd:
      report.points = report.points_left_out = 0;
      WriteSicdOffsets(out, view, &report);
      break;
  }
  return report;
}

void RequireTargetFor(ExportFormat format, const std::filesystem::path& out, ForeignFiles foreign) {
  switch (format) {
    case ExportFormat::kGeoJson:
      return RequireFileFor(out, {"\"generator\":\"sarblock\""}, foreign);
    case ExportFormat::kKml:
    case ExportFormat::kGeoPackage:
      return RequireFileFor(out, {"written by sarblock"}, foreign);
    case ExportFormat::kIsis:
      return RequireFilesFor(out,
                             {",,,x image,y image,Measured,Measured,sample,line,Residual Vector\n",
                              ",,,,,3-d,3-d,3-d,Sigma,Sigma,Sigma,Correction,Correction,"},
                             foreign);
    case ExportFormat::kSinex:
      RequireFileFor(out, {" SOFTWARE           sarblock "}, foreign);
      return RequireFileFor(SitesOf(out), {"code,point,role\n"}, foreign);
    case ExportFormat::kOrbitFiles:
      return RequireFilesFor(out, {"<Creator>sarblock</Creator>"}, foreign);
    case ExportFormat::kCsmStates:
    case ExportFormat::kSicd:
      return RequireFilesFor(out, {"written by sarblock"}, foreign);
  }
}

}  // namespace sarblock
