// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/error.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tables/table.h"

namespace sarblock::files {

/// What the writers of the single files of a result share.
struct ResultView {
  const Block& block;
  const IdTable& pass_ids;
  const AdjustOptions& options;
  const AdjustResult& result;
};

/// A figure of a result in a table, angles in degrees: one list for writing and reading.
template <typename Of, typename Member>
struct TableFigure {
  std::size_t column;
  Member Of::*member;
  double written = 1.0, read = 1.0;  ///< factors
};
inline constexpr std::array<TableFigure<PointResults, std::vector<double>>, 7> kPointFigures{{
    {kResultPointColumns("intersection_deg"),
     &PointResults::intersection_rad,
     kDegPerRad,
     kRadPerDeg},
    {kResultPointColumns("sigma_leberl_across_m"), &PointResults::sigma_leberl_across_m},
    {kResultPointColumns("sigma_leberl_up_m"), &PointResults::sigma_leberl_up_m},
    {kResultPointColumns("sigma_leberl_path_across_m"), &PointResults::sigma_leberl_path_across_m},
    {kResultPointColumns("sigma_leberl_path_up_m"), &PointResults::sigma_leberl_path_up_m},
    {kResultPointColumns("leberl_across_azimuth_deg"),
     &PointResults::leberl_across_azimuth_rad,
     kDegPerRad,
     kRadPerDeg},
    {kResultPointColumns("redundancy"), &PointResults::redundancy},
}};
inline constexpr std::array<TableFigure<PairResult, double>, 4> kPairFigures{{
    {kPairColumns("sigma_leberl_across_m"), &PairResult::sigma_leberl_across_m},
    {kPairColumns("sigma_leberl_up_m"), &PairResult::sigma_leberl_up_m},
    {kPairColumns("sigma_leberl_path_across_m"), &PairResult::sigma_leberl_path_across_m},
    {kPairColumns("sigma_leberl_path_up_m"), &PairResult::sigma_leberl_path_up_m},
}};

/// "score", "wald" or nothing.
[[nodiscard]] const char* NameOf(SelectionTest test);

void WritePointTable(TableSink* sink, const ResultView& view);
void WriteParameterTable(TableSink* sink, const ResultView& view);
void WriteParameterCovariance(TableSink* sink, const ResultView& view);
void WriteSelectionTable(TableSink* sink, const ResultView& view);
void WriteSimplificationTable(TableSink* sink, const ResultView& view);
void WriteResidualTable(TableSink* sink, const ResultView& view);
void WriteControlTable(TableSink* sink, const ResultView& view);
void WritePairTable(TableSink* sink, const ResultView& view);
void WriteStripTable(TableSink* sink, const ResultView& view);
/// montecarlo.csv: the points compared, sample against rigorous standard deviations.
void WriteMonteCarloTable(TableSink* sink, const ResultView& view);

/// Name of a role in tables: "tie", "control", "check".
[[nodiscard]] const char* NameOf(PointRole role);

/// The errors of a check point in results sorted by point; null for other points.
[[nodiscard]] const CheckResult* FindCheck(const std::vector<CheckResult>& checks,
                                           std::uint32_t point);

/// What a GeoJSON file of points is made of; views that must outlive the call.
struct GeoJsonContent {
  const Frame& frame;
  const std::string& name;
  const IdTable& ids;
  const std::vector<PointRole>& role;
  const PointResults& points;
  bool polygons = true;  ///< error ellipses as polygons, 1.2 kB each
  /// Probability of the ellipses drawn; none: the standard ellipse.
  std::optional<double> confidence = {};
  const std::vector<CheckResult>* checks = nullptr;  ///< their errors among the properties
  /// Flight paths as lines of longitude, latitude and height: id and path.
  std::vector<std::pair<std::string, const FlightPath*>> paths = {};
};

/// Writes solved points, their error ellipses and flight paths of a geocentric frame as one
/// FeatureCollection (RFC 7946; docs/export.md). Longitude and latitude are those of the frame's
/// ellipsoid, with 12 decimals (0.1 micrometre), heights are above it. Numbers that do not exist
/// are null.
void WriteGeoJson(const std::filesystem::path& file, const GeoJsonContent& content);

}  // namespace sarblock::files
