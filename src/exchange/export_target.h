// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/tables/output.h"

#include <filesystem>

#include "exchange/export.h"

namespace sarblock {

/// Throws InputError where ExportResult() must not write: `out` is a folder in place of a file or
/// the reverse, or (kRefuse) files stand there that it did not write in this format.
void RequireTargetFor(ExportFormat format, const std::filesystem::path& out, ForeignFiles foreign);

}  // namespace sarblock
