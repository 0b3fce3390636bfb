// SPDX-License-Identifier: Apache-2.0
#include "thread_ranks.h"

#include <barrier>
#include <cstddef>
#include <span>
#include <thread>
#include <vector>

namespace sarblock::test {
namespace {

/// A rank that is a thread: what ranks tell each other stands in memory that all of them see.
class ThreadRank final : public Ranks {
 public:
  struct Group {
    explicit Group(int size)
        : all(size), notes(static_cast<std::size_t>(size)), sent(notes.size()) {}
    std::barrier<> all;
    std::vector<Note> notes;
    std::vector<std::vector<std::byte>> sent;
  };

  ThreadRank(int rank, Group* group) : rank_(rank), group_(group) {}
  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int size() const override { return static_cast<int>(group_->notes.size()); }

 protected:
  [[nodiscard]] std::vector<Note> Meet(const Note& own, const Ending*) override {
    group_->notes[static_cast<std::size_t>(rank_)] = own;
    group_->all.arrive_and_wait();
    std::vector<Note> notes = group_->notes;
    group_->all.arrive_and_wait();
    return notes;
  }

  // Parts of a rank may be cut otherwise on another: their bytes are one sequence.
  void Exchange(std::span<const RankPart> parts) override {
    std::vector<std::byte>& own = group_->sent[static_cast<std::size_t>(rank_)];
    own.clear();
    for (const RankPart& part : parts) {
      if (part.rank == rank_) own.insert(own.end(), part.data, part.data + part.bytes);
    }
    group_->all.arrive_and_wait();
    std::vector<std::size_t> taken(group_->sent.size(), 0);
    for (const RankPart& part : parts) {
      if (part.rank == rank_) continue;
      const auto from = static_cast<std::size_t>(part.rank);
      for (std::size_t i = 0; i < part.bytes; ++i) {
        part.data[i] = group_->sent[from].at(taken[from] + i);
      }
      taken[from] += part.bytes;
    }
    group_->all.arrive_and_wait();
  }

 private:
  int rank_;
  Group* group_;
};

}  // namespace

void RunRanks(int ranks, const std::function<void(Ranks*)>& work) {
  ThreadRank::Group group(ranks);
  std::vector<std::thread> threads;
  for (int r = 0; r < ranks; ++r) {
    threads.emplace_back([&, r] {
      ThreadRank rank(r, &group);
      const RanksScope scope(&rank);
      work(&rank);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace sarblock::test
