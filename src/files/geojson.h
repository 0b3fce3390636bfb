// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sarblock::files {

/// Name of a role in tables: "tie", "control", "check".
[[nodiscard]] const char* NameOf(PointRole role);

/// The errors of a check point, of results sorted by point; null where it is none.
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
