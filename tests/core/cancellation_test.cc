// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/progress.h"

#include <atomic>
#include <string_view>
#include <thread>

#include "core/threads.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// Asks to stop once it was asked `most` times.
class StopsAfter final : public ProgressSink {
 public:
  explicit StopsAfter(int most) : most_(most) {}
  void Update(std::string_view, std::size_t, std::size_t, std::string_view) override {}
  [[nodiscard]] bool Cancelled() const override { return ++asked_ > most_; }

 private:
  int most_;
  mutable std::atomic<int> asked_{0};
};

/// Chunks that a loop over 17,000 rows did, 10 at a time.
int ChunksDone() {
  std::atomic<int> done{0};
  ParallelForChunks(17000, 10, [&](std::size_t, std::size_t, std::size_t) { ++done; });
  return done;
}

TEST(CancellationTest, ALoopEndsInItsMiddle) {
  const StopsAfter sink(30);
  std::atomic<int> done{0};
  const CancellationScope scope(&sink);
  EXPECT_THROW(ParallelForChunks(17000, 10, [&](std::size_t, std::size_t, std::size_t) { ++done; }),
               Interrupted);
  EXPECT_GT(done, 0);
  EXPECT_LE(done, 30);
}

TEST(CancellationTest, NothingIsAskedWithoutAScope) {
  const StopsAfter sink(0);
  EXPECT_EQ(ChunksDone(), 1700);
  {
    const CancellationScope scope(&sink);
    EXPECT_EQ(CancellationScope::Current(), &sink);
    EXPECT_THROW(ChunksDone(), Interrupted);
  }
  EXPECT_EQ(CancellationScope::Current(), nullptr);
  EXPECT_EQ(ChunksDone(), 1700);
}

// TBB ends a loop inside one that has failed without a word.
TEST(CancellationTest, ALoopInsideOneThatFailedDoesNotPassForDone) {
  constexpr int kChunks = 200000, kPatience = 50000000;
  std::atomic<bool> began{false}, cut_short{false};
  const auto outer = [&](std::size_t chunk, std::size_t, std::size_t) {
    if (chunk == 0) {
      for (int i = 0; i < kPatience && !began; ++i) std::this_thread::yield();
      throw InputError("chunk", "fails");
    }
    std::atomic<int> done{0};
    ParallelForChunks(kChunks, 1, [&](std::size_t, std::size_t, std::size_t) {
      began = true;
      ++done;
    });
    if (done < kChunks) cut_short = true;
  };
  EXPECT_THROW(ParallelForChunks(2, 1, outer), InputError);
  EXPECT_FALSE(cut_short);
}

TEST(CancellationTest, TheInnermostScopeIsAsked) {
  const StopsAfter outer(0), inner(1000000);
  const CancellationScope one(&outer);
  {
    const CancellationScope two(&inner);
    EXPECT_EQ(ChunksDone(), 1700);
  }
  EXPECT_THROW(ChunksDone(), Interrupted);
}

}  // namespace
}  // namespace sarblock
