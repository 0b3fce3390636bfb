// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "core/parallel.h"

namespace sarblock {

/// Rows of a table, or what is as long, that a thread makes at a time: some hundred kilobytes.
inline constexpr std::size_t kRowsPerPiece = 2048;

/// Has all threads make the pieces of [0, count), `per_piece` each, and one at a time take them, in
/// their order: while some are made, those made before are taken. At most four pieces a thread are
/// held at once. What is taken does not depend on the number of threads. The first error ends both.
template <typename Piece>
void MakeInOrder(std::size_t count,
                 std::size_t per_piece,
                 const std::function<Piece(std::size_t, std::size_t)>& make,
                 const std::function<void(Piece*)>& take) {
  const std::size_t pieces = (count + per_piece - 1) / per_piece;
  const std::size_t at_once = 2 * static_cast<std::size_t>(ThreadsAllowed());
  std::vector<Piece> made, making;
  for (std::size_t first = 0; first < pieces || !made.empty(); first += at_once) {
    making.resize(std::min(at_once, pieces - std::min(pieces, first)));
    ParallelForChunks(1 + making.size(), 1, [&](std::size_t k, std::size_t, std::size_t) {
      if (k == 0) {
        for (Piece& piece : made) take(&piece);
        return;
      }
      const std::size_t begin = (first + k - 1) * per_piece;
      making[k - 1] = make(begin, std::min(count, begin + per_piece));
    });
    made = std::exchange(making, {});
  }
}

}  // namespace sarblock
