// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

namespace sarblock {

/// Three things are done with each of a row of items, at most `at_once` of which are held, in
/// places 0 to at_once - 1: `next(place)` makes an item, or returns false behind the last one,
/// `work(place)` goes on with it, `take(place)` ends it. Of each of `next` and `take` one call runs
/// at a time, in the order of the items, while others are worked on by the threads that ThreadLimit
/// allows. What `next` or `work` throws is rethrown here in place of `take`, when the items before
/// it are taken: an error does not depend on the number of threads. Throws Interrupted where the
/// sink of CancellationScope asks for it.
void PipeInOrder(std::size_t at_once,
                 const std::function<bool(std::size_t)>& next,
                 const std::function<void(std::size_t)>& work,
                 const std::function<void(std::size_t)>& take);

/// Items to hold at once: every thread has one while others are made and taken.
[[nodiscard]] std::size_t ItemsAtOnce();

}  // namespace sarblock
