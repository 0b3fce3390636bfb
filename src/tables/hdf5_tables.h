// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/tables/output.h"

#include <filesystem>
#include <functional>
#include <memory>

#include "table.h"

namespace sarblock {

/// The tables of an HDF5 file (docs/container.md). Places in messages are those of h5py:
/// `x.h5: /observations/range_m[12]`, rows from 0. What a dataset claims is checked against what is
/// stored of it before anything is allocated. Tables must not outlive the source.
[[nodiscard]] std::unique_ptr<TableSource> TablesOfContainer(const std::filesystem::path& file,
                                                             FolderContent content);

/// Has `write` write tables to an HDF5 file, which appears under its name when all are whole.
void WriteContainer(const std::filesystem::path& target,
                    Compression compression,
                    const BlockIds& ids,
                    const std::function<void(TableSink*)>& write);

}  // namespace sarblock
