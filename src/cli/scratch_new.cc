// SPDX-License-Identifier: Apache-2.0
// operator new and delete of the program: large arrays made within a ScratchScope stand in mapped
// files (core/memory.h), everything else is malloc's as in the standard library. The library and
// the Python package, which live in processes of others, leave these to the process.
#include <cstdlib>
#include <new>

#include "core/memory.h"

void* operator new(std::size_t bytes) {
  if (bytes >= sarblock::kScratchLeastBytes) {
    if (void* array = sarblock::AllocateScratch(bytes)) return array;
  }
  for (;;) {
    if (void* memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

void operator delete(void* memory) noexcept {
  if (!sarblock::FreeScratch(memory)) std::free(memory);
}

void operator delete(void* memory, std::size_t bytes) noexcept {
  if (bytes >= sarblock::kScratchLeastBytes && sarblock::FreeScratch(memory)) return;
  std::free(memory);
}

// The other forms, which the standard library makes of these and AddressSanitizer does not.
void* operator new(std::size_t bytes, const std::nothrow_t& /*unused*/) noexcept {
  try {
    return operator new(bytes);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void* operator new[](std::size_t bytes) { return operator new(bytes); }

void* operator new[](std::size_t bytes, const std::nothrow_t& tag) noexcept {
  return operator new(bytes, tag);
}

void operator delete(void* memory, const std::nothrow_t& /*unused*/) noexcept {
  operator delete(memory);
}

void operator delete[](void* memory) noexcept { operator delete(memory); }

void operator delete[](void* memory, std::size_t bytes) noexcept { operator delete(memory, bytes); }

void operator delete[](void* memory, const std::nothrow_t& /*unused*/) noexcept {
  operator delete(memory);
}
