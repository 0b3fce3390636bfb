// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>

#include "parallel.h"

namespace sarblock {

// Looks, or points with their looks, are examined in few pieces, each of which may keep something a
// pass.

/// Looks or points of a piece, of `count`.
inline std::size_t SizeOfPiece(std::size_t count) {
  constexpr std::size_t kMostPieces = 16, kLeast = 32768;
  return std::max(kLeast, (count + kMostPieces - 1) / kMostPieces);
}
inline std::size_t PiecesOfLooks(std::size_t count) {
  return (count + SizeOfPiece(count) - 1) / SizeOfPiece(count);
}
/// Calls work(piece, begin, end) for the pieces of [0, count) on all threads.
template <typename Work>
void ForPiecesOfLooks(std::size_t count, const Work& work) {
  ParallelForChunks(count, SizeOfPiece(count), work);
}

}  // namespace sarblock
