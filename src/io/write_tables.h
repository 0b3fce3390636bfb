// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/io/atomic_file.h"

#include <filesystem>
#include <functional>

#include "block_ids.h"
#include "folder_content.h"
#include "table_sink.h"

namespace sarblock {

/// Has `write` write what is to be a block or a result: a folder, or one HDF5 file where the name
/// of `target` ends in ".h5". It appears as a whole or not at all; tables of an older content that
/// were not written now are removed. With Compression::kGzip a file's datasets are deflated.
void WriteTables(FolderContent content,
                 const std::filesystem::path& target,
                 Compression compression,
                 const BlockIds& ids,
                 const std::function<void(TableSink*)>& write);

}  // namespace sarblock
