// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/id_table.h"

#include <string_view>
#include <vector>

#include "tables/table.h"

namespace sarblock {

/// Writes flight paths, one a pass of the block, with the columns of trajectories.csv.
void WritePaths(TableSink* sink,
                std::string_view name,
                const Block& block,
                const std::vector<FlightPath>& paths);

/// What BlockIds takes.
[[nodiscard]] IdTable PassIds(const Block& block);

/// The paths as the block gives them.
[[nodiscard]] std::vector<FlightPath> NominalPaths(const Block& block);

}  // namespace sarblock
