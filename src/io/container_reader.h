// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "table_source.h"

namespace sarblock {

/// The tables of an HDF5 file (docs/container.md). Places in messages are those of h5py:
/// `x.h5: /observations/range_m[12]`, rows from 0. What a dataset claims is held against what is
/// stored of it before anything is allocated. Tables must not outlive the source.
[[nodiscard]] std::unique_ptr<TableSource> TablesOfContainer(const std::filesystem::path& file,
                                                             FolderContent content);

}  // namespace sarblock
