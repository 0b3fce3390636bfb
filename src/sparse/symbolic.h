// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "block_matrix.h"

namespace sarblock::sparse {

/// An index that is not negative, for a container.
[[nodiscard]] inline std::size_t At(int index) { return static_cast<std::size_t>(index); }

/// Rows of a front that are also consecutive rows of its parent's front.
struct Run {
  int begin;         ///< first row, counted from the first remaining row of the child's front
  int parent_begin;  ///< first row, counted from the first row of the parent's front
  int length;
};

/// Where a block of S sits in the front that eliminates the earlier of its two parameter blocks.
struct Entry {
  std::size_t value;  ///< first of its values in the matrix
  int row, column;    ///< place of its first element in the front's lower triangle
  int height, width;  ///< of the block in the front
  bool transposed;    ///< the matrix stores the transpose of what the front needs
};

/// A supernode: block columns eliminated together, and the block rows their columns reach.
struct Front {
  int first_row = 0;      ///< first eliminated row in elimination order
  int eliminated = 0;     ///< rows eliminated here (J)
  int remaining = 0;      ///< rows below them (R)
  int parent = -1;        ///< front that eliminates the first row of R
  std::size_t panel = 0;  ///< where its (J u R) x J panel begins in the factor
  std::vector<int> rows;  ///< R as block positions in elimination order, ascending
  std::vector<Run> runs;  ///< R within the parent's front
  std::vector<Entry> entries;
  std::vector<int> children;

  [[nodiscard]] int height() const { return eliminated + remaining; }
};

/// Elimination order of a pattern and its fronts, children before parents.
struct Symbolic {
  std::vector<int> order;         ///< block eliminated k-th
  std::vector<int> row_begin;     ///< first row of the k-th block in elimination order, and the end
  std::vector<int> original_row;  ///< row of S by row in elimination order
  std::vector<Front> fronts;
  std::size_t factor_entries = 0;
};

/// Orders by approximate minimum degree (Amestoy, Davis, Duff 1996) on the graph of blocks, with
/// `last` appended, and forms supernodes: columns of equal structure, then children merged into
/// their parents while the explicit zeros stay few (the thresholds of CHOLMOD, ACM TOMS 887).
[[nodiscard]] Symbolic Analyse(const BlockPattern& pattern, std::span<const int> last);

}  // namespace sarblock::sparse
