// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstddef>

namespace sarblock {

/// Calls write(look, point) for the looks [begin, end) in their order.
template <typename Write>
void ForLooks(const Looks& looks, std::size_t begin, std::size_t end, const Write& write) {
  std::size_t point = looks.PointOf(begin);
  for (std::size_t look = begin; look < end; ++look) {
    while (looks.offsets[point + 1] <= look) ++point;
    write(look, point);
  }
}

}  // namespace sarblock
