// SPDX-License-Identifier: Apache-2.0
#include "thread_ranks.h"

#include <barrier>
#include <cstddef>
#include <map>
#include <span>
#include <thread>
#include <utility>
#include <vector>

namespace sarblock::test {
namespace {

/// A rank that is a thread: what ranks exchange is in memory that all of them see.
class ThreadRank final : public Ranks {
 public:
  struct Group {
    explicit Group(int size)
        : all(size), notes(static_cast<std::size_t>(size)), sent(notes.size()) {}
    std::barrier<> all;
    std::vector<Note> notes;
    std::vector<std::map<int, std::vector<std::byte>>> sent;  // by sender and receiver
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

  // Parts of a rank may be cut otherwise on another: their bytes are one sequence for each
  // receiver.
  void Exchange(std::span<const RankPart> parts) override {
    std::map<int, std::vector<std::byte>>& own = group_->sent[static_cast<std::size_t>(rank_)];
    own.clear();
    for (const RankPart& part : parts) {
      if (part.rank != rank_) continue;
      std::vector<std::byte>& bytes = own[part.to];
      bytes.insert(bytes.end(), part.data, part.data + part.bytes);
    }
    group_->all.arrive_and_wait();
    std::map<std::pair<int, int>, std::size_t> taken;
    for (const RankPart& part : parts) {
      if (part.rank == rank_ || (part.to != RankPart::kAllRanks && part.to != rank_)) continue;
      const auto& sent = group_->sent[static_cast<std::size_t>(part.rank)].at(part.to);
      std::size_t& before = taken[{part.rank, part.to}];
      for (std::size_t i = 0; i < part.bytes; ++i) part.data[i] = sent.at(before + i);
      before += part.bytes;
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
