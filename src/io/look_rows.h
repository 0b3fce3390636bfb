// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <algorithm>
#include <cstddef>

namespace sarblock {

/// Calls write(look, point) for the looks [begin, end) in their order.
template <typename Write>
void ForLooks(const Looks& looks, std::size_t begin, std::size_t end, const Write& write) {
  const auto after = std::upper_bound(looks.offsets.begin(), looks.offsets.end(), begin);
  auto point = static_cast<std::size_t>(after - looks.offsets.begin()) - 1;
  for (std::size_t look = begin; look < end; ++look) {
    while (looks.offsets[point + 1] <= look) ++point;
    write(look, point);
  }
}

}  // namespace sarblock
