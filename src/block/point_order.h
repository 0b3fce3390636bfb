// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstdint>
#include <vector>

namespace sarblock {

/// An order of the points of a block: the point that stands at each place.
using PointOrder = std::vector<std::uint32_t>;

/// The points by the first and then the last pass that sees them, those of the same passes as they
/// stand, those without looks at the end. Neighbours then share their passes: what a loop over
/// points asks of a pass is still in the cache, and a piece of them touches little of S. Linear
/// time.
[[nodiscard]] PointOrder SortedByPasses(const Block& block);

/// The same, or empty where the points do not stand much better so: neighbours share their passes
/// already, or the passes are few.
[[nodiscard]] PointOrder OrderByPasses(const Block& block);

/// The order that leads back.
[[nodiscard]] PointOrder InverseOf(const PointOrder& order);

/// Offsets of looks (Looks::offsets) with the points in this order.
[[nodiscard]] std::vector<std::uint64_t> ReorderedOffsets(
    const PointOrder& order, const std::vector<std::uint64_t>& offsets);

/// Point i becomes what point order[i] was, with its looks. One column at a time: memory for one
/// more.
void ReorderPoints(const PointOrder& order, Block* block);

}  // namespace sarblock
