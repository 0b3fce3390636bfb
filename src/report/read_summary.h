// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "result_folder.h"

namespace sarblock {

/// Reads summary.json. Keys that are not there leave their members as they are.
[[nodiscard]] ReportSummary ReadSummary(const std::filesystem::path& file);

}  // namespace sarblock
