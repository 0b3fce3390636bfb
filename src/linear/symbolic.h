// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
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
  /// Operations of the factorisation: sum of h^2 over the columns of L, h their entries before
  /// supernodes are merged.
  double operations = 0.0;
  bool dissected = false;  ///< the order is one of nested dissection
};

/// From so many operations on (hundredths of a second of a processor) two orders are compared.
inline constexpr double kManyOperations = 1e9;

/// Orders by approximate minimum degree on the graph of blocks, with `last` appended, or, where
/// that leaves `many_operations` or more and nested dissection fewer than that, by nested
/// dissection (symbolic.h). Forms supernodes: columns of equal structure, then children merged into
/// their parents while the explicit zeros stay few (the thresholds of CHOLMOD, ACM TOMS 887).
[[nodiscard]] Symbolic Analyse(const BlockPattern& pattern,
                               std::span<const int> last,
                               double many_operations = kManyOperations);

}  // namespace sarblock::sparse

namespace sarblock {

/// Memory and work of a block Cholesky factor and its selected inverse, in doubles and operations
/// (a product and its sum). Known from the pattern alone, for fronts that one thread works on;
/// further threads keep more fronts waiting, each at most a branch of the elimination tree.
struct FactorNeeds {
  std::size_t factor = 0;          ///< L
  std::size_t waiting = 0;         ///< update matrices while it is formed, the most at once
  std::size_t inverse_fronts = 0;  ///< fronts of the inverse, the most at once
  double operations = 0.0;         ///< of the factor, half of sum h^2 over its columns
  bool dissected = false;          ///< the order is METIS's, else AMD's
};

}  // namespace sarblock
