// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

#include "core/threads.h"

namespace sarblock {

/// Rows of a table, or what is as long, that a thread makes at a time: some hundred kilobytes.
inline constexpr std::size_t kRowsPerPiece = 2048;

/// Has all threads make the pieces of [0, count), `per_piece` each, and one at a time take them, in
/// their order: while some are made, those made before are taken. ItemsAtOnce() pieces are held at
/// most. What is taken does not depend on the number of threads. The first error ends both.
template <typename Piece>
void MakeInOrder(std::size_t count,
                 std::size_t per_piece,
                 const std::function<Piece(std::size_t, std::size_t)>& make,
                 const std::function<void(Piece*)>& take) {
  struct Held {
    std::size_t begin = 0;
    Piece piece;
  };
  std::vector<Held> held(ItemsAtOnce());
  std::size_t begun = 0;
  const auto next = [&](std::size_t place) {
    if (begun >= count) return false;
    held[place].begin = begun;
    begun += std::min(per_piece, count - begun);
    return true;
  };
  const auto work = [&](std::size_t place) {
    const std::size_t begin = held[place].begin;
    held[place].piece = make(begin, begin + std::min(per_piece, count - begin));
  };
  PipeInOrder(held.size(), next, work, [&](std::size_t place) {
    take(&held[place].piece);
    held[place].piece = Piece();
  });
}

}  // namespace sarblock
