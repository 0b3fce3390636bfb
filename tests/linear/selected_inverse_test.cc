// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "linear/block_cholesky.h"
#include "linear/dense.h"
#include "random_block_matrix.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::MatrixXd;

/// Largest difference between the selected inverse and the dense inverse on the pattern, relative
/// to the geometric mean of the two diagonal elements (the correlation scale). Second route:
/// Eigen's dense Cholesky, no ordering, no fronts.
double LargestDifference(const BlockSymmetricMatrix& matrix, std::span<const int> last = {}) {
  BlockCholesky cholesky(matrix, last);
  EXPECT_TRUE(cholesky.Factorize(matrix).positive_definite);
  const BlockSymmetricMatrix selected = cholesky.SelectedInverse();
  EXPECT_EQ(selected.pattern(), matrix.pattern());
  const MatrixXd dense = matrix.ToDense();
  const MatrixXd inverse = dense::Cholesky(dense).Inverse();
  double largest = 0.0;
  for (int j = 0; j < matrix.block_count(); ++j) {
    for (const int i : matrix.RowsOfColumn(j)) {
      for (int c = 0; c < matrix.size(j); ++c) {
        for (int r = 0; r < matrix.size(i); ++r) {
          const int row = matrix.offset(i) + r, column = matrix.offset(j) + c;
          const double scale = std::sqrt(inverse(row, row) * inverse(column, column));
          const double difference = selected.Block(i, j)(r, c) - inverse(row, column);
          largest = std::max(largest, std::abs(difference) / scale);
          if (!std::isfinite(difference)) {
            return difference;
          }
        }
      }
    }
  }
  return largest;
}

// Condition numbers of the matrices below are about 1e3; n * cond * 1e-16 leaves 1e-12.
constexpr double kTolerance = 1e-12;

TEST(SelectedInverseTest, EqualsHandComputedTwoByTwo) {  // [4 2; 2 3]^-1 = [3 -2; -2 4] / 8
  BlockSymmetricMatrix matrix({1, 1}, {{0, 1}});
  matrix.Block(0, 0)(0, 0) = 4.0;
  matrix.Block(1, 0)(0, 0) = 2.0;
  matrix.Block(1, 1)(0, 0) = 3.0;
  BlockCholesky cholesky(matrix);
  ASSERT_TRUE(cholesky.Factorize(matrix).positive_definite);
  const BlockSymmetricMatrix inverse = cholesky.SelectedInverse();
  EXPECT_NEAR(inverse.Block(0, 0)(0, 0), 0.375, 1e-15);
  EXPECT_NEAR(inverse.Block(1, 0)(0, 0), -0.25, 1e-15);
  EXPECT_NEAR(inverse.Block(1, 1)(0, 0), 0.5, 1e-15);
}

TEST(SelectedInverseTest, OneBlockIsTheDenseInverse) {
  std::mt19937_64 engine(11);
  EXPECT_LE(LargestDifference(test::RandomPositive({17}, {}, 0.7, engine)), kTolerance);
  EXPECT_LE(LargestDifference(test::RandomPositive({1}, {}, 0.7, engine)), kTolerance);
}

TEST(SelectedInverseTest, EqualsTheDenseInverseOnBandedBlocks) {
  std::mt19937_64 engine(12);
  for (const int width : {1, 2, 5}) {
    const auto matrix =
        test::RandomPositive(test::RandomSizes(33, 24, engine), test::Band(33, width), 0.9, engine);
    EXPECT_LE(LargestDifference(matrix), kTolerance) << width;
  }
}

TEST(SelectedInverseTest, EqualsTheDenseInverseOnAGridWithFill) {
  std::mt19937_64 engine(13);
  const auto matrix = test::RandomPositive(
      test::RandomSizes(9 * 8 * 2, 7, engine), test::Grid(9, 8, 2, 1), 0.9, engine);
  const BlockCholesky cholesky(matrix);
  EXPECT_GT(cholesky.factor_entries(), matrix.values().size()) << "the case must have fill";
  EXPECT_LE(LargestDifference(matrix), kTolerance);
}

TEST(SelectedInverseTest, EqualsTheDenseInverseWithSharedBlocksLast) {
  std::mt19937_64 engine(14);
  test::Pairs pairs = test::Grid(6, 7, 1, 1);  // blocks 0..41
  for (const int shared : {3, 42}) {
    const test::Pairs star = test::Star(43, shared);
    pairs.insert(pairs.end(), star.begin(), star.end());
  }
  const auto matrix = test::RandomPositive(test::RandomSizes(43, 9, engine), pairs, 0.9, engine);
  const std::vector<int> last = {42, 3, 42};
  EXPECT_LE(LargestDifference(matrix, last), kTolerance);
  EXPECT_LE(LargestDifference(matrix), kTolerance);
}

