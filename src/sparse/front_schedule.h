// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "symbolic.h"

namespace sarblock::sparse {

/// Which way the tree of fronts is walked.
enum class Walk {
  kUp,    ///< children before their parent
  kDown,  ///< a parent before its children
};

/// Calls work(f) once for every front of `some`, ascending, in the order `walk` demands of them, on
/// the threads ThreadLimit allows; what they need of others is there. Of the fronts that are ready
/// the next in postorder (kUp) or in its reverse (kDown) goes first, so that the matrices that wait
/// for others are those of one thread and of one more branch of the tree for each further thread.
/// `work` must give the same answer whatever runs beside it.
void ForFronts(const std::vector<Front>& fronts,
               const std::vector<std::size_t>& some,
               Walk walk,
               const std::function<void(std::size_t)>& work);

/// Calls work(0) ... work(count - 1) on idle threads, from within a front's work or outside one.
/// The caller takes up no other front while it waits for the last piece.
void ForPieces(std::size_t count, const std::function<void(std::size_t)>& work);

}  // namespace sarblock::sparse
