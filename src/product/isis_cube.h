// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "product/radar_image.h"

namespace sarblock {

/// Reads a cube of ISIS with Mini-RF geometry (LRO, Chandrayaan-1), level 1, after spiceinit: its
/// label and the tables InstrumentPosition and BodyRotation. Pixels are not read, so a cube costs
/// the memory of its label and tables. A crop or reduction is undone by the label's AlphaCube:
/// lines and samples are those of the cube itself. Throws InputError with file, line and key, or
/// the table, for what is missing or makes no sense. docs/import_isis.md.
[[nodiscard]] RadarImage ReadIsisCube(const std::string& file);
/// The same of bytes in memory; `file` is for messages.
[[nodiscard]] RadarImage ParseIsisCube(std::string_view bytes, const std::string& file);

}  // namespace sarblock
