// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <csignal>
#include <numeric>
#include <thread>
#include <vector>

#include "core/threads.h"
#include "linear/block_cholesky.h"
#include "linear/symbolic.h"
#include "random_block_matrix.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock::sparse {
namespace {

using testing::ElementsAre;

BlockPattern GridPattern(int nx, int ny) {
  const auto count = static_cast<std::size_t>(nx * ny);
  return {std::vector<int>(count, 3), test::Grid(nx, ny, 1, 1)};
}

std::vector<int> Sorted(std::vector<int> order) {
  std::sort(order.begin(), order.end());
  return order;
}

TEST(OrderingTest, BothOrdersHaveEveryBlockOnceAndTheLastOnesAsGiven) {
  const BlockPattern pattern = GridPattern(9, 7);
  std::vector<int> all(63);
  std::iota(all.begin(), all.end(), 0);
  const std::vector<int> last = {17, 4, 17};
  for (const std::vector<int>& order :
       {MinimumDegreeOrder(pattern, last), DissectionOrder(pattern, last).value()}) {
    EXPECT_EQ(Sorted(order), all);
    EXPECT_EQ(order[61], 17);
    EXPECT_EQ(order[62], 4);
  }
}

TEST(OrderingTest, AGraphWithoutFreeBlocksIsTheTail) {
  const BlockPattern pattern = GridPattern(2, 1);
  const std::vector<int> last = {1, 0};
  EXPECT_THAT(MinimumDegreeOrder(pattern, last), ElementsAre(1, 0));
  EXPECT_THAT(DissectionOrder(pattern, last).value(), ElementsAre(1, 0));
}

// Invariance: METIS draws from the random numbers of the C library, from a fixed seed.
TEST(OrderingTest, DissectionIsTheSameEveryTimeAndBesideOthers) {
  const BlockPattern pattern = GridPattern(31, 29);
  const std::vector<int> first = DissectionOrder(pattern, {}).value();
  std::vector<std::vector<int>> beside(6);
  std::vector<std::thread> threads;
  for (std::vector<int>& order : beside) {
    threads.emplace_back([&] { order = DissectionOrder(pattern, {}).value(); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<int>& order : beside) EXPECT_EQ(order, first);
}

TEST(OrderingTest, DissectionLeavesTheHandlersOfSignalsAsTheyWere) {
  struct sigaction before {};
  sigaction(SIGTERM, nullptr, &before);
  struct sigaction own {};
  own.sa_handler = SIG_IGN;
  own.sa_flags = SA_RESTART;
  sigaction(SIGTERM, &own, nullptr);
  static_cast<void>(DissectionOrder(GridPattern(5, 5), {}));
  struct sigaction after {};
  sigaction(SIGTERM, &before, &after);
  EXPECT_EQ(after.sa_handler, SIG_IGN);
  EXPECT_EQ(after.sa_flags & SA_RESTART, SA_RESTART);
}

// Closed form: a chain has no fill; a block of three rows whose next one has three more is
// eliminated with columns of 6, 5 and 4 entries, the last with 3, 2 and 1.
TEST(OrderingTest, OperationsOfAChainAreThoseByHand) {
  const BlockPattern pattern(std::vector<int>(5, 3), test::Band(5, 1));
  const Symbolic symbolic = Analyse(pattern, {});
  EXPECT_EQ(symbolic.operations, 4 * (36 + 25 + 16) + 9 + 4 + 1);
  EXPECT_FALSE(symbolic.dissected);
}

// Of a square grid dissection is the better order (George 1973), of a narrow band it is not; below
// the limit it is not tried.
TEST(OrderingTest, TheOrderWithFewerOperationsIsTaken) {
  const BlockPattern square = GridPattern(60, 60);
  const Symbolic small = Analyse(square, {});
  ASSERT_LT(small.operations, kManyOperations);
  EXPECT_FALSE(small.dissected);
  const Symbolic chosen = Analyse(square, {}, 1.0);
  EXPECT_TRUE(chosen.dissected);
  EXPECT_LT(chosen.operations, small.operations);
  const Symbolic band = Analyse({std::vector<int>(300, 3), test::Band(300, 2)}, {}, 1.0);
  EXPECT_FALSE(band.dissected);
}

// By count: memory known from the pattern alone against what one thread took; within a tenth.
TEST(FactorNeedsTest, AreWhatIsTakenWhenTheMatrixIsFactored) {
  std::mt19937_64 engine(37);
  const std::vector<BlockSymmetricMatrix> matrices = {
      test::RandomPositive(
          test::RandomSizes(900, 6, engine), test::Grid(30, 30, 1, 1), 0.8, engine),
      test::RandomPositive(test::RandomSizes(300, 9, engine), test::Band(300, 7), 0.8, engine),
      test::RandomPositive(std::vector<int>(240, 12), test::Grid(12, 10, 2, 1), 0.8, engine)};
  for (const BlockSymmetricMatrix& matrix : matrices) {
    const ThreadLimit one(1);
    BlockCholesky factor(matrix);
    const FactorNeeds needs = factor.Needs();
    EXPECT_GT(needs.waiting, 0U);
    EXPECT_EQ(factor.Used().factor, 0U);  // nothing is taken before
    ASSERT_TRUE(factor.Factorize(matrix).positive_definite);
    static_cast<void>(factor.SelectedInverse());
    const FactorNeeds used = factor.Used();
    EXPECT_EQ(needs.factor, used.factor);
    EXPECT_NEAR(static_cast<double>(used.waiting),
                static_cast<double>(needs.waiting),
                0.1 * static_cast<double>(needs.waiting));
    EXPECT_NEAR(static_cast<double>(used.inverse_fronts),
                static_cast<double>(needs.inverse_fronts),
                0.1 * static_cast<double>(needs.inverse_fronts));
  }
}

}  // namespace
}  // namespace sarblock::sparse
