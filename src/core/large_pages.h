// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace sarblock {

/// Asks the system to hold an array that will be filled to its end in pages of 2 MiB: a hundred
/// times fewer of them have to be given and taken back. Where it has none nothing changes. For
/// arrays whose size is known before: of a vector that grows, pages of the copies would be in vain.
void PreferLargePages(void* array, std::size_t bytes);

/// Room for `count` values, in large pages.
template <typename T>
void ReserveInLargePages(std::size_t count, std::vector<T>* values) {
  if (count <= values->capacity()) return;
  values->reserve(count);
  PreferLargePages(values->data(), values->capacity() * sizeof(T));
}

}  // namespace sarblock
