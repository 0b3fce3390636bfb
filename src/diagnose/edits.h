// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace sarblock {

/// Index of a pass; nothing where the block has none of this id.
[[nodiscard]] std::optional<std::uint32_t> FindPass(const Block& block, const std::string& id);

/// Passes of these ids that the block has, all of them for an empty list.
[[nodiscard]] std::vector<std::uint32_t> PassesOf(const Block& block,
                                                  const std::vector<std::string>& ids);

/// Calls `edit` for every look of these passes (empty: all).
void ForLooks(const Block& block,
              const std::vector<std::string>& passes,
              const std::function<void(std::size_t look)>& edit);

/// Changes the states of a pass as recorded and makes its path of them in the way asked for.
/// Changes that leave no valid path leave the pass as it was.
void EditStates(const std::function<void(StateVector*)>& edit, std::size_t pass, Block* block);

/// Reads these passes (empty: all) as `auto` decides. Where no path can be made so they stay as
/// they were.
void ReadAsAutoDecides(const std::vector<std::string>& passes, Block* block);

/// Where looks lie beyond the ends of their strip, the strip is the span of its looks.
void FitStrips(Block* block);

/// Block of some points with their looks, in the order given; passes as they are. `look_of`, where
/// given, becomes the look of `block` that each of its looks is.
[[nodiscard]] Block PartOf(const Block& block,
                           const std::vector<std::uint32_t>& points,
                           std::vector<std::size_t>* look_of = nullptr);

/// The same of one pass alone.
[[nodiscard]] Block PartOfPass(const Block& block,
                               std::uint32_t pass,
                               const std::vector<std::uint32_t>& points);

}  // namespace sarblock
