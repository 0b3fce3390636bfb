// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "export_view.h"

namespace sarblock {

/// KML (docs/export.md).
void WriteKml(const std::filesystem::path& file, const ExportView& view, ExportReport* report);

}  // namespace sarblock
