// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <span>
#include <type_traits>
#include <vector>

#include "ranks.h"

namespace sarblock {

/// Pieces [first, last) of `count`, which rank `rank` of `ranks` has: consecutive, as many as those
/// of any other, or one less.
struct PiecesOfRank {
  std::size_t first = 0, last = 0;
};
[[nodiscard]] PiecesOfRank PiecesOf(std::size_t count, int rank, int ranks);

/// An array to which the chunks of a divided loop write, each its own elements: the bytes of an
/// element are its value. One that is empty is not used.
class SharedArray {
 public:
  /// One element an item of the loop.
  template <typename Values>
  static SharedArray ByItem(Values* values) {
    return Of(values, Kind::kItem, nullptr);
  }
  /// One element a chunk.
  template <typename Values>
  static SharedArray ByChunk(Values* values) {
    return Of(values, Kind::kChunk, nullptr);
  }
  /// The elements offsets[i] to offsets[i + 1] belong to item i.
  template <typename Values>
  static SharedArray ByRange(const std::vector<std::uint64_t>& offsets, Values* values) {
    return Of(values, Kind::kRange, offsets.data());
  }

  /// The bytes of the items [begin, end), which are the chunks [first, last).
  [[nodiscard]] std::span<std::byte> Bytes(std::size_t begin,
                                           std::size_t end,
                                           const PiecesOfRank& chunks) const;

 private:
  enum class Kind { kItem, kChunk, kRange };
  template <typename Values>
  static SharedArray Of(Values* values, Kind kind, const std::uint64_t* offsets) {
    using Element = std::remove_reference_t<decltype(*values->data())>;
    static_assert(std::is_standard_layout_v<Element> && std::is_trivially_destructible_v<Element>);
    SharedArray out;
    out.bytes_ = std::as_writable_bytes(std::span(values->data(), values->size()));
    out.element_bytes_ = sizeof(Element);
    out.kind_ = kind;
    out.offsets_ = offsets;
    return out;
  }
  std::span<std::byte> bytes_;
  std::size_t element_bytes_ = 1;
  Kind kind_ = Kind::kItem;
  const std::uint64_t* offsets_ = nullptr;
};

/// ParallelForChunks (parallel.h) of which each rank does consecutive chunks. Work may write to
/// `arrays` alone; every rank holds all that was written afterwards. Without ranks nothing differs
/// from ParallelForChunks.
void ForChunksOfRanks(std::size_t count,
                      std::size_t chunk_size,
                      std::initializer_list<SharedArray> arrays,
                      const std::function<void(std::size_t, std::size_t, std::size_t)>& work);

/// Threads of all ranks together (ThreadsAllowed), the same number on all of them. Throws
/// OtherRankFailed.
[[nodiscard]] int ThreadsOfRanks();

}  // namespace sarblock
