// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <random>

#include "linear/block_cholesky.h"
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A chain of blocks, and a border that takes `part` of the smallest eigenvalue of it.
BorderedMatrix Chain(unsigned seed, double part) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  BlockSymmetricMatrix a({2, 3, 1, 4, 2}, {{1, 0}, {2, 1}, {3, 2}, {4, 3}});
  for (int j = 0; j < a.block_count(); ++j) {
    for (const int i : a.RowsOfColumn(j)) {
      a.Block(i, j) = MatrixXd::NullaryExpr(a.size(i), a.size(j), [&] { return normal(engine); });
      if (i == j) a.Block(j, j).diagonal().array() += 11.3;
    }
  }
  const MatrixXd dense = a.ToDense();
  const double least = Eigen::SelfAdjointEigenSolver<MatrixXd>(dense).eigenvalues().minCoeff();
  MatrixXd t = MatrixXd::NullaryExpr(3, a.rows(), [&] { return normal(engine); });
  t *= std::sqrt(part * least) / t.operatorNorm();
  return {std::move(a), std::move(t)};
}

// Second route: dense algebra.
TEST(BorderedMatrixTest, SolvesAndInvertsAsTheDenseMatrixDoes) {
  for (const unsigned seed : {3U, 17U, 91U}) {
    const BorderedMatrix matrix = Chain(seed, 0.93);
    const MatrixXd s = matrix.sparse.ToDense() - matrix.border.transpose() * matrix.border;
    const MatrixXd inverse = s.inverse();
    EXPECT_LT((matrix.ToDense() - s).norm(), 1e-14 * s.norm());
    EXPECT_LT((matrix.Diagonal() - s.diagonal()).norm(), 1e-14 * s.norm());
    const VectorXd x = VectorXd::LinSpaced(matrix.rows(), -0.7, 1.3);
    EXPECT_LT((matrix.Multiply(x) - s * x).norm(), 1e-13 * s.norm());

    BorderedCholesky factor(matrix.sparse);
    ASSERT_TRUE(factor.Factorize(matrix));
    MatrixXd columns(matrix.rows(), 2);
    columns << x, x.cwiseAbs2();
    const MatrixXd expected = inverse * columns;
    factor.Solve(columns);
    EXPECT_LT((columns - expected).norm(), 1e-12 * expected.norm());

    const BorderedInverse found = factor.SelectedInverse();
    const double size = inverse.norm();
    for (int j = 0; j < found.blocks.block_count(); ++j) {
      for (const int i : found.blocks.RowsOfColumn(j)) {
        const auto block = found.blocks.Block(i, j);
        const MatrixXd wanted = inverse.block(
            found.blocks.offset(i), found.blocks.offset(j), block.rows(), block.cols());
        EXPECT_LT((block - wanted).norm(), 1e-12 * size);
      }
    }
    EXPECT_LT((found.border - matrix.border * inverse).norm(), 1e-12 * size);
  }
}

TEST(BorderedMatrixTest, IsScaledFromBothSides) {
  const BorderedMatrix matrix = Chain(5, 0.5);
  const VectorXd d = VectorXd::LinSpaced(matrix.rows(), 0.3, 2.9);
  const MatrixXd expected = d.asDiagonal() * matrix.ToDense() * d.asDiagonal();
  EXPECT_LT((matrix.Scaled(d).ToDense() - expected).norm(), 1e-13 * expected.norm());
}

// A stays positive definite where S is not: the border alone can show it.
TEST(BorderedMatrixTest, RefusesABorderThatTakesMoreThanThereIs) {
  BlockSymmetricMatrix a({1, 1}, {});
  a.Block(0, 0)(0, 0) = 1.0;
  a.Block(1, 1)(0, 0) = 4.0;
  BorderedCholesky factor(a);
  EXPECT_TRUE(factor.Factorize({a, (MatrixXd(1, 2) << 0.99, 0.0).finished()}));
  EXPECT_FALSE(factor.Factorize({a, (MatrixXd(1, 2) << 1.01, 0.0).finished()}));
  EXPECT_FALSE(factor.Factorize({a, (MatrixXd(1, 2) << 0.8, 1.3).finished()}));  // 0.64 + 0.4225
}

TEST(BorderedMatrixTest, IsTheSparseMatrixWithoutABorder) {
  const BorderedMatrix matrix(Chain(7, 0.5).sparse);
  BorderedCholesky factor(matrix.sparse);
  ASSERT_TRUE(factor.Factorize(matrix));
  MatrixXd columns = MatrixXd::Identity(matrix.rows(), matrix.rows());
  factor.Solve(columns);
  EXPECT_LT(
      (columns * matrix.sparse.ToDense() - MatrixXd::Identity(matrix.rows(), matrix.rows())).norm(),
      1e-13);
  EXPECT_EQ(factor.SelectedInverse().border.rows(), 0);
}

}  // namespace
}  // namespace sarblock
