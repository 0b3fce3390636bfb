// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstdint>
#include <vector>

namespace sarblock {

/// An order of the points of a block: the point at each place.
using PointOrder = std::vector<std::uint32_t>;

/// The points by the first and then the last pass that sees them, those of the same passes in their
/// present order, those without looks at the end. Neighbours then share their passes: data of a
/// pass that a loop over points reads is still in the cache, and a piece of points touches little
/// of S. Linear time.
[[nodiscard]] PointOrder SortedByPasses(const Block& block);

/// The same, or empty if that order is not much better: neighbours share their passes already, or
/// the passes are few.
[[nodiscard]] PointOrder OrderByPasses(const Block& block);

/// The inverse order.
[[nodiscard]] PointOrder InverseOf(const PointOrder& order);

/// Offsets of looks (Looks::offsets) with the points in this order.
[[nodiscard]] std::vector<std::uint64_t> ReorderedOffsets(
    const PointOrder& order, const std::vector<std::uint64_t>& offsets);

/// Point i becomes what point order[i] was, with its looks. One column at a time: memory for one
/// more.
void ReorderPoints(const PointOrder& order, Block* block);

}  // namespace sarblock
