// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "inertial_orbit.h"
#include "product/radar_image.h"
#include "tables/json.h"

namespace sarblock {

/// Name of the one model of USGSCSM that is read.
inline constexpr const char* kCsmModelName = "USGS_ASTRO_SAR_SENSOR_MODEL";

/// The parts of an ISD, for who reads more of it than its image: throw InputError as ReadCsmIsd().
[[nodiscard]] InertialOrbit IsdOrbit(const JsonValue& root, const std::string& file);
[[nodiscard]] RadarImage IsdImage(const JsonValue& root, const std::string& file);
/// Refuses another name of a model.
void RequireCsmModel(const JsonValue& name);

}  // namespace sarblock
