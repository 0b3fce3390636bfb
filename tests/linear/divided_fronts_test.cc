// SPDX-License-Identifier: Apache-2.0
// Factor, solutions and selected inverse divided among ranks, here threads
// (support/thread_ranks.h). Invariance: the bytes of a process alone, on nets whose fronts cross
// between ranks several times.
#include <algorithm>
#include <cstring>
#include <limits>
#include <new>
#include <string>

#include "core/threads.h"
#include "linear/block_cholesky.h"
#include "linear/front_ranks.h"
#include "random_block_matrix.h"
#include "support/thread_ranks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::MatrixXd;
using test::RunRanks;

/// Every matrix is divided.
constexpr double kAny = 0.0;

MatrixXd SomeColumns(int rows, int columns) {
  std::mt19937_64 engine(77);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&]() { return normal(engine); });
}

template <typename A, typename B>
bool SameBytes(const A& a, const B& b) {
  if (a.size() == 0) return b.size() == 0;
  return static_cast<std::size_t>(a.size()) == static_cast<std::size_t>(b.size()) &&
         std::memcmp(a.data(), b.data(), sizeof(a[0]) * static_cast<std::size_t>(a.size())) == 0;
}

bool SameMatrix(const MatrixXd& a, const MatrixXd& b) {
  return SameBytes(a.reshaped(), b.reshaped());
}

/// Everything a factor gives.
struct Given {
  BlockCholesky::Outcome outcome;
  MatrixXd one, many;
  std::vector<double> inverse;
  FactorNeeds needs, used;
  bool divided = false;
};

Given Give(const BlockSymmetricMatrix& matrix, std::span<const int> last = {}) {
  Given out;
  BlockCholesky cholesky(matrix, last, kAny);
  out.divided = cholesky.divided();
  out.needs = cholesky.Needs();
  out.outcome = cholesky.Factorize(matrix);
  if (out.outcome.positive_definite) {
    out.one = SomeColumns(matrix.rows(), 1);
    cholesky.Solve(out.one);
    out.many = SomeColumns(matrix.rows(), 5);
    cholesky.Solve(out.many);
    const BlockSymmetricMatrix inverse = cholesky.SelectedInverse();
    out.inverse.assign(inverse.values().begin(), inverse.values().end());
  }
  out.used = cholesky.Used();
  return out;
}

void ExpectSame(const Given& a, const Given& b) {
  EXPECT_EQ(a.outcome.positive_definite, b.outcome.positive_definite);
  EXPECT_EQ(a.outcome.failed_row, b.outcome.failed_row);
  EXPECT_EQ(a.outcome.smallest_pivot_ratio, b.outcome.smallest_pivot_ratio);
  EXPECT_EQ(a.outcome.smallest_pivot_row, b.outcome.smallest_pivot_row);
  EXPECT_TRUE(SameMatrix(a.one, b.one));
  EXPECT_TRUE(SameMatrix(a.many, b.many));
  EXPECT_TRUE(SameBytes(a.inverse, b.inverse));
}

void ExpectSameOnRanks(const BlockSymmetricMatrix& matrix, std::span<const int> last = {}) {
  const ThreadLimit threads(2);
  const Given alone = Give(matrix, last);
  EXPECT_FALSE(alone.divided);
  for (const int size : {1, 2, 3, 4, 7}) {
    RunRanks(size, [&](Ranks* ranks) {
      SCOPED_TRACE(std::to_string(ranks->rank()) + " of " + std::to_string(size));
      const Given own = Give(matrix, last);
      EXPECT_EQ(own.divided, size > 1 && matrix.rows() > 0);
      ExpectSame(own, alone);
    });
  }
}

BlockSymmetricMatrix Net(int nx, int ny, unsigned seed) {
  std::mt19937_64 engine(seed);
  return test::RandomPositive(
      test::RandomSizes(nx * ny, 8, engine), test::Grid(nx, ny, 1, 1), 0.8, engine);
}

TEST(DividedFrontsTest, GiveTheBytesOfAProcessAloneOnANet) { ExpectSameOnRanks(Net(17, 13, 31)); }

