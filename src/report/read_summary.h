// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/report/result_folder.h"

#include <filesystem>

namespace sarblock {

/// Reads summary.json. Keys that are not there leave their members as they are.
[[nodiscard]] ReportSummary ReadSummary(const std::filesystem::path& file);

}  // namespace sarblock
