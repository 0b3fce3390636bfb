// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "linear/dense.h"
#include "linear/random_block_matrix.h"
#include "solve/rank.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A grid matrix in which some blocks stand for themselves, each with the eigenvalues 1, ..., 1 and
/// one of `least`.
BlockSymmetricMatrix WithWeakBlocks(unsigned seed, const std::vector<double>& least) {
  std::mt19937_64 engine(seed);
  BlockSymmetricMatrix matrix = test::RandomPositive(
      test::RandomSizes(5 * 4, 6, engine), test::Grid(5, 4, 1, 1), 0.6, engine);
  for (std::size_t k = 0; k < least.size(); ++k) {
    const int b = static_cast<int>(3 * k + 1);
    for (int j = 0; j < matrix.block_count(); ++j) {
      for (const int i : matrix.RowsOfColumn(j)) {
        if ((i == b) != (j == b)) matrix.Block(i, j).setZero();
      }
    }
    const int size = matrix.size(b);
    const VectorXd u = VectorXd::LinSpaced(size, 0.7, 1.9).normalized();
    matrix.Block(b, b) = MatrixXd::Identity(size, size) + (least[k] - 1.0) * u * u.transpose();
  }
  return matrix;
}

// Second route: dense eigenvalues of the same matrix.
TEST(LeastEigenpairsTest, AgreeWithADenseDecomposition) {
  for (const unsigned seed : {3U, 4U, 5U}) {
    const BlockSymmetricMatrix matrix = WithWeakBlocks(seed, {3.1e-7, 2.3e-5, 4.7e-4});
    BorderedCholesky factor(matrix);
    ASSERT_TRUE(factor.Factorize(matrix));
    LeastEigenpairOptions options;
    options.settle_below = 1e-3;
    options.relative_change = 1e-6;
    const LeastEigenpairs pairs = FindLeastEigenpairs(matrix, factor, options);
    const MatrixXd dense = matrix.ToDense();
    const dense::Eigenpairs eigen = dense::SymmetricEigenpairs(dense);
    ASSERT_EQ(pairs.values.size(), 6);
    for (Eigen::Index k = 0; k < 3; ++k) {
      // Rayleigh quotients round at 1e-16 of the largest eigenvalue.
      EXPECT_NEAR(pairs.values[k], eigen.values[k], 1e-14 + 1e-5 * eigen.values[k]);
      EXPECT_NEAR(std::abs(pairs.vectors.col(k).dot(eigen.vectors.col(k))), 1.0, 1e-6);
    }
    EXPECT_LE(LargestEigenvalue(matrix), eigen.values.maxCoeff() * (1.0 + 1e-12));
    EXPECT_GE(LargestEigenvalue(matrix), eigen.values.maxCoeff() * 0.9);
  }
}

// Known null space, two-dimensional, found on the factor of the lifted matrix.
TEST(LeastEigenpairsTest, FindTheWholeNullSpaceOfALiftedMatrix) {
  const BlockSymmetricMatrix matrix = WithWeakBlocks(7, {0.0, 0.0, 0.3});
  BlockSymmetricMatrix lifted = matrix;
  for (int b = 0; b < lifted.block_count(); ++b) lifted.Block(b, b).diagonal().array() += 1e-9;
  BorderedCholesky factor(lifted);
  ASSERT_TRUE(factor.Factorize(lifted));
  const LeastEigenpairs pairs = FindLeastEigenpairs(matrix, factor);
  EXPECT_LT(std::abs(pairs.values[0]), 1e-15);
  EXPECT_LT(std::abs(pairs.values[1]), 1e-15);
  EXPECT_GT(pairs.values[2], 1e-3);
  const MatrixXd null = pairs.vectors.leftCols(2);
  EXPECT_LT((matrix.ToDense() * null).norm(), 1e-8);
  EXPECT_LT((null.transpose() * null - MatrixXd::Identity(2, 2)).norm(), 1e-14);
}

TEST(LeastEigenpairsTest, AreAllOfThemForASmallMatrix) {  // hand values: 2 -+ 1
  BlockSymmetricMatrix matrix({1, 1}, {{1, 0}});
  matrix.Block(0, 0)(0, 0) = matrix.Block(1, 1)(0, 0) = 2.0;
  matrix.Block(1, 0)(0, 0) = -1.0;
  BorderedCholesky factor(matrix);
  ASSERT_TRUE(factor.Factorize(matrix));
  const LeastEigenpairs pairs = FindLeastEigenpairs(matrix, factor);
  ASSERT_EQ(pairs.values.size(), 2);
  EXPECT_NEAR(pairs.values[0], 1.0, 1e-14);
  EXPECT_NEAR(pairs.values[1], 3.0, 1e-14);
}

}  // namespace
}  // namespace sarblock
