// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "large_pages.h"
#include "parallel.h"

namespace sarblock {

inline constexpr std::size_t kGatheredAtOnce = 65536;

/// Element i becomes what element old_of_new[i] was, a permutation. An empty column stays empty.
template <typename T>
void Gather(const std::vector<std::uint32_t>& old_of_new, std::vector<T>* column) {
  if (column->empty()) return;
  std::vector<T> gathered;
  ReserveInLargePages(old_of_new.size(), &gathered);
  gathered.resize(old_of_new.size());
  const auto gather = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) gathered[i] = std::move((*column)[old_of_new[i]]);
  };
  ParallelForChunks(gathered.size(), kGatheredAtOnce, gather);
  column->swap(gathered);
}

/// The same for a column whose elements offsets[i] to offsets[i + 1] belong to item i, from the
/// offsets of the old items to those of the new.
template <typename T>
void GatherRanges(const std::vector<std::uint32_t>& old_of_new,
                  const std::vector<std::uint64_t>& old_offsets,
                  const std::vector<std::uint64_t>& new_offsets,
                  std::vector<T>* column) {
  if (column->empty()) return;
  std::vector<T> gathered;
  ReserveInLargePages(column->size(), &gathered);
  gathered.resize(column->size());
  const auto gather = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::uint64_t old = old_offsets[old_of_new[i]];
      for (std::uint64_t k = new_offsets[i]; k < new_offsets[i + 1]; ++k, ++old) {
        gathered[k] = (*column)[old];
      }
    }
  };
  ParallelForChunks(old_of_new.size(), kGatheredAtOnce, gather);
  column->swap(gathered);
}

}  // namespace sarblock
