// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/progress.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <vector>

#include "core/threads.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr std::size_t kItems = 1703;

/// Squares of the numbers below kItems through a pipe of `at_once` places.
struct Squares {
  explicit Squares(std::size_t at_once) : number(at_once), square(at_once) {}
  void Run(const std::function<bool(std::size_t)>& next_of) {
    PipeInOrder(
        number.size(),
        [&](std::size_t place) {
          fixed = std::max(fixed, ++in_pipe);
          number[place] = made;
          return next_of(made++);
        },
        [&](std::size_t place) {
          if (number[place] == fails_in_work) throw InputError("work", "fails");
          square[place] = number[place] * number[place];
        },
        [&](std::size_t place) {
          --in_pipe;
          taken.push_back(square[place]);
        });
  }
  std::size_t made = 0, fails_in_work = kItems;
  std::atomic<std::size_t> in_pipe{0};
  std::size_t fixed = 0;  // of one thread at a time
  std::vector<std::size_t> number, square, taken;
};

// Closed form, whatever the threads and places.
TEST(PipeTest, TakesAllItemsInTheirOrder) {
  for (const int threads : {1, 2, 5}) {
    const ThreadLimit limit(threads);
    for (const std::size_t at_once : {std::size_t{1}, std::size_t{3}, std::size_t{8}}) {
      Squares squares(at_once);
      squares.Run([](std::size_t item) { return item < kItems; });
      ASSERT_EQ(squares.taken.size(), kItems);
      for (std::size_t i = 0; i < kItems; ++i) ASSERT_EQ(squares.taken[i], i * i);
      EXPECT_LE(squares.fixed, at_once);
    }
  }
}

TEST(PipeTest, AnErrorComesBehindTheItemsBeforeIt) {
  for (const int threads : {1, 2, 5}) {
    const ThreadLimit limit(threads);
    Squares work(4);
    work.fails_in_work = 701;
    EXPECT_THROW(work.Run([](std::size_t item) { return item < kItems; }), InputError);
    EXPECT_EQ(work.taken.size(), 701U);
    Squares next(4);
    const auto fails = [](std::size_t item) -> bool {
      if (item == 17) throw InputError("next", "fails");
      return item < kItems;
    };
    EXPECT_THROW(next.Run(fails), InputError);
    EXPECT_EQ(next.taken.size(), 17U);
  }
}

class AlwaysCancelled final : public ProgressSink {
 public:
  void Update(std::string_view, std::size_t, std::size_t, std::string_view) override {}
  [[nodiscard]] bool Cancelled() const override { return true; }
};

TEST(PipeTest, EndsWhereTheUserAsksForIt) {
  const AlwaysCancelled sink;
  const CancellationScope scope(&sink);
  Squares squares(3);
  EXPECT_THROW(squares.Run([](std::size_t item) { return item < kItems; }), Interrupted);
  EXPECT_TRUE(squares.taken.empty());
}

TEST(PipeTest, HasAPlaceMoreThanThreads) {
  const ThreadLimit limit(1);
  EXPECT_EQ(ItemsAtOnce(), 2U);
}

}  // namespace
}  // namespace sarblock
