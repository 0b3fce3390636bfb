// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "product/radar_image.h"

namespace sarblock {

/// Reads the image support data of USGSCSM's SAR model, JSON as ALE (isd_generate) writes it, or a
/// model state (*.adjusted_state.json), 256 MiB at most. Throws InputError with file and key for
/// what is missing or makes no sense. docs/import_csm.md.
[[nodiscard]] RadarImage ReadCsmIsd(const std::string& file);
/// The same of a text in memory; `file` is for messages.
[[nodiscard]] RadarImage ParseCsmIsd(std::string_view text, const std::string& file);

}  // namespace sarblock
