// SPDX-License-Identifier: Apache-2.0
#include "linear/block_cholesky.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/threads.h"
#include "random_block_matrix.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

BlockSymmetricMatrix RandomGrid(unsigned seed) {
  std::mt19937_64 engine(seed);
  return test::RandomPositive(
      test::RandomSizes(7 * 6, 8, engine), test::Grid(7, 6, 1, 1), 0.8, engine);
}

MatrixXd RandomColumns(int rows, int columns, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&]() { return normal(engine); });
}

/// Scalar blocks in a chain, diagonal and first off-diagonal given.
BlockSymmetricMatrix Chain(const std::vector<double>& diagonal, const std::vector<double>& off) {
  const int count = static_cast<int>(diagonal.size());
  BlockSymmetricMatrix matrix(std::vector<int>(diagonal.size(), 1), test::Band(count, 1));
  for (int k = 0; k < count; ++k) {
    matrix.Block(k, k)(0, 0) = diagonal[static_cast<std::size_t>(k)];
    if (k + 1 < count) {
      matrix.Block(k + 1, k)(0, 0) = off[static_cast<std::size_t>(k)];
    }
  }
  return matrix;
}

TEST(BlockCholeskyTest, SolvesOneAndManyColumns) {  // residual in the original equations
  const BlockSymmetricMatrix matrix = RandomGrid(21);
  BlockCholesky cholesky(matrix);
  ASSERT_TRUE(cholesky.Factorize(matrix).positive_definite);
  for (const int columns : {1, 2, 37}) {
    const MatrixXd b = RandomColumns(matrix.rows(), columns, 22);
    MatrixXd x = b;
    cholesky.Solve(x);
    // Backward stable: residual of some n * 1e-16 of norm(S) norm(x).
    const MatrixXd dense = matrix.ToDense();
    EXPECT_LE((dense * x - b).norm(), 1e-14 * dense.norm() * x.norm()) << columns;
  }
}

TEST(BlockCholeskyTest, SolvesAColumnOfALargerMatrix) {  // strided storage through Eigen::Ref
  const BlockSymmetricMatrix matrix = RandomGrid(23);
  BlockCholesky cholesky(matrix);
  ASSERT_TRUE(cholesky.Factorize(matrix).positive_definite);
  const MatrixXd b = RandomColumns(matrix.rows() + 5, 3, 24);
  MatrixXd x = b;
  cholesky.Solve(x.block(2, 1, matrix.rows(), 2));
  EXPECT_EQ(x.col(0), b.col(0));
  EXPECT_EQ(x.topRows(2), b.topRows(2));
  const MatrixXd residual =
      matrix.ToDense() * x.block(2, 1, matrix.rows(), 2) - b.block(2, 1, matrix.rows(), 2);
  EXPECT_LE(residual.norm(), 1e-11);  // norm(S) norm(x) is below 1e4
}

TEST(BlockCholeskyTest, DiagonalMatrixHasPivotRatioOne) {
  const BlockSymmetricMatrix matrix = Chain({4.0, 1e-8, 2.25e6}, {0.0, 0.0});
  const auto outcome = BlockCholesky(matrix).Factorize(matrix);
  ASSERT_TRUE(outcome.positive_definite);
  EXPECT_NEAR(outcome.smallest_pivot_ratio, 1.0, 1e-15);
  EXPECT_EQ(outcome.failed_row, -1);
}

TEST(BlockCholeskyTest, ReportsTheWeakestPivotRelativeToItsDiagonal) {
  // Hand value: correlation 1 - e leaves the pivot 1 - (1 - e)^2 of whichever row comes second.
  const double e = 1e-9, rho = 1.0 - e;
  BlockSymmetricMatrix matrix({1, 2, 1}, {{0, 1}, {1, 2}});
  matrix.Block(0, 0)(0, 0) = 5.5;
  matrix.Block(1, 1) << 9.0, 0.0, 3.0 * 2e3 * rho, 4e6;  // lower triangle: rows 1 and 2
  matrix.Block(2, 2)(0, 0) = 7.25;
  const auto outcome = BlockCholesky(matrix).Factorize(matrix);
  ASSERT_TRUE(outcome.positive_definite);
  EXPECT_EQ(outcome.smallest_pivot_row, 2);
  EXPECT_NEAR(outcome.smallest_pivot_ratio, 1.0 - rho * rho, 1e-15);  // cancels to some eps
}

TEST(BlockCholeskyTest, NamesTheRowOfANegativeDiagonal) {
  for (const int bad : {0, 7, 41}) {
    BlockSymmetricMatrix matrix = RandomGrid(27);
    const int last_of_block = matrix.size(bad) - 1;
    matrix.Block(bad, bad)(last_of_block, last_of_block) = -0.37;
    const auto outcome = BlockCholesky(matrix).Factorize(matrix);
    EXPECT_FALSE(outcome.positive_definite);
    EXPECT_EQ(outcome.failed_row, matrix.offset(bad) + last_of_block);
    EXPECT_EQ(outcome.smallest_pivot_row, outcome.failed_row);
    EXPECT_EQ(outcome.smallest_pivot_ratio, 0.0);
  }
}

