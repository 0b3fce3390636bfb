// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "linear/block_cholesky.h"
#include "linear/dense.h"
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
  const double least = dense::SymmetricEigenvalues(dense).minCoeff();
  MatrixXd t = MatrixXd::NullaryExpr(3, a.rows(), [&] { return normal(engine); });
  t *= std::sqrt(part * least) /
       std::sqrt(dense::SymmetricEigenvalues(t * t.transpose()).maxCoeff());
  return {std::move(a), std::move(t)};
}

void ExpectBlocksOf(const MatrixXd& dense, const BlockSymmetricMatrix& blocks, double bound) {
  for (int j = 0; j < blocks.block_count(); ++j) {
    for (const int i : blocks.RowsOfColumn(j)) {
      const auto block = blocks.Block(i, j);
      const MatrixXd wanted =
          dense.block(blocks.offset(i), blocks.offset(j), block.rows(), block.cols());
      EXPECT_LT((block - wanted).norm(), bound);
    }
  }
}

// Second route: dense algebra.
TEST(BorderedMatrixTest, SolvesAndInvertsAsTheDenseMatrixDoes) {
  for (const unsigned seed : {3U, 17U, 91U}) {
    const BorderedMatrix matrix = Chain(seed, 0.93);
    const MatrixXd t = matrix.border.ToDense();
    const MatrixXd s = matrix.sparse.ToDense() - t.transpose() * t;
    const MatrixXd inverse = dense::Cholesky(s).Inverse();
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
    ExpectBlocksOf(inverse, found.blocks, 1e-12 * size);
    EXPECT_LT((found.border.ToDense() - t * inverse).norm(), 1e-12 * size);
  }
}

TEST(BorderedMatrixTest, IsScaledFromBothSides) {
  const BorderedMatrix matrix = Chain(5, 0.5);
  const VectorXd d = VectorXd::LinSpaced(matrix.rows(), 0.3, 2.9);
  const MatrixXd expected = d.asDiagonal() * matrix.ToDense() * d.asDiagonal();
  EXPECT_LT((matrix.Scaled(d).ToDense() - expected).norm(), 1e-13 * expected.norm());
}

/// Blocks that nothing joins but 1 and 2, 4 and 5; each such group has values in a few of five
/// terms, one in none.
BorderedMatrix Scattered(unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(engine); };
  BlockSymmetricMatrix a({3, 2, 1, 2, 1, 4}, {{1, 2}, {5, 4}});
  for (int j = 0; j < a.block_count(); ++j) {
    for (const int i : a.RowsOfColumn(j)) {
      a.Block(i, j) = MatrixXd::NullaryExpr(a.size(i), a.size(j), draw);
      if (i == j) a.Block(j, j).diagonal().array() += 9.7;
    }
  }
  const std::vector<std::pair<int, int>> places{
      {1, 0}, {3, 0}, {0, 1}, {1, 2}, {2, 2}, {4, 5}, {3, 4}, {4, 4}};
  Border t(std::make_shared<const BorderPattern>(*a.pattern(), 5, places));
  for (const BorderPattern::Group& group : t.pattern().groups()) {
    t.Of(group) = 0.31 * MatrixXd::NullaryExpr(t.Of(group).rows(), t.Of(group).cols(), draw);
  }
  return {std::move(a), std::move(t)};
}

// Second route: dense algebra. T has values where a term and a group meet and nowhere else.
TEST(BorderedMatrixTest, SolvesGroupsThatNothingElseJoinsSideBySide) {
  const BorderedMatrix matrix = Scattered(41);
  const BorderPattern& pattern = matrix.border.pattern();
  EXPECT_EQ(pattern.groups().size(), 3U);
  EXPECT_EQ(pattern.value_count(), 2U * 3U + 3U * 3U + 2U * 5U);
  EXPECT_EQ(pattern.MaxTerms(), 3);
  const MatrixXd t = matrix.border.ToDense();
  EXPECT_TRUE(t.middleCols(6, 2).isZero(0.0));  // block 3 is in no group
  EXPECT_EQ(t(2, 3), *matrix.border.At(2, 3));
  const MatrixXd s = matrix.sparse.ToDense() - t.transpose() * t;
  const MatrixXd inverse = dense::Cholesky(s).Inverse();
  BorderedCholesky factor(matrix.sparse);
  ASSERT_TRUE(factor.Factorize(matrix));
  MatrixXd columns = MatrixXd::Identity(s.rows(), s.cols());
  factor.Solve(columns);
  EXPECT_LT((columns - inverse).norm(), 1e-13);
  EXPECT_LT((matrix.Multiply(inverse.col(4)) - s * inverse.col(4)).norm(), 1e-14);
  EXPECT_LT((matrix.Diagonal() - s.diagonal()).norm(), 1e-14);
  const BorderedInverse found = factor.SelectedInverse();
  ExpectBlocksOf(inverse, found.blocks, 1e-13);
  const MatrixXd of_border = t * inverse;
  for (Eigen::Index column = 0; column < t.cols(); ++column) {
    for (Eigen::Index term = 0; term < t.rows(); ++term) {
      if (t(term, column) == 0.0) continue;
      EXPECT_NEAR(*found.border.At(static_cast<int>(term), static_cast<int>(column)),
                  of_border(term, column),
                  1e-14);
    }
  }
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
  EXPECT_EQ(factor.SelectedInverse().border.terms(), 0);
}

}  // namespace
}  // namespace sarblock
