// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "partial_sum.h"
#include "point_pieces.h"

namespace sarblock {

/// Among ranks (core/ranks.h), what each made of its pieces of a group becomes known to all: the
/// partial sums, the weights that were renewed on the way and the rows of the border. `parts` are
/// those of the pieces from `first` on, divided among the ranks as ForChunksOfRanks divides them.
/// Returns the rank of each; without ranks nothing is done and all are of rank 0.
std::vector<int> SharePieces(const PointPieces& pieces,
                             const BlockPattern& pattern,
                             const PointEquations& equations,
                             std::size_t first,
                             std::vector<PartialSum>* parts);

}  // namespace sarblock
