// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "product/utc_time.h"
#include <Eigen/Core>

namespace sarblock {

/// One survey of a corner reflector.
struct ReflectorSurvey {
  std::string id;
  Geodetic place;                                          ///< WGS84, at the time of the survey
  std::optional<UtcTime> surveyed;                         ///< nothing: for all times
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< east, north, up
  bool usable = true;  ///< its validity says that geometry may be calibrated with it
  std::size_t file_line = 0;
};

/// Corner reflectors with the history of their surveys.
struct Reflectors {
  std::string file;
  std::vector<ReflectorSurvey> surveys;
};

/// Reads a table of corner reflectors as those of NISAR (JPL D-107698) and UAVSAR are published:
/// CSV with the columns `Corner reflector ID`, `Latitude (deg)`, `Longitude (deg)`, `Height above
/// ellipsoid (m)`, and optionally `Survey Date`, `Validity`, `Velocity East (m/s)` and so on. Of
/// `Validity` bit 4 (geometry) is read. Throws InputError with file, line and column.
[[nodiscard]] Reflectors ReadReflectors(const std::string& file);
/// The same of a text in memory; `file` is for messages.
[[nodiscard]] Reflectors ParseReflectors(std::string_view text, const std::string& file);

/// Where a reflector is at a time, in the axes of a geocentric frame.
struct ReflectorPosition {
  std::string id;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  std::size_t file_line = 0;  ///< of the survey
};

/// The reflectors that stood at a time: of each the latest survey before it, moved on by its
/// velocity. Those surveyed only later and those whose latest survey is not usable are left out.
[[nodiscard]] std::vector<ReflectorPosition> ReflectorsAt(const Reflectors& reflectors,
                                                          const UtcTime& time,
                                                          const Frame& frame);

}  // namespace sarblock
