// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "block_matrix.h"

namespace sarblock::sparse {

/// Fill-reducing elimination order of the blocks: approximate minimum degree (Amestoy, Davis, Duff
/// 1996) on the graph without `last`, then `last` as given (duplicates ignored). Element k is the
/// block eliminated k-th.
[[nodiscard]] std::vector<int> MinimumDegreeOrder(const BlockPattern& pattern,
                                                  std::span<const int> last);

/// The same by nested dissection (Karypis and Kumar 1998, METIS), each block as heavy as its rows.
/// The same pattern gives the same order with the same version of METIS and of the C library, whose
/// random numbers it takes: started from a fixed seed, while this is called one thread at a time.
/// Nothing where METIS refuses: it has no memory.
[[nodiscard]] std::optional<std::vector<int>> DissectionOrder(const BlockPattern& pattern,
                                                              std::span<const int> last);

}  // namespace sarblock::sparse
