// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/id_table.h"
#include "sarblock/model/options.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "tables/table.h"

namespace sarblock::files {

/// Calls write(look, point) for the looks [begin, end) in their order.
template <typename Write>
void ForLooks(const Looks& looks, std::size_t begin, std::size_t end, const Write& write) {
  std::size_t point = looks.PointOf(begin);
  for (std::size_t look = begin; look < end; ++look) {
    while (looks.offsets[point + 1] <= look) ++point;
    write(look, point);
  }
}

/// Writes flight paths, one per pass, with the columns of trajectories.csv. `adjusted` by pass:
/// what that column says; empty: they are no adjusted ones.
void WritePaths(TableSink* sink,
                std::string_view name,
                const IdTable& pass_ids,
                const std::vector<FlightPath>& paths,
                const std::vector<std::string>& adjusted = {});
/// Whether a group corrects a pass.
[[nodiscard]] bool IsOf(const CorrectionGroup& group, const std::string& pass);

/// What the column `adjusted` says where the states hold all corrections.
inline constexpr const char* kAllAdjusted = "all";

/// What BlockIds takes.
[[nodiscard]] IdTable PassIds(const Block& block);

/// The paths as the block gives them.
[[nodiscard]] std::vector<FlightPath> NominalPaths(const Block& block);

}  // namespace sarblock::files
