// SPDX-License-Identifier: Apache-2.0
// Ranks that are threads (support/thread_ranks.h): what is divided is counted, what is shared is
// compared with what one process makes.
#include "core/ranks.h"

#include "sarblock/core/error.h"

#include <atomic>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

#include "core/threads.h"
#include "support/thread_ranks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::RunRanks;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;

/// What a loop over items with ranges of their own leaves.
struct Written {
  std::vector<double> by_item, by_chunk;
  std::vector<float> by_range;
  bool operator==(const Written&) const = default;
};

Written Write(std::size_t items, std::size_t chunk_size, std::atomic<int>* chunks) {
  std::vector<std::uint64_t> offsets{0};
  for (std::size_t i = 0; i < items; ++i) offsets.push_back(offsets.back() + i % 4);
  Written out;
  out.by_item.assign(items, -1.0);
  out.by_chunk.assign((items + chunk_size - 1) / chunk_size, 0.0);
  out.by_range.assign(offsets.back(), -1.0F);
  const auto work = [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    ++*chunks;
    for (std::size_t i = begin; i < end; ++i) {
      out.by_item[i] = std::sqrt(1.7 + static_cast<double>(i));
      out.by_chunk[chunk] += out.by_item[i];
      for (std::size_t k = offsets[i]; k < offsets[i + 1]; ++k) {
        out.by_range[k] = static_cast<float>(k) * 0.3F;
      }
    }
  };
  std::vector<float> unused;
  ForChunksOfRanks(items,
                   chunk_size,
                   {SharedArray::ByItem(&out.by_item),
                    SharedArray::ByChunk(&out.by_chunk),
                    SharedArray::ByRange(offsets, &out.by_range),
                    SharedArray::ByItem(&unused)},
                   work);
  return out;
}

// Two routes: the loop of a process alone. Every chunk is done once, by one of the ranks.
TEST(RanksTest, DivideALoopAndHoldWhatAProcessAloneWrites) {
  for (const std::size_t items : {0U, 1U, 13U, 1009U}) {
    for (const std::size_t chunk_size : {1U, 7U, 2000U}) {
      std::atomic<int> chunks_alone = 0;
      const Written alone = Write(items, chunk_size, &chunks_alone);
      EXPECT_THAT(alone.by_item, Each(testing::Gt(0.0)));
      for (const int size : {2, 3, 5}) {
        std::atomic<int> chunks = 0;
        RunRanks(size, [&](Ranks*) { EXPECT_EQ(Write(items, chunk_size, &chunks), alone); });
        EXPECT_EQ(chunks, chunks_alone) << size;
      }
    }
  }
}

// By count.
TEST(RanksTest, PiecesAreConsecutiveAndNearlyAsMany) {
  for (const std::size_t count : {0U, 1U, 5U, 64U, 1023U}) {
    for (const int ranks : {1, 2, 3, 7}) {
      std::size_t next = 0;
      for (int r = 0; r < ranks; ++r) {
        const PiecesOfRank its = PiecesOf(count, r, ranks);
        EXPECT_EQ(its.first, next);
        const std::size_t fair = count / static_cast<std::size_t>(ranks);
        EXPECT_TRUE(its.last - its.first == fair || its.last - its.first == fair + 1);
        next = its.last;
      }
      EXPECT_EQ(next, count);
    }
  }
}

// Chunks run on any thread: a loop inside one belongs to the rank that has the chunk.
TEST(RanksTest, ALoopInsideALoopIsNotDivided) {
  RunRanks(2, [](Ranks*) {
    std::vector<double> sums(6, 0.0);
    ForChunksOfRanks(
        sums.size(), 1, {SharedArray::ByItem(&sums)}, [&](std::size_t k, std::size_t, std::size_t) {
          EXPECT_EQ(RanksScope::Current(), nullptr);
          std::vector<double> inner(9, 0.0);
          ForChunksOfRanks(inner.size(),
                           2,
                           {SharedArray::ByItem(&inner)},
                           [&](std::size_t, std::size_t begin, std::size_t end) {
                             for (std::size_t i = begin; i < end; ++i) inner[i] = 1.0;
                           });
          sums[k] = std::accumulate(inner.begin(), inner.end(), 0.0);
        });
    EXPECT_THAT(sums, Each(9.0));
    EXPECT_NE(RanksScope::Current(), nullptr);
  });
  EXPECT_EQ(RanksScope::Current(), nullptr);
}

TEST(RanksTest, OneRankIsAProcessAlone) {
  RunRanks(1, [](Ranks*) { EXPECT_EQ(RanksScope::Current(), nullptr); });
}

TEST(RanksTest, JoinListsOfAnyLengthInTheOrderOfRanks) {
  RunRanks(3, [](Ranks* ranks) {
    std::vector<int> own;
    if (ranks->rank() == 0) own = {7, 5};
    if (ranks->rank() == 2) own = {3};
    EXPECT_THAT(JoinedOfRanks(own), ElementsAre(7, 5, 3));
  });
  EXPECT_THAT(JoinedOfRanks(std::vector<int>{4, 2}), ElementsAre(4, 2));
}

TEST(RanksTest, CountTheThreadsOfAll) {
  const int own = ThreadsAllowed();
  EXPECT_EQ(ThreadsOfRanks(), own);
  RunRanks(3, [&](Ranks*) { EXPECT_EQ(ThreadsOfRanks(), 3 * own); });
}

