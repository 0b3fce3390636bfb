// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/io/block_arrays.h"

#include <memory>

#include "table_source.h"

namespace sarblock {

/// The tables of a block in memory, which must outlive what is returned.
[[nodiscard]] std::unique_ptr<TableSource> TablesOfArrays(const BlockArrays& arrays);

}  // namespace sarblock