TEST(DividedFrontsTest, GiveTheBytesOfAProcessAloneOnRandomPatterns) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 engine(seed);
    const int count = 1 + static_cast<int>(engine() % 60);
    const int edges = static_cast<int>(engine() % (2 * static_cast<unsigned>(count)));
    const auto matrix = test::RandomPositive(
        test::RandomSizes(count, 9, engine), test::RandomPairs(count, edges, engine), 1.1, engine);
    const std::vector<int> last = {count / 2, count - 1};
    ExpectSameOnRanks(matrix, std::span(last).first(seed % 3));
  }
}

TEST(DividedFrontsTest, ServeMatricesWithoutRowsAndBlocksWithoutRows) {
  ExpectSameOnRanks(BlockSymmetricMatrix(std::vector<int>{}, {}));
  std::mt19937_64 engine(36);
  std::vector<int> sizes = test::RandomSizes(60, 5, engine);
  for (std::size_t b = 0; b < sizes.size(); b += 3) sizes[b] = 0;
  ExpectSameOnRanks(test::RandomPositive(sizes, test::Grid(10, 6, 1, 1), 0.9, engine));
}

TEST(DividedFrontsTest, GiveTheBytesOfAProcessAloneOnFrontsOfSeveralTiles) {
  std::mt19937_64 engine(34);
  const std::vector<int> sizes = {210, 400, 280, 90, 330, 120};
  ExpectSameOnRanks(
      test::RandomPositive(sizes, {{1, 0}, {2, 1}, {3, 2}, {4, 2}, {5, 4}}, 0.9, engine));
}

// A pivot fails in one subtree, in several, and near the root: all ranks name the row that one
// process names, and the next matrix is factored as if nothing had been.
TEST(DividedFrontsTest, NameTheRowThatAProcessAloneNames) {
  const BlockSymmetricMatrix good = Net(9, 8, 33);
  for (unsigned seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 engine(seed);
    BlockSymmetricMatrix bad = good;
    for (unsigned k = 0; k <= seed % 3; ++k) {
      const int block = static_cast<int>(engine() % static_cast<unsigned>(bad.block_count()));
      const int row = static_cast<int>(engine() % static_cast<unsigned>(bad.size(block)));
      bad.Block(block, block)(row, row) =
          seed % 4 == 3 ? std::numeric_limits<double>::quiet_NaN() : -3.7;
    }
    BlockCholesky cholesky(good);
    const BlockCholesky::Outcome alone = cholesky.Factorize(bad);
    EXPECT_FALSE(alone.positive_definite);
    for (const int size : {2, 3, 5}) {
      RunRanks(size, [&](Ranks*) {
        BlockCholesky divided(good, {}, kAny);
        const BlockCholesky::Outcome own = divided.Factorize(bad);
        EXPECT_FALSE(own.positive_definite);
        EXPECT_EQ(own.failed_row, alone.failed_row);
        EXPECT_EQ(own.smallest_pivot_row, alone.smallest_pivot_row);
        EXPECT_EQ(own.smallest_pivot_ratio, alone.smallest_pivot_ratio);
        const BlockCholesky::Outcome again = divided.Factorize(good);
        EXPECT_TRUE(again.positive_definite);
        MatrixXd x = SomeColumns(good.rows(), 2), expected = x;
        divided.Solve(x);
        BlockCholesky other(good);
        {
          const RanksScope none(nullptr);
          EXPECT_TRUE(other.Factorize(good).positive_definite);
          other.Solve(expected);
        }
        EXPECT_TRUE(SameMatrix(x, expected));
      });
    }
  }
}

