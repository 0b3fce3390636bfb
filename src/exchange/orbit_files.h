// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "export_view.h"

namespace sarblock {

/// One Sentinel-1 orbit file a pass (docs/export.md).
void WriteOrbitFiles(const std::filesystem::path& folder,
                     const ExportView& view,
                     ExportReport* report);

}  // namespace sarblock
