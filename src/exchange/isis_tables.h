// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "export_view.h"

namespace sarblock {

/// Tables of ISIS jigsaw (docs/export.md).
void WriteIsisTables(const std::filesystem::path& folder,
                     const ExportView& view,
                     ExportReport* report);

}  // namespace sarblock