TEST(BlockCholeskyTest, NamesARowOfASingularPair) {
  // Rows 3 and 4 are exactly dependent in small integers: the second pivot is an exact zero.
  const BlockSymmetricMatrix matrix =
      Chain({4.0, 9.0, 1.0, 4.0, 4.0, 25.0}, {0.0, 0.0, 0.0, 4.0, 0.0});
  const auto outcome = BlockCholesky(matrix).Factorize(matrix);
  EXPECT_FALSE(outcome.positive_definite);
  EXPECT_TRUE(outcome.failed_row == 3 || outcome.failed_row == 4) << outcome.failed_row;
}

TEST(BlockCholeskyTest, FloatingGroupShowsInThePivotsHoweverItRounds) {
  // A graph Laplacian: only differences are determined, so the last pivot is zero but for
  // rounding. It either fails or its ratio is some eps; it never passes as sound.
  std::mt19937_64 engine(28);
  BlockSymmetricMatrix matrix(std::vector<int>(40, 1), test::Grid(8, 5, 1, 1));
  for (int j = 0; j < matrix.block_count(); ++j) {
    for (const int i : matrix.RowsOfColumn(j)) {
      if (i != j) {
        const double weight = 0.1 + static_cast<double>(engine() % 1000) / 313.0;
        matrix.Block(i, j)(0, 0) -= weight;
        matrix.Block(i, i)(0, 0) += weight;
        matrix.Block(j, j)(0, 0) += weight;
      }
    }
  }
  const auto outcome = BlockCholesky(matrix).Factorize(matrix);
  EXPECT_LE(outcome.smallest_pivot_ratio, 1e-14);
  EXPECT_GE(outcome.smallest_pivot_row, 0);
  EXPECT_EQ(outcome.positive_definite, outcome.failed_row < 0);
}

TEST(BlockCholeskyTest, RefusesNotANumberAndRecoversAfterwards) {
  BlockSymmetricMatrix matrix = RandomGrid(29);
  BlockCholesky cholesky(matrix);
  const double kept = matrix.Block(11, 11)(0, 0);
  matrix.Block(11, 11)(0, 0) = std::numeric_limits<double>::quiet_NaN();
  const auto outcome = cholesky.Factorize(matrix);
  EXPECT_FALSE(outcome.positive_definite);
  EXPECT_EQ(outcome.failed_row, matrix.offset(11));
  matrix.Block(11, 11)(0, 0) = kept;
  EXPECT_TRUE(cholesky.Factorize(matrix).positive_definite);
}

TEST(BlockCholeskyTest, RepeatsBitByBit) {
  const BlockSymmetricMatrix matrix = RandomGrid(31);
  MatrixXd solved[2];
  BlockSymmetricMatrix inverse[2];
  for (int k = 0; k < 2; ++k) {
    BlockCholesky cholesky(matrix);
    ASSERT_TRUE(cholesky.Factorize(matrix).positive_definite);
    solved[k] = RandomColumns(matrix.rows(), 3, 32);
    cholesky.Solve(solved[k]);
    inverse[k] = cholesky.SelectedInverse();
  }
  EXPECT_EQ(solved[0], solved[1]);
  ASSERT_EQ(inverse[0].values().size(), inverse[1].values().size());
  EXPECT_EQ(
      std::memcmp(
          inverse[0].values().data(), inverse[1].values().data(), inverse[0].values().size_bytes()),
      0);
}

/// A chain of wide blocks: fronts of several tiles.
BlockSymmetricMatrix WideFronts(unsigned seed) {
  std::mt19937_64 engine(seed);
  return test::RandomPositive({310, 420, 280, 7}, test::Band(4, 1), 1.0, engine);
}

// Invariance: nothing depends on how many threads there are, on a tree of many fronts and on
// fronts that are cut into tiles.
TEST(BlockCholeskyTest, GivesTheSameBytesOnAnyNumberOfThreads) {
  for (const BlockSymmetricMatrix& matrix : {RandomGrid(35), WideFronts(36)}) {
    std::vector<MatrixXd> solved;
    std::vector<BlockSymmetricMatrix> inverses;
    std::vector<BlockCholesky::Outcome> outcomes;
    for (const int threads : {1, 2, 3}) {
      const ThreadLimit limit(threads);
      BlockCholesky cholesky(matrix);
      outcomes.push_back(cholesky.Factorize(matrix));
      ASSERT_TRUE(outcomes.back().positive_definite);
      solved.push_back(RandomColumns(matrix.rows(), 2, 37));
      cholesky.Solve(solved.back());
      inverses.push_back(cholesky.SelectedInverse());
    }
    for (const std::size_t k : {std::size_t{1}, std::size_t{2}}) {
      EXPECT_EQ(solved[0], solved[k]);
      EXPECT_EQ(std::memcmp(inverses[0].values().data(),
                            inverses[k].values().data(),
                            inverses[0].values().size_bytes()),
                0);
      EXPECT_EQ(outcomes[0].smallest_pivot_ratio, outcomes[k].smallest_pivot_ratio);
      EXPECT_EQ(outcomes[0].smallest_pivot_row, outcomes[k].smallest_pivot_row);
    }
  }
}

