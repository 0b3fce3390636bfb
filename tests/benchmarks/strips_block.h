// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"
#include "sarblock/model/options.h"
#include "sarblock/simulate/scene.h"

#include <cstddef>
#include <string>
#include <vector>

namespace sarblock {

/// The block of strips that benchmarks are measured on, at a size.
struct StripsBlock {
  SimulatedBlock simulated;
  AdjustOptions options;  ///< of the scene's [adjust]
};

/// `passes` strips, half of them from each side, 4.8 km apart, with points over all of them.
inline StripsBlock MakeStrips(const std::string& scene_file,
                              std::size_t points,
                              std::size_t passes) {
  const std::size_t strips = passes / 2;  // of each side
  const std::string north = std::to_string(13000 + 4800 * (strips - 1) + 12000);
  const Scene scene = files::ReadScene(scene_file,
                                       {"points.count=" + std::to_string(points),
                                        "flight.0.count=" + std::to_string(strips),
                                        "flight.1.count=" + std::to_string(strips),
                                        "points.north_m=[13000, " + north + "]"});
  StripsBlock out{Simulate(scene), {}};
  std::vector<std::string> ids;
  for (const Pass& pass : out.simulated.block.passes) ids.push_back(pass.id);
  out.options = files::ReadAdjustTable(scene.adjust_toml, scene.name, ids);
  return out;
}

}  // namespace sarblock
