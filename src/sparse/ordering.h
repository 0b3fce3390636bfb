// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "block_matrix.h"

namespace sarblock::sparse {

/// Fill-reducing elimination order of the blocks: approximate minimum degree on the graph without
/// `last`, then `last` as given (duplicates ignored). Element k is the block eliminated k-th.
[[nodiscard]] std::vector<int> FillReducingOrder(const BlockPattern& pattern,
                                                 std::span<const int> last);

}  // namespace sarblock::sparse