// A part that continues the one before in memory is one message with it.
TEST(RanksTest, PartsThatFollowEachOtherBecomeOne) {
  std::vector<double> values(10);
  const auto bytes = std::as_writable_bytes(std::span(values));
  std::vector<RankPart> parts;
  AddPart(bytes.first(16), 0, &parts);
  AddPart(bytes.subspan(16, 8), 0, &parts);
  AddPart(bytes.subspan(24, 0), 1, &parts);
  AddPart(bytes.subspan(24, 8), 1, &parts);
  AddPart(bytes.subspan(40, 8), 1, &parts);
  ASSERT_EQ(parts.size(), 3U);
  EXPECT_EQ(parts[0].bytes, 24U);
  EXPECT_EQ(parts[1].rank, 1);
  EXPECT_EQ(parts[2].data, bytes.data() + 40);
}

// Every rank sends each other one its own numbers, beside numbers for all; those that it neither
// sends nor gets have no place here, and a sequence is cut otherwise where it arrives.
TEST(RanksTest, BringPartsToOneRankAlone) {
  for (const int size : {2, 3, 5}) {
    RunRanks(size, [&](Ranks* ranks) {
      const auto number = [](int from, int to, int k) { return 1.3 + 100 * from + 10 * to + k; };
      const int own = ranks->rank();
      std::vector<double> for_all(static_cast<std::size_t>(size), -1.0);
      for_all[static_cast<std::size_t>(own)] = number(own, own, 7);
      std::vector<std::vector<double>> sent, got;
      std::vector<RankPart> parts;
      for (int from = 0; from < size; ++from) {
        AddPart(std::as_writable_bytes(std::span(&for_all[static_cast<std::size_t>(from)], 1)),
                from,
                &parts);
        for (int to = 0; to < size; ++to) {
          if (from == to) continue;
          RankPart part{.bytes = 3 * sizeof(double), .rank = from, .to = to};
          if (own == from) {
            auto& numbers = sent.emplace_back();
            for (const int k : {0, 1, 2}) numbers.push_back(number(from, to, k));
            part.bytes = sizeof(double);
            for (double& value : numbers) {
              part.data = reinterpret_cast<std::byte*>(&value);
              parts.push_back(part);
            }
            continue;
          }
          if (own == to) part.data = reinterpret_cast<std::byte*>(got.emplace_back(3).data());
          parts.push_back(part);
        }
      }
      ranks->Share(parts);
      std::size_t k = 0;
      for (int from = 0; from < size; ++from) {
        EXPECT_EQ(for_all[static_cast<std::size_t>(from)], number(from, from, 7));
        if (from == own) continue;
        EXPECT_THAT(got[k++],
                    ElementsAre(number(from, own, 0), number(from, own, 1), number(from, own, 2)));
      }
    });
  }
}

TEST(RanksTest, ARankThatFailsAloneEndsTheOthersWithItsWords) {
  RunRanks(3, [](Ranks* ranks) {
    Ending ending;
    try {
      if (ranks->rank() == 1) throw InputError("looks", "too few");
      static_cast<void>(ThreadsOfRanks());
      ADD_FAILURE() << "a rank went on without rank 1";
    } catch (const OtherRankFailed& error) {
      EXPECT_THAT(error.what(), HasSubstr("too few"));
      EXPECT_NE(ranks->rank(), 1);
      EXPECT_TRUE(ranks->Agree(nullptr).has_value());  // known: nobody is asked again
    } catch (const InputError& error) {
      ending = {3, error.what()};
    }
    const Ending agreed = ranks->Conclude(ending);
    EXPECT_EQ(agreed.exit_code, 3);
    EXPECT_THAT(agreed.words, HasSubstr("looks: too few"));
  });
}

TEST(RanksTest, TheLowestRankSpeaksForAllThatFail) {
  RunRanks(4, [](Ranks* ranks) {
    const Ending own{10 + ranks->rank(), "rank " + std::to_string(ranks->rank())};
    const std::optional<Ending> agreed = ranks->Agree(ranks->rank() >= 2 ? &own : nullptr);
    ASSERT_TRUE(agreed.has_value());
    EXPECT_EQ(agreed->exit_code, 12);
    EXPECT_EQ(ranks->Conclude({1, {}}).words, "rank 2");
  });
}

TEST(RanksTest, TheFirstRankGivesTheExitCodeWhereNoneFails) {
  RunRanks(3, [](Ranks* ranks) {
    EXPECT_FALSE(ranks->Agree(nullptr).has_value());
    const Ending ending = ranks->Conclude({ranks->first() ? 1 : 0, {}});
    EXPECT_EQ(ending.exit_code, 1);
    EXPECT_FALSE(ending.failed());
  });
}

// Processors that round differently are found out before a decision differs.
TEST(RanksTest, RefuseNumbersThatDiffer) {
  RunRanks(2, [](Ranks* ranks) {
    std::vector<double> same{1.3, -2.7};
    ranks->RequireSame(std::as_bytes(std::span(same)));
    same[1] = std::nextafter(same[1], ranks->rank() == 0 ? 0.0 : -2.7);
    EXPECT_THROW(ranks->RequireSame(std::as_bytes(std::span(same))), InputError);
  });
}

}  // namespace
}  // namespace sarblock
