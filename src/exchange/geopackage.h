// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "export_view.h"

namespace sarblock {

/// GeoPackage, one SQLite file (docs/export.md).
void WriteGeoPackage(const std::filesystem::path& file,
                     const ExportView& view,
                     ExportReport* report);

}  // namespace sarblock
