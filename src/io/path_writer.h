// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/io/atomic_file.h"

#include <filesystem>
#include <vector>

namespace sarblock {

/// Writes flight paths, one a pass of the block, with the columns of trajectories.csv.
void WritePaths(const std::filesystem::path& file,
                const Block& block,
                const std::vector<FlightPath>& paths,
                Compression compression);

/// The paths as the block gives them.
[[nodiscard]] std::vector<FlightPath> NominalPaths(const Block& block);

}  // namespace sarblock
