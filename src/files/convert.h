// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/tables/output.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace sarblock::files {

/// What was converted.
struct ConversionReport {
  std::string kind;                     ///< "block" or "result"
  std::size_t tables = 0, rows = 0;     ///< written
  std::vector<std::string> left_out{};  ///< files of the folder that are no tables of its kind
};

/// Writes the tables of a block or a result, a folder or an HDF5 file (docs/container.md), as the
/// other kind: HDF5 where the name of `to` ends in ".h5". Tables that sarblock wrote are restored
/// byte by byte when converted back; other tables keep their values, columns in the order of
/// docs/formats.md, followed by unknown columns, taken as text. Numbers, counts and flags are
/// checked one by one as by ReadBlock(), but not against each other. Throws InputError with the
/// place of what is wrong.
ConversionReport Convert(const std::filesystem::path& from,
                         const std::filesystem::path& to,
                         Compression compression = Compression::kNone,
                         ProgressSink* progress = nullptr);

}  // namespace sarblock::files
