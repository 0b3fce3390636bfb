// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sarblock {

/// Ids of a million points in one character array: id of index i is text[begin[i], begin[i+1]).
/// Ids are strings only at the edge (files, messages); everything else uses the 32-bit index.
class IdTable {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  [[nodiscard]] std::size_t size() const { return begin_.size() - 1; }
  [[nodiscard]] std::string_view operator[](std::size_t index) const {
    return std::string_view(text_).substr(begin_[index], begin_[index + 1] - begin_[index]);
  }
  /// Appends without looking for a duplicate; returns the new index.
  std::uint32_t Append(std::string_view id);
  /// Index of `id`, appended if it is new. Ids that come in ascending order (by first character,
  /// length and characters: T9 before T10) are known to be new without a hash index.
  std::uint32_t FindOrAppend(std::string_view id);
  /// Index of `id` or kNone. Builds its hash index on first use; any number of threads may call it
  /// while none changes the table.
  [[nodiscard]] std::uint32_t Find(std::string_view id) const;
  /// The id closest to `id` by edit distance (letter case ignored), for "did you mean"; empty if
  /// the table is empty. In a table of more than 2000 ids those within three edits among the first
  /// 200000 come first, then the closest of the first 2000.
  [[nodiscard]] std::string Nearest(std::string_view id) const;
  /// Frees the hash index (kept memory: the characters and 4 bytes per id).
  void DropIndex();

 private:
  /// Slots of a hash index; kNone is an empty one.
  using Slots = std::vector<std::uint32_t>;
  [[nodiscard]] Slots MakeIndex() const;
  /// Above 0 where `id` is after the last one, 0 where it is that one.
  [[nodiscard]] int OrderToLast(std::string_view id) const;
  std::uint32_t AppendInOrder(std::string_view id);
  [[nodiscard]] std::size_t SlotOf(std::string_view id, const Slots& slots) const;
  std::string text_;
  std::vector<std::uint32_t> begin_{0};
  bool ascending_ = true;  // every id is after the one before it
  /// Hash index with open addressing, made once it is needed; a copy of the table begins without
  /// one.
  class Index {
   public:
    Index() = default;
    Index(const Index&) {}
    Index(Index&& other) noexcept : slots_(other.slots_.exchange(nullptr)) {}
    Index& operator=(const Index& other) {
      if (this != &other) Set(nullptr);
      return *this;
    }
    Index& operator=(Index&& other) noexcept {
      if (this != &other) Set(other.slots_.exchange(nullptr));
      return *this;
    }
    ~Index() { Set(nullptr); }
    [[nodiscard]] Slots* get() const { return slots_.load(std::memory_order_acquire); }
    void Set(Slots* slots) { delete slots_.exchange(slots); }
    /// `made` unless another thread was sooner; what there is then.
    Slots* Offer(Slots made) {
      auto own = std::make_unique<Slots>(std::move(made));
      Slots* there = nullptr;
      if (slots_.compare_exchange_strong(there, own.get())) return own.release();
      return there;
    }

   private:
    std::atomic<Slots*> slots_{nullptr};
  };
  mutable Index index_;
};

/// The name in `allowed` closest to `name` by edit distance without regard to letter case (for
/// messages); empty if none has anything in common with it.
[[nodiscard]] std::string NearestName(std::string_view name,
                                      const std::vector<std::string>& allowed);
/// "; did you mean x?" or nothing.
[[nodiscard]] std::string DidYouMean(const std::string& nearest);

}  // namespace sarblock
