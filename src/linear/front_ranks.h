// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "core/ranks.h"
#include "symbolic.h"

namespace sarblock::sparse {

/// Which rank (core/ranks.h) works on which front, and when. All ranks work, then exchange data,
/// then work again: the work between two exchanges is a stage. A front is in the first stage in
/// which the update matrices of its children are there.
/// The factor takes the stages in order, the inverse from the last to the first.
struct FrontDivision {
  std::vector<int> owner;  ///< rank by front
  std::vector<int> stage;  ///< by front
  int stages = 1;          ///< one at least
  int ranks = 1;

  /// A front whose update matrix goes to another rank, and whose Z_RR comes from there.
  [[nodiscard]] bool Crosses(const Front& front, std::size_t f) const {
    return front.parent >= 0 && owner[f] != owner[At(front.parent)];
  }
};

/// The division depends only on the fronts and the number of ranks. Subtrees go to ranks, the
/// largest first, each to the rank with the least work so far (operations of the factor; those of
/// the inverse are twice as many); a front above them to the rank with the least work among those
/// of its children. The largest subtree is split into its children again and again. Of all these
/// divisions the one with the least time and memory is taken: operations of the slowest rank, stage
/// by stage, as a part of all operations, plus doubles of the largest rank as a part of those of a
/// process alone.
[[nodiscard]] FrontDivision DivideFronts(const std::vector<Front>& fronts, int ranks);

/// Memory of each rank with one thread: `factor`, `waiting` and `inverse_fronts` (symbolic.h),
/// as fronts.h takes and gives back.
[[nodiscard]] std::vector<FactorNeeds> NeedsOfRanks(const std::vector<Front>& fronts,
                                                    const FrontDivision& division);

/// Most doubles of one rank at any time, without S and its inverse.
[[nodiscard]] std::size_t MaxDoubles(const FactorNeeds& needs);

/// Fronts by stage, each list ascending.
using StageLists = std::vector<std::vector<std::size_t>>;

/// The part of the fronts that this rank works on.
struct OwnFronts {
  Symbolic symbolic;
  FrontDivision division;
  int rank = 0;
  StageLists stages;               ///< own fronts
  std::vector<std::size_t> panel;  ///< where the (J u R) x J panel of an own front begins
  std::size_t panel_entries = 0;   ///< doubles of all own panels

  OwnFronts() = default;
  OwnFronts(Symbolic of, FrontDivision divided, int own_rank);
  [[nodiscard]] bool Owns(std::size_t f) const { return division.owner[f] == rank; }
  [[nodiscard]] bool divided() const { return division.ranks > 1; }
};

// What crosses: the lower triangle of an r x r matrix, packed by columns where it is received.

[[nodiscard]] inline std::size_t Square(int n) { return At(n) * At(n); }
[[nodiscard]] inline std::size_t PackedSize(int n) { return At(n) * (At(n) + 1) / 2; }

/// The lower triangle of a matrix, whole or packed by columns.
struct LowerTriangle {
  const double* data;
  int rows;
  bool packed;

  /// Where row 0 of a column would be; rows from the diagonal on are there.
  [[nodiscard]] std::size_t Column(int c) const {
    return packed ? At(c) * (2 * At(rows) - At(c) - 1) / 2 : At(c) * At(rows);
  }
};

/// The ranks of the innermost scope (core/ranks.h) among which the fronts are divided; null where
/// they are not divided. CHECKs that there are as many as the division was made for.
[[nodiscard]] Ranks* RanksOf(const OwnFronts& own);

/// The parts that move what crosses between ranks after one stage, in the order of fronts.
class FrontMoves {
 public:
  FrontMoves(const OwnFronts& own, std::vector<RankPart>* parts) : own_(own), parts_(parts) {}

  /// `count` doubles from one rank to another; `place` is used on these two.
  void Add(double* place, std::size_t count, int from, int to);
  /// The lower triangle of an r x r matrix. `from_place` holds it whole on the rank that sends it,
  /// `to_place` packed on the one that gets it.
  void AddTriangle(double* from_place, double* to_place, int rows, int from, int to);

 private:
  const OwnFronts& own_;
  std::vector<RankPart>* parts_;
};

}  // namespace sarblock::sparse
