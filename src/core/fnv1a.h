// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace sarblock {

inline constexpr std::uint64_t kFnv1aStart = 0xcbf29ce484222325u;

/// FNV-1a, 64 bits (Fowler, Noll and Vo): tells damaged or other data, not forged ones. `state` is
/// the value of what stands before.
[[nodiscard]] inline std::uint64_t Fnv1a(std::span<const std::byte> bytes,
                                         std::uint64_t state = kFnv1aStart) {
  for (const std::byte byte : bytes) {
    state ^= static_cast<std::uint64_t>(byte);
    state *= 0x100000001b3u;
  }
  return state;
}
[[nodiscard]] inline std::uint64_t Fnv1a(std::string_view text, std::uint64_t state = kFnv1aStart) {
  return Fnv1a(std::as_bytes(std::span(text)), state);
}

}  // namespace sarblock
