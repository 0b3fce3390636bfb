// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "export_view.h"

namespace sarblock {

/// The table of points and their site codes beside a SINEX file.
[[nodiscard]] std::filesystem::path SitesOf(std::filesystem::path sinex);

/// SINEX 2.02 (docs/export.md).
void WriteSinex(const std::filesystem::path& file, const ExportView& view, ExportReport* report);

}  // namespace sarblock
