// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "core/ranks.h"
#include "front_division.h"

namespace sarblock::sparse {

/// Those of the innermost scope (core/ranks.h), among which the fronts are divided; null where they
/// are not. CHECKs that they are as many as the division was made for.
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
