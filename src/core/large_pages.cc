// SPDX-License-Identifier: Apache-2.0
#include "large_pages.h"

#include <cstdint>

#include <sys/mman.h>

namespace sarblock {

void PreferLargePages(void* array, std::size_t bytes) {
  constexpr std::uintptr_t kLargePage = std::uintptr_t{2} << 20;
  const auto begin = reinterpret_cast<std::uintptr_t>(array);
  // Whole ones that belong to nobody else.
  const std::uintptr_t first = (begin + kLargePage - 1) / kLargePage * kLargePage;
  const std::uintptr_t last = (begin + bytes) / kLargePage * kLargePage;
  if (first < last) ::madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
}

}  // namespace sarblock