TEST(DividedFrontsTest, CarryABorder) {
  BlockSymmetricMatrix sparse = Net(11, 9, 35);
  const MatrixXd border = 0.002 * SomeColumns(sparse.rows(), 6).transpose();
  const BorderedMatrix matrix(sparse, border);
  const auto give = [&] {
    BorderedCholesky cholesky(sparse, {}, kAny);
    EXPECT_TRUE(cholesky.Factorize(matrix));
    MatrixXd x = SomeColumns(matrix.rows(), 3);
    cholesky.Solve(x);
    const BorderedInverse inverse = cholesky.SelectedInverse();
    const auto blocks = inverse.blocks.values();
    return std::tuple(
        x, inverse.border.ToDense(), std::vector<double>(blocks.begin(), blocks.end()));
  };
  const auto [x, of_border, blocks] = give();
  for (const int size : {2, 4}) {
    RunRanks(size, [&, &x = x, &of_border = of_border, &blocks = blocks](Ranks*) {
      const auto [own_x, own_border, own_blocks] = give();
      EXPECT_TRUE(SameMatrix(own_x, x));
      EXPECT_TRUE(SameMatrix(own_border, of_border));
      EXPECT_TRUE(SameBytes(own_blocks, blocks));
    });
  }
}

// By count: what one thread takes is what was predicted, the most on the largest rank.
TEST(DividedFrontsTest, TakeTheMemoryThatTheyPredict) {
  const ThreadLimit one(1);
  const std::vector<int> sizes(50 * 16, 6);
  std::mt19937_64 engine(2023);
  const auto matrix = test::RandomPositive(sizes, test::Grid(50, 16, 1, 1), 1.0, engine);
  const Given alone = Give(matrix);
  EXPECT_EQ(sparse::MaxDoubles(alone.used), sparse::MaxDoubles(alone.needs));
  for (const int size : {2, 4}) {
    std::vector<FactorNeeds> used(static_cast<std::size_t>(size)), needs(used.size());
    RunRanks(size, [&](Ranks* ranks) {
      const Given own = Give(matrix);
      used[static_cast<std::size_t>(ranks->rank())] = own.used;
      needs[static_cast<std::size_t>(ranks->rank())] = own.needs;
    });
    std::size_t most = 0, factor = 0;
    for (const FactorNeeds& of_rank : used) {
      most = std::max(most, sparse::MaxDoubles(of_rank));
      factor += of_rank.factor;
    }
    EXPECT_EQ(factor, alone.used.factor) << "every panel stands on one rank";
    for (const FactorNeeds& of_rank : needs) {
      EXPECT_EQ(sparse::MaxDoubles(of_rank), most);
      EXPECT_EQ(of_rank.operations, alone.needs.operations);
    }
  }
}

// By count: 48,000 and 120,000 unknowns in two-dimensional nets of passes.
TEST(DividedFrontsTest, TheLargestRankHoldsAPartOfWhatAProcessAloneHolds) {
  struct Net {
    int lines, segments, parameters;
    double share_of_two, share_of_four;
  };
  for (const Net& net : {Net{50, 20, 24, 0.75, 0.65}, Net{100, 100, 6, 0.65, 0.45}}) {
    const std::vector<int> sizes(static_cast<std::size_t>(2 * net.lines * net.segments),
                                 net.parameters);
    const BlockPattern pattern(sizes, test::Grid(net.lines, net.segments, 2, 2));
    const sparse::Symbolic symbolic = sparse::Analyse(pattern, {});
    const auto most = [&](int ranks) {
      std::size_t doubles = 0;
      const sparse::FrontDivision division = sparse::DivideFronts(symbolic.fronts, ranks);
      for (const FactorNeeds& needs : sparse::NeedsOfRanks(symbolic.fronts, division)) {
        doubles = std::max(doubles, sparse::MaxDoubles(needs));
      }
      return static_cast<double>(doubles);
    };
    EXPECT_LE(most(2), net.share_of_two * most(1)) << net.lines;
    EXPECT_LE(most(4), net.share_of_four * most(1)) << net.lines;
  }
}

TEST(DividedFrontsTest, SmallMatricesStandOnEveryRank) {
  const BlockSymmetricMatrix matrix = Net(7, 6, 32);
  RunRanks(3, [&](Ranks*) {
    BlockCholesky cholesky(matrix);
    EXPECT_FALSE(cholesky.divided());
    EXPECT_TRUE(cholesky.Factorize(matrix).positive_definite);
    const RanksScope none(nullptr);  // as within a loop
    MatrixXd x = SomeColumns(matrix.rows(), 1);
    cholesky.Solve(x);
  });
}