TEST(SelectedInverseTest, EqualsTheDenseInverseOfADenseMatrix) {
  std::mt19937_64 engine(15);
  const auto matrix =
      test::RandomPositive(test::RandomSizes(14, 24, engine), test::Band(14, 13), 0.9, engine);
  EXPECT_LE(LargestDifference(matrix), kTolerance);
}

TEST(SelectedInverseTest, EqualsTheDenseInverseBelowAWideSupernode) {
  // Two cliques of 9 blocks hang on one of 5: a supernode of 9 x 24 rows with rows below it.
  std::mt19937_64 engine(18);
  test::Pairs pairs;
  for (const int begin : {0, 9}) {
    for (int a = 0; a < 14; ++a) {
      for (int b = 0; b < a; ++b) {
        pairs.emplace_back(a < 9 ? begin + a : 9 + a, b < 9 ? begin + b : 9 + b);
      }
    }
  }
  std::vector<int> sizes(23, 24);
  std::fill(sizes.begin() + 18, sizes.end(), 11);
  const auto matrix = test::RandomPositive(sizes, pairs, 0.9, engine);
  EXPECT_LE(LargestDifference(matrix), kTolerance);
}

TEST(SelectedInverseTest, EqualsTheDenseInverseOnFrontsOfSeveralTiles) {
  std::mt19937_64 engine(19);
  const auto matrix = test::RandomPositive({310, 420, 280}, test::Band(3, 1), 0.9, engine);
  EXPECT_LE(LargestDifference(matrix), kTolerance);
}

TEST(SelectedInverseTest, HandlesDisconnectedPartsAndEmptyBlocks) {
  std::mt19937_64 engine(16);
  test::Pairs pairs = {{0, 1}, {1, 2}, {3, 5}, {5, 6}, {3, 6}, {8, 9}};  // 4 and 7 stand alone
  const auto matrix = test::RandomPositive({5, 0, 3, 2, 4, 1, 24, 6, 0, 0}, pairs, 0.9, engine);
  EXPECT_LE(LargestDifference(matrix), kTolerance);
}

TEST(SelectedInverseTest, KeepsItsDigitsUnderBadScaling) {
  // S -> D S D with powers of two changes no digit of a Cholesky factor, so metres beside
  // radians must cost nothing. Invariance, checked through the dense inverse.
  std::mt19937_64 engine(17);
  auto matrix =
      test::RandomPositive(test::RandomSizes(25, 6, engine), test::Grid(5, 5, 1, 1), 0.9, engine);
  std::vector<double> scale(static_cast<std::size_t>(matrix.rows()));
  for (double& s : scale) {
    s = std::ldexp(1.0, static_cast<int>(engine() % 60) - 30);
  }
  for (int j = 0; j < matrix.block_count(); ++j) {
    for (const int i : matrix.RowsOfColumn(j)) {
      for (int c = 0; c < matrix.size(j); ++c) {
        for (int r = 0; r < matrix.size(i); ++r) {
          matrix.Block(i, j)(r, c) *= scale[static_cast<std::size_t>(matrix.offset(i) + r)] *
                                      scale[static_cast<std::size_t>(matrix.offset(j) + c)];
        }
      }
    }
  }
  EXPECT_LE(LargestDifference(matrix), kTolerance);
}

TEST(SelectedInverseTest, EqualsTheDenseInverseOnHundredsOfRandomPatterns) {  // property
  for (unsigned seed = 0; seed < 300; ++seed) {
    std::mt19937_64 engine(seed);
    const int count = 1 + static_cast<int>(engine() % 30);
    const int edges = static_cast<int>(engine() % (3 * static_cast<unsigned>(count)));
    const auto matrix =
        test::RandomPositive(test::RandomSizes(count, seed % 2 == 0 ? 3 : 24, engine),
                             test::RandomPairs(count, edges, engine),
                             1.1,
                             engine);
    std::vector<int> last;
    for (unsigned k = 0; k < seed % 4; ++k) {
      last.push_back(static_cast<int>(engine() % static_cast<unsigned>(count)));
    }
    ASSERT_LE(LargestDifference(matrix, last), kTolerance) << "seed " << seed;
  }
}

}  // namespace
}  // namespace sarblock
