// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "export_view.h"

namespace sarblock {

/// A model state of USGSCSM's SAR model for each image given (docs/export.md).
void WriteCsmStates(const std::filesystem::path& folder,
                    const ExportView& view,
                    ExportReport* report);

}  // namespace sarblock
