// SPDX-License-Identifier: Apache-2.0
#include "front_schedule.h"

#include <atomic>
#include <mutex>
#include <queue>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

namespace sarblock::sparse {
namespace {

/// Fronts that may be worked on, the first in the wanted order on top.
class ReadyFronts {
 public:
  explicit ReadyFronts(Walk walk) : walk_(walk) {}
  void Push(std::size_t front) {
    const std::lock_guard lock(mutex_);
    queue_.push(Key(front));
  }
  [[nodiscard]] std::size_t Pop() {
    const std::lock_guard lock(mutex_);
    const std::size_t key = queue_.top();
    queue_.pop();
    return Key(key);
  }

 private:
  /// The queue keeps its largest element on top; the key is its own inverse.
  [[nodiscard]] std::size_t Key(std::size_t front) const {
    return walk_ == Walk::kUp ? ~front : front;
  }
  Walk walk_;
  std::mutex mutex_;
  std::priority_queue<std::size_t> queue_;
};

}  // namespace

void ForFronts(const std::vector<Front>& fronts,
               const std::vector<std::size_t>& some,
               Walk walk,
               const std::function<void(std::size_t)>& work) {
  constexpr std::size_t kNotHere = static_cast<std::size_t>(-1);
  std::vector<std::atomic<std::size_t>> waits_for(fronts.size());
  for (auto& waits : waits_for) waits = kNotHere;
  for (const std::size_t f : some) waits_for[f] = 0;
  for (const std::size_t f : some) {
    if (fronts[f].parent < 0) continue;
    const auto parent = static_cast<std::size_t>(fronts[f].parent);
    if (waits_for[parent] != kNotHere) ++waits_for[walk == Walk::kUp ? parent : f];
  }
  ReadyFronts ready(walk);
  std::size_t first = 0;
  for (const std::size_t f : some) {
    if (waits_for[f] > 0) continue;
    ready.Push(f);
    ++first;
  }
  tbb::task_group group;
  // One task a ready front; which front it takes is decided when it runs.
  std::function<void()> run;
  const auto done = [&](std::size_t front) {
    if (waits_for[front] != kNotHere && --waits_for[front] == 0) {
      ready.Push(front);
      group.run(run);
    }
  };
  run = [&] {
    const std::size_t f = ready.Pop();
    work(f);
    if (walk == Walk::kDown) {
      for (const int child : fronts[f].children) done(static_cast<std::size_t>(child));
    } else if (fronts[f].parent >= 0) {
      done(static_cast<std::size_t>(fronts[f].parent));
    }
  };
  for (std::size_t i = 0; i < first; ++i) group.run(run);
  group.wait();
}

void ForPieces(std::size_t count, const std::function<void(std::size_t)>& work) {
  if (count <= 1) {
    if (count == 1) work(0);
    return;
  }
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(std::size_t{0}, count, work); });
}

}  // namespace sarblock::sparse
