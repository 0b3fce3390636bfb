// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "ranks.h"

namespace sarblock {

/// Calls work(chunk, begin, end) for the pieces of [0, count) of `chunk_size` each, on
/// ThreadsAllowed() threads. Pieces do not depend on the number of threads, so results summed by
/// piece and then in order of pieces do not either. The first exception is rethrown here.
void ParallelForChunks(std::size_t count,
                       std::size_t chunk_size,
                       const std::function<void(std::size_t, std::size_t, std::size_t)>& work);

/// While one of these lives, ParallelForChunks() asks `sink` before every chunk whether to stop, in
/// loops that this thread begins, and throws Interrupted then: a user at a terminal need not wait
/// for the end of a loop over a million points. Null: the sink of the scope outside, if any.
class CancellationScope {
 public:
  explicit CancellationScope(const ProgressSink* sink);
  ~CancellationScope();
  CancellationScope(const CancellationScope&) = delete;
  CancellationScope& operator=(const CancellationScope&) = delete;

  /// The sink of the innermost scope of this thread; null without one.
  [[nodiscard]] static const ProgressSink* Current();

 private:
  const ProgressSink* outer_;
};

/// Runs the work of a public function: loops of this thread take at most `threads` threads
/// meanwhile (0, or more than it has: as many as it has) and ask `sink`, unless it is null, whether
/// to stop. Nothing else in the process is limited: it is a task arena of TBB. Returns what `work`
/// returns, throws what it throws.
void RunInLibrary(int threads, const ProgressSink* sink, const std::function<void()>& work);
template <typename Work>
[[nodiscard]] auto CallInLibrary(int threads, const ProgressSink* sink, const Work& work) {
  std::optional<decltype(work())> result;
  RunInLibrary(threads, sink, [&] { result.emplace(work()); });
  return std::move(*result);
}

/// Limits the threads of the whole process while it lives, for programs, whose process is theirs; 0
/// means all cores. More threads than cores are possible.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Cores this process may use, at least 1.
[[nodiscard]] int AvailableCores();

/// Threads that ParallelForChunks may take now, at least 1. For the size of buffers, never for what
/// is computed.
[[nodiscard]] int ThreadsAllowed();

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
    return Make(values, Kind::kItem, nullptr);
  }
  /// One element a chunk.
  template <typename Values>
  static SharedArray ByChunk(Values* values) {
    return Make(values, Kind::kChunk, nullptr);
  }
  /// The elements offsets[i] to offsets[i + 1] belong to item i.
  template <typename Values>
  static SharedArray ByRange(const std::vector<std::uint64_t>& offsets, Values* values) {
    return Make(values, Kind::kRange, offsets.data());
  }

  /// The bytes of the items [begin, end), which are the chunks [first, last).
  [[nodiscard]] std::span<std::byte> Bytes(std::size_t begin,
                                           std::size_t end,
                                           const PiecesOfRank& chunks) const;

 private:
  enum class Kind { kItem, kChunk, kRange };
  template <typename Values>
  static SharedArray Make(Values* values, Kind kind, const std::uint64_t* offsets) {
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

/// ParallelForChunks (threads.h) of which each rank does consecutive chunks. Work may write to
/// `arrays` alone; every rank holds all that was written afterwards. Without ranks nothing differs
/// from ParallelForChunks.
void ForChunksOfRanks(std::size_t count,
                      std::size_t chunk_size,
                      std::initializer_list<SharedArray> arrays,
                      const std::function<void(std::size_t, std::size_t, std::size_t)>& work);

/// Threads of all ranks together (ThreadsAllowed), the same number on all of them. Throws
/// OtherRankFailed.
[[nodiscard]] int ThreadsOfRanks();

/// A pipeline of three stages over a sequence of items, at most `at_once` of them in memory, in
/// places 0 to at_once - 1: `next(place)` makes an item, or returns false after the last one,
/// `work(place)` processes it, `take(place)` ends it. `next` and `take` run one call at a time, in
/// the order of the items, while other items are in `work` on ThreadsAllowed() threads. An
/// exception of `next` or `work` is rethrown here in place of `take`, when the items before it are
/// taken: an error does not depend on the number of threads. Throws Interrupted if the sink of
/// CancellationScope asks for it.
void PipeInOrder(std::size_t at_once,
                 const std::function<bool(std::size_t)>& next,
                 const std::function<void(std::size_t)>& work,
                 const std::function<void(std::size_t)>& take);

/// Items in memory at once: every thread has one while others are made and taken.
[[nodiscard]] std::size_t ItemsAtOnce();

/// Scratch that the pieces of a parallel loop borrow in turn: as many objects as pieces run at
/// once. An object comes back as the piece before left it.
template <typename T>
class Pool {
 public:
  class Borrowed {
   public:
    explicit Borrowed(Pool* pool) : pool_(pool), object_(pool->Take()) {}
    ~Borrowed() { pool_->Give(std::move(object_)); }
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;
    [[nodiscard]] T& operator*() const { return *object_; }
    [[nodiscard]] T* operator->() const { return object_.get(); }

   private:
    Pool* pool_;
    std::unique_ptr<T> object_;
  };
  [[nodiscard]] Borrowed Borrow() { return Borrowed(this); }

 private:
  std::unique_ptr<T> Take() {
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        std::unique_ptr<T> object = std::move(free_.back());
        free_.pop_back();
        return object;
      }
    }
    return std::make_unique<T>();
  }
  void Give(std::unique_ptr<T> object) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(object));
  }
  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> free_;
};

/// Runs work so that this thread, while a loop inside (threads.h) waits for its last pieces, takes
/// up no piece of a loop outside: large pieces that contain loops of their own begin one after the
/// other, not one inside the other.
void RunIsolated(const std::function<void()>& work);

/// Adds a StageCost to a list when it goes out of scope.
class StageTimer {
 public:
  StageTimer(std::string stage, std::vector<StageCost>* costs);
  ~StageTimer();
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  std::string stage_;
  std::vector<StageCost>* costs_;
  std::chrono::steady_clock::time_point begin_;
};

// Looks, or points with their looks, are examined in few pieces, each of which may keep something a
// pass.

/// Looks or points of a piece, of `count`.
inline std::size_t SizeOfPiece(std::size_t count) {
  constexpr std::size_t kMaxPieces = 16, kMin = 32768;
  return std::max(kMin, (count + kMaxPieces - 1) / kMaxPieces);
}
inline std::size_t PiecesOfLooks(std::size_t count) {
  return (count + SizeOfPiece(count) - 1) / SizeOfPiece(count);
}
/// Calls work(piece, begin, end) for the pieces of [0, count) on all threads.
template <typename Work>
void ForPiecesOfLooks(std::size_t count, const Work& work) {
  ParallelForChunks(count, SizeOfPiece(count), work);
}

}  // namespace sarblock
