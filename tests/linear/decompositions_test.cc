// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include "linear/dense.h"
#include <Eigen/Core>
#include <gtest/gtest.h>

namespace sarblock::dense {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The second difference of n values with fixed ends: its eigenvalues are
/// 2 - 2 cos(k pi / (n + 1)), k = 1 ... n, its determinant is n + 1.
MatrixXd SecondDifference(Index n) {
  MatrixXd a = 2.0 * MatrixXd::Identity(n, n);
  for (Index i = 1; i < n; ++i) a(i, i - 1) = a(i - 1, i) = -1.0;
  return a;
}

TEST(DecompositionsTest, EigenvaluesOfASecondDifferenceAreThoseOfItsFormula) {
  const Index n = 9;
  const MatrixXd a = SecondDifference(n);
  const Eigenpairs pairs = SymmetricEigenpairs(a);
  const VectorXd values = SymmetricEigenvalues(a);
  for (Index k = 0; k < n; ++k) {
    const double expected = 2.0 - 2.0 * std::cos(static_cast<double>(k + 1) * std::numbers::pi /
                                                 static_cast<double>(n + 1));
    EXPECT_NEAR(pairs.values[k], expected, 1e-14);
    EXPECT_NEAR(values[k], expected, 1e-14);
  }
  EXPECT_LT((a * pairs.vectors - pairs.vectors * pairs.values.asDiagonal()).norm(), 1e-13);
  EXPECT_LT((pairs.vectors.transpose() * pairs.vectors - MatrixXd::Identity(n, n)).norm(), 1e-13);
}

struct SplitMatrix {
  Index terms = 0, negative = 0;
  double left = 0.0;  ///< of A less its terms, relative to A's largest element
};

SplitMatrix Split(const MatrixXd& a) {
  const Index n = a.rows();
  MatrixXd destroyed = a, g(n, n);
  VectorXd sign(n);
  SplitMatrix split;
  split.terms = SignedSquares(static_cast<int>(n), destroyed.data(), g.data(), sign.data());
  split.negative = (sign.head(split.terms).array() < 0.0).count();
  MatrixXd left = a;
  for (Index k = 0; k < split.terms; ++k) left -= sign[k] * g.col(k) * g.col(k).transpose();
  split.left = left.cwiseAbs().maxCoeff() / a.cwiseAbs().maxCoeff();
  return split;
}

TEST(DecompositionsTest, SignedSquaresAddUpToTheMatrix) {
  std::mt19937 bits(1);
  std::normal_distribution<double> normal;
  for (Index n = 2; n <= 9; ++n) {
    for (int draw = 0; draw < 200; ++draw) {
      SCOPED_TRACE(std::to_string(n) + ", draw " + std::to_string(draw));
      // An indefinite matrix, its diagonal small or zero in two of three: pivots of both sizes.
      MatrixXd a = MatrixXd::NullaryExpr(n, n, [&] { return normal(bits); });
      a += a.transpose().eval();
      a.diagonal() *= draw % 3 == 0 ? 1.0 : draw % 3 == 1 ? 1e-3 : 0.0;
      // Rows of different units.
      VectorXd unit(n);
      for (Index i = 0; i < n; ++i) unit[i] = i % 3 == 0 ? 1.0 : 1e4;
      if (draw % 2 == 0) a = unit.asDiagonal() * a * unit.asDiagonal();
      const SplitMatrix split = Split(a);
      EXPECT_LT(split.left, 1e-14);
      // As many terms of each sign as eigenvalues (Sylvester's law of inertia).
      EXPECT_EQ(split.terms, n);
      EXPECT_EQ(split.negative, (SymmetricEigenvalues(a).array() < 0.0).count());
    }
  }
}

TEST(DecompositionsTest, SignedSquaresAreAsManyAsTheRank) {
  const VectorXd u = VectorXd::LinSpaced(7, 1.0, 2.0), v = VectorXd::LinSpaced(7, 3.0, -1.0);
  const SplitMatrix one = Split(-u * u.transpose());
  EXPECT_EQ(one.terms, 1);
  EXPECT_EQ(one.negative, 1);
  EXPECT_LT(one.left, 1e-15);
  const SplitMatrix two = Split(u * v.transpose() + v * u.transpose());
  EXPECT_EQ(two.terms, 2);
  EXPECT_EQ(two.negative, 1);
  EXPECT_LT(two.left, 1e-14);
  EXPECT_EQ(Split(MatrixXd::Zero(7, 7)).terms, 0);
}

TEST(DecompositionsTest, OfASymmetricMatrixTheLowerTriangleIsRead) {
  const MatrixXd a = SecondDifference(4);
  MatrixXd lower = a;
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(
      std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(SymmetricEigenvalues(lower), SymmetricEigenvalues(a));
  EXPECT_EQ(Cholesky(lower).L(), Cholesky(a).L());
}

TEST(DecompositionsTest, ACholeskyFactorOfASecondDifference) {
  const Index n = 7;
  const MatrixXd a = SecondDifference(n);
  const Cholesky factor(a);
  ASSERT_TRUE(factor.positive_definite());
  EXPECT_LT((factor.L() * factor.L().transpose() - a).norm(), 1e-14);
  EXPECT_NEAR(factor.LogDeterminant(), std::log(static_cast<double>(n + 1)), 1e-14);
  const MatrixXd inverse = factor.Inverse();
  for (Index i = 0; i < n; ++i) {  // min(i, j) (n + 1 - max(i, j)) / (n + 1), counted from 1
    for (Index j = 0; j <= i; ++j) {
      EXPECT_NEAR(inverse(i, j), static_cast<double>((j + 1) * (n - i)) / (n + 1.0), 1e-14);
    }
  }
  const VectorXd b = VectorXd::LinSpaced(n, -1.0, 2.0);
  EXPECT_LT((a * factor.Solve(b) - b).norm(), 1e-14);
  EXPECT_LT((factor.L() * factor.SolveLower(b) - b).norm(), 1e-14);
  EXPECT_LT((factor.L() * factor.SolveLower(MatrixXd(a)) - a).norm(), 1e-14);
  EXPECT_FALSE(Cholesky(-a).positive_definite());
}

TEST(DecompositionsTest, PivotsTellASemidefiniteMatrixFromAnIndefiniteOne) {
  const MatrixXd a = SecondDifference(5);
  const PivotedCholesky factor(a);
  EXPECT_TRUE(factor.positive_semidefinite());
  EXPECT_TRUE(factor.PivotsAbove(1.0));
  EXPECT_FALSE(factor.PivotsAbove(2.0));  // the largest pivot
  const VectorXd b = VectorXd::LinSpaced(5, 0.0, 1.0);
  EXPECT_LT((a * factor.Solve(b) - b).norm(), 1e-14);
  EXPECT_LT((a * factor.Solve(MatrixXd(a)) - a).norm(), 1e-13);
  MatrixXd other = a;
  other(4, 4) = -1.0;
  EXPECT_FALSE(PivotedCholesky(other).positive_semidefinite());
}

TEST(DecompositionsTest, AnOrthogonalFactorAndWhatItsColumnsLeave) {
  MatrixXd a(4, 2);
  a << 1.0, 2.0, 1.0, -1.0, 1.0, 0.5, 1.0, 3.0;
  const Orthogonal qr(a);
  const MatrixXd q = qr.Q(4);
  EXPECT_LT((q.transpose() * q - MatrixXd::Identity(4, 4)).norm(), 1e-14);
  EXPECT_EQ(qr.Q(2), q.leftCols(2));
  EXPECT_LT((q.leftCols(2) * qr.R() - a).norm(), 1e-14);
  EXPECT_EQ(qr.R()(1, 0), 0.0);
  EXPECT_LT((a.transpose() * q.rightCols(2)).norm(), 1e-14);
}

TEST(DecompositionsTest, PivotsOfColumnsTellTheRank) {
  MatrixXd a(4, 3);  // the third is the sum of the others, the second the longest of the two
  a << 1.0, 2.0, 3.0, 0.0, 2.0, 2.0, 1.0, -2.0, -1.0, 0.0, 1.0, 1.0;
  const PivotedOrthogonal qr(a);
  EXPECT_EQ(qr.rank(), 2);
  EXPECT_EQ(qr.Column(0), 2);  // squares: 2, 13, 15
  const MatrixXd basis = qr.Basis();
  ASSERT_EQ(basis.cols(), 2);
  EXPECT_LT((basis * (basis.transpose() * a) - a).norm(), 1e-14);
  EXPECT_LT((a * qr.Solve(a) - a).norm(), 1e-14);
  MatrixXd near = a;
  near(3, 2) += 1e-7;
  EXPECT_EQ(PivotedOrthogonal(near).rank(), 3);
  EXPECT_EQ(PivotedOrthogonal(near, 1e-6).rank(), 2);
}

TEST(DecompositionsTest, SingularValuesAreRootsOfTheEigenvaluesOfTheSquare) {
  MatrixXd a(3, 2);  // A'A = [9 4; 4 9] has the eigenvalues 13 and 5
  a << 2.0, 2.0, 2.0, -1.0, 1.0, 2.0;
  const SingularValues svd = DecomposeSingular(a);
  ASSERT_EQ(svd.values.size(), 2);
  EXPECT_NEAR(svd.values[0] * svd.values[0], 13.0, 1e-13);
  EXPECT_NEAR(svd.values[1] * svd.values[1], 5.0, 1e-13);
  EXPECT_LT((a.transpose() * a * svd.v - svd.v * svd.values.cwiseAbs2().asDiagonal()).norm(),
            1e-13);
}

}  // namespace
}  // namespace sarblock::dense