// Of several branches that fail at once the first in the order of elimination is named.
TEST(BlockCholeskyTest, NamesTheSameFailureOnAnyNumberOfThreads) {
  BlockSymmetricMatrix matrix = RandomGrid(38);
  for (const int block : {3, 17, 29, 40}) matrix.Block(block, block)(0, 0) = -1.0;
  std::vector<int> rows;
  for (const int threads : {1, 2, 3}) {
    const ThreadLimit limit(threads);
    for (int repeat = 0; repeat < 20; ++repeat) {
      BlockCholesky cholesky(matrix);
      const BlockCholesky::Outcome outcome = cholesky.Factorize(matrix);
      EXPECT_FALSE(outcome.positive_definite);
      rows.push_back(outcome.failed_row);
    }
  }
  EXPECT_EQ(std::count(rows.begin(), rows.end(), rows.front()),
            static_cast<std::ptrdiff_t>(rows.size()));
}

TEST(BlockCholeskyTest, FactorsFrontsOfSeveralTiles) {  // residual in the original equations
  const BlockSymmetricMatrix matrix = WideFronts(39);
  BlockCholesky cholesky(matrix);
  ASSERT_TRUE(cholesky.Factorize(matrix).positive_definite);
  const MatrixXd b = RandomColumns(matrix.rows(), 2, 40);
  MatrixXd x = b;
  cholesky.Solve(x);
  EXPECT_LE((matrix.ToDense() * x - b).norm(), 1e-10);
}

TEST(BlockCholeskyTest, OneAnalysisServesManyMatrices) {
  const BlockSymmetricMatrix first = RandomGrid(33);
  BlockSymmetricMatrix second = first;
  for (double& value : second.values()) {
    value *= 2.5;
  }
  BlockCholesky cholesky(first);
  ASSERT_TRUE(cholesky.Factorize(first).positive_definite);
  ASSERT_TRUE(cholesky.Factorize(second).positive_definite);
  const BlockCholesky moved = std::move(cholesky);
  const MatrixXd b = RandomColumns(first.rows(), 1, 34);
  MatrixXd x = b;
  moved.Solve(x);
  EXPECT_LE((second.ToDense() * x - b).norm(), 1e-11);  // norm(S) norm(x) is below 1e4
}

TEST(BlockCholeskyTest, KeepsTheFillOfABorderedChainLinear) {
  // A chain seen by one shared block last: every front is 3 blocks, whatever the length. In any
  // order that eliminates the shared block early the factor is dense (800 blocks: 320,000).
  const int count = 800;
  test::Pairs pairs = test::Band(count, 1);
  const test::Pairs star = test::Star(count, 5);
  pairs.insert(pairs.end(), star.begin(), star.end());
  const BlockSymmetricMatrix matrix(std::vector<int>(static_cast<std::size_t>(count), 1), pairs);
  const std::vector<int> last = {5};
  EXPECT_LE(BlockCholesky(matrix, last).factor_entries(), 20u * static_cast<unsigned>(count));
}

TEST(BlockCholeskyTest, AnEmptyMatrixIsPositiveDefinite) {
  const BlockSymmetricMatrix matrix;
  BlockCholesky cholesky(matrix);
  EXPECT_TRUE(cholesky.Factorize(matrix).positive_definite);
  EXPECT_EQ(cholesky.SelectedInverse().rows(), 0);
}

TEST(BlockCholeskyDeathTest, RefusesAnotherPattern) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  BlockCholesky cholesky(BlockSymmetricMatrix({1, 1, 1}, {{0, 1}}));
  const BlockSymmetricMatrix other({1, 1, 1}, {{0, 2}});  // as many values
  EXPECT_DEATH((void)cholesky.Factorize(other), "another pattern");
}

TEST(BlockCholeskyDeathTest, RefusesToSolveWithoutAFactor) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const BlockSymmetricMatrix matrix = Chain({1.0, -1.0}, {0.0});
  BlockCholesky cholesky(matrix);
  ASSERT_FALSE(cholesky.Factorize(matrix).positive_definite);
  EXPECT_DEATH((void)cholesky.SelectedInverse(), "has not been factored");
}

}  // namespace
}  // namespace sarblock