// A rank without memory between two exchanges, and all the others come to know.
TEST(DividedFrontsTest, ARankThatFailsEndsTheOthers) {
  const BlockSymmetricMatrix matrix = Net(12, 9, 37);
  for (const int failing : {0, 2}) {
    RunRanks(3, [&](Ranks* ranks) {
      BlockCholesky cholesky(matrix, {}, kAny);
      ASSERT_TRUE(cholesky.Factorize(matrix).positive_definite);
      Ending ending;
      try {
        if (ranks->rank() == failing) throw std::bad_alloc();
        static_cast<void>(cholesky.SelectedInverse());
        ADD_FAILURE() << "an inverse without rank " << failing;
      } catch (const std::bad_alloc&) {
        ending = {3, "no memory"};
      } catch (const OtherRankFailed& error) {
        EXPECT_STREQ(error.what(), "no memory");
      }
      EXPECT_EQ(ranks->Conclude(ending).words, "no memory");
    });
  }
}

TEST(DividedFrontsDeathTest, AreNotUsedWithinALoop) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const BlockSymmetricMatrix matrix = Net(5, 5, 38);
  EXPECT_DEATH(RunRanks(2,
                        [&](Ranks*) {
                          BlockCholesky cholesky(matrix, {}, kAny);
                          const RanksScope none(nullptr);
                          static_cast<void>(cholesky.Factorize(matrix));
                        }),
               "is used without them");
}

// Invariance: each front on one rank, every stage after those of its children.
TEST(FrontDivisionTest, PutsEveryFrontOnARankAfterItsChildren) {
  const BlockSymmetricMatrix matrix = Net(20, 15, 39);
  const sparse::Symbolic symbolic = sparse::Analyse(*matrix.pattern(), {}, kAny);
  const auto& fronts = symbolic.fronts;
  for (const int ranks : {1, 2, 3, 8, 64}) {
    const sparse::FrontDivision division = sparse::DivideFronts(fronts, ranks);
    EXPECT_EQ(division.ranks, ranks);
    for (std::size_t f = 0; f < fronts.size(); ++f) {
      EXPECT_THAT(division.owner[f], testing::AllOf(testing::Ge(0), testing::Lt(ranks)));
      EXPECT_LT(division.stage[f], division.stages);
      if (fronts[f].parent < 0) continue;
      const int parent = division.stage[sparse::At(fronts[f].parent)];
      EXPECT_GE(parent, division.stage[f] + (division.Crosses(fronts[f], f) ? 1 : 0));
    }
  }
}

// By hand: two branches of 4 rows under a root of 2; each rank has a branch, one of them the root.
TEST(FrontDivisionTest, GivesEachRankABranch) {
  std::vector<sparse::Front> fronts(3);
  for (const int branch : {0, 1}) {
    fronts[sparse::At(branch)].eliminated = 4;
    fronts[sparse::At(branch)].remaining = 2;
    fronts[sparse::At(branch)].parent = 2;
    fronts[2].children.push_back(branch);
  }
  fronts[2].eliminated = 2;
  const sparse::FrontDivision division = sparse::DivideFronts(fronts, 2);
  EXPECT_NE(division.owner[0], division.owner[1]);
  EXPECT_EQ(division.stages, 2);
  EXPECT_THAT(division.stage, testing::ElementsAre(0, 0, 1));
  const std::vector<FactorNeeds> needs = sparse::NeedsOfRanks(fronts, division);
  // Panels of 6 x 4 and of the root's 2 x 2. Update matrices are counted in lines of 8: one of 2 x
  // 2 stands in one, as does the packed one that comes to the root, beside the root's empty one.
  const auto of_root = sparse::At(division.owner[2]);
  EXPECT_EQ(needs[of_root].factor, 28U);
  EXPECT_EQ(needs[1 - of_root].factor, 24U);
  EXPECT_EQ(needs[of_root].waiting, 24U);
  EXPECT_EQ(needs[1 - of_root].waiting, 8U);
}

}  // namespace
}  // namespace sarblock
