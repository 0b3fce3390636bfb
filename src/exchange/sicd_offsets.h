// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "export_view.h"

namespace sarblock {

/// The XML of each SICD image given, with the result's offsets (docs/export.md).
void WriteSicdOffsets(const std::filesystem::path& folder,
                      const ExportView& view,
                      ExportReport* report);

}  // namespace sarblock
