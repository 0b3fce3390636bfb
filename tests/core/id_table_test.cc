// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/id_table.h"

#include "sarblock/core/statistics.h"

#include <atomic>
#include <string>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace sarblock {
namespace {

IdTable TableOf(const std::vector<std::string>& ids) {
  IdTable table;
  for (const std::string& id : ids) table.Append(id);
  return table;
}

TEST(IdTableTest, KeepsIdsInTheOrderTheyCame) {
  const IdTable table = TableOf({"P17", "", "Kirchturm Süd", "P17x"});
  ASSERT_EQ(table.size(), 4u);
  EXPECT_EQ(table[0], "P17");
  EXPECT_EQ(table[1], "");
  EXPECT_EQ(table[2], "Kirchturm Süd");
  EXPECT_EQ(table[3], "P17x");
  for (std::uint32_t i = 0; i < 4; ++i) EXPECT_EQ(table.Find(table[i]), i);
  EXPECT_EQ(table.Find("P1"), IdTable::kNone);
}

TEST(IdTableTest, AnEmptyTableFindsNothing) {
  const IdTable table;
  EXPECT_EQ(table.size(), 0u);
  EXPECT_EQ(table.Find("P17"), IdTable::kNone);
  EXPECT_EQ(table.Nearest("P17"), "");
}

// Second route: the standard library's map. Ids from a small alphabet repeat often; the index is
// dropped and rebuilt and appended to past it on the way.
TEST(IdTableTest, AgreesWithAStandardMap) {
  IdTable table;
  std::unordered_map<std::string, std::uint32_t> map;
  RandomStream random(71, 5);
  for (int i = 0; i < 20000; ++i) {
    std::string id;
    for (std::uint64_t n = 1 + random.Bits() % 7; n > 0; --n) {
      id += static_cast<char>('a' + random.Bits() % 4);
    }
    const auto known = map.find(id);
    EXPECT_EQ(table.Find(id), known == map.end() ? IdTable::kNone : known->second);
    const std::uint32_t index = table.FindOrAppend(id);
    EXPECT_EQ(map.emplace(id, index).first->second, index);
    if (i % 6007 == 0) table.DropIndex();
  }
  EXPECT_EQ(table.size(), map.size());
  EXPECT_GT(table.size(), 3000u);
  for (const auto& [id, index] : map) EXPECT_EQ(table[index], id);
}

// Second route: each id is at its own place. The first to ask builds the index, and all ask at
// once; of 120 rounds of two threads one was wrong before.
TEST(IdTableTest, ManyThreadsMayFindInAConstTable) {
  std::vector<std::string> ids;
  for (int i = 0; i < 500; ++i) ids.push_back("P" + std::to_string(7 * i));
  std::atomic<int> wrong{0};
  for (int round = 0; round < 200; ++round) {
    const IdTable table = TableOf(ids);
    std::atomic<int> ready{0};
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&] {
        ++ready;
        while (ready < 4) std::this_thread::yield();
        for (std::uint32_t i = 0; i < ids.size(); i += 50) wrong += table.Find(ids[i]) == i ? 0 : 1;
        wrong += table.Find("none") == IdTable::kNone ? 0 : 1;
      });
    }
    for (std::thread& thread : threads) thread.join();
  }
  EXPECT_EQ(wrong, 0);
}

TEST(IdTableTest, CopiesAndMovesKeepWhatIsFound) {
  IdTable table = TableOf({"b", "a"});
  EXPECT_EQ(table.Find("a"), 1u);
  IdTable copy = table;
  copy.Append("c");
  EXPECT_EQ(copy.Find("c"), 2u);
  EXPECT_EQ(table.Find("c"), IdTable::kNone);
  table = copy;
  EXPECT_EQ(table.Find("c"), 2u);
  const IdTable moved = std::move(copy);
  EXPECT_EQ(moved.Find("a"), 1u);
}

TEST(IdTableTest, FindsTheFirstOfTwoEqualIdsBeforeAndAfterTheIndexIsBuilt) {
  IdTable table = TableOf({"a", "b", "b"});
  EXPECT_EQ(table.Find("b"), 1u);
  EXPECT_EQ(table.Append("a"), 3u);
  EXPECT_EQ(table.Find("a"), 0u);
  table.DropIndex();
  EXPECT_EQ(table.Find("a"), 0u);
}

TEST(IdTableTest, AppendsAscendingIdsOnceWhateverFollowsThem) {  // hand-made order
  IdTable table;
  const std::vector<std::string> ids{"C1", "C2", "C10", "T1", "T9", "T10", "T2", "C10", "A", "T10"};
  const std::vector<std::uint32_t> expected{0, 1, 2, 3, 4, 5, 6, 2, 7, 5};
  for (std::size_t i = 0; i < ids.size(); ++i) {
    EXPECT_EQ(table.FindOrAppend(ids[i]), expected[i]) << ids[i];
  }
  IdTable equal;
  EXPECT_EQ(equal.FindOrAppend("T1"), 0u);
  EXPECT_EQ(equal.FindOrAppend("T1"), 0u);
  EXPECT_EQ(equal.FindOrAppend(""), 1u);
  EXPECT_EQ(equal.FindOrAppend(""), 1u);
}

// Hand values of the edit distance: two letters exchanged, one lost, one more.
TEST(IdTableTest, ProposesTheNearestId) {
  const IdTable table = TableOf({"reflector_north", "GCP17", "tie_004"});
  EXPECT_EQ(table.Nearest("GCP71"), "GCP17");
  EXPECT_EQ(table.Nearest("reflctor_north"), "reflector_north");
  EXPECT_EQ(table.Nearest("TIE_0044"), "tie_004");
  EXPECT_EQ(table.Nearest("xyz"), "");  // nothing in common with any
}

TEST(IdTableTest, ProposesFromALargeTableToo) {
  IdTable table;
  for (int i = 0; i < 5000; ++i)
    table.Append(std::string("point").append(std::to_string(100000 + 37 * i)));
  table.Append("Corner7");
  EXPECT_EQ(table.Nearest("corner-7"), "Corner7");  // one edit, behind the first 2000
  EXPECT_EQ(table.Nearest("point100038"), "point100037");
  EXPECT_EQ(table.Nearest("something else"), "point100000");  // nothing near: still an answer
}

TEST(NearestNameTest, ChoosesByEditDistance) {
  EXPECT_EQ(NearestName("positon", {"range", "position", "time"}), "position");
  EXPECT_EQ(NearestName("TIMES", {"range", "position", "time"}), "time");
  EXPECT_EQ(NearestName("x", {}), "");
}

}  // namespace
}  // namespace sarblock
