// SPDX-License-Identifier: Apache-2.0
#include "front_moves.h"

#include <glog/logging.h>

namespace sarblock::sparse {

Ranks* RanksOf(const OwnFronts& own) {
  if (!own.divided()) return nullptr;
  Ranks* const ranks = RanksScope::Current();
  CHECK(ranks != nullptr && ranks->size() == own.division.ranks && ranks->rank() == own.rank)
      << "a factor that stands on several ranks is used without them";
  return ranks;
}

void FrontMoves::Add(double* place, std::size_t count, int from, int to) {
  if (count == 0) return;
  const bool here = own_.rank == from || own_.rank == to;
  parts_->push_back({.data = here ? reinterpret_cast<std::byte*>(place) : nullptr,
                     .bytes = count * sizeof(double),
                     .rank = from,
                     .to = to});
}

void FrontMoves::AddTriangle(double* from_place, double* to_place, int rows, int from, int to) {
  if (own_.rank != from) {
    Add(to_place, PackedSize(rows), from, to);
    return;
  }
  for (int c = 0; c < rows; ++c) {
    Add(from_place + At(c) * At(rows) + At(c), At(rows - c), from, to);
  }
}

}  // namespace sarblock::sparse
