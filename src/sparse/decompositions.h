// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/QR>

namespace sarblock::dense {

// Eigen's decompositions of small dense matrices of any size, compiled once for all modules: each
// takes five to fifteen seconds in every source that calls Eigen's own. Of a symmetric matrix the
// lower triangle is read. Matrices of a size known when compiling are cheap and call Eigen.

/// A = V diag(values) V'.
struct Eigenpairs {
  Eigen::VectorXd values;   ///< ascending
  Eigen::MatrixXd vectors;  ///< columns of unit length
};
/// `a`: n x n, symmetric, n >= 1.
[[nodiscard]] Eigenpairs SymmetricEigenpairs(const Eigen::MatrixXd& a);
[[nodiscard]] Eigen::VectorXd SymmetricEigenvalues(const Eigen::MatrixXd& a);

/// A = L L', A n x n and symmetric.
class Cholesky {
 public:
  explicit Cholesky(const Eigen::MatrixXd& a);
  /// Nothing else may be asked where it is not.
  [[nodiscard]] bool positive_definite() const { return llt_.info() == Eigen::Success; }
  [[nodiscard]] Eigen::Index rows() const { return llt_.rows(); }
  [[nodiscard]] Eigen::MatrixXd L() const;
  /// Of A.
  [[nodiscard]] double LogDeterminant() const;
  /// A^-1 b
  [[nodiscard]] Eigen::MatrixXd Solve(const Eigen::MatrixXd& b) const;
  [[nodiscard]] Eigen::VectorXd Solve(const Eigen::VectorXd& b) const;
  [[nodiscard]] Eigen::MatrixXd Inverse() const;
  /// L^-1 b
  [[nodiscard]] Eigen::MatrixXd SolveLower(Eigen::MatrixXd b) const;
  [[nodiscard]] Eigen::VectorXd SolveLower(Eigen::VectorXd b) const;

 private:
  Eigen::LLT<Eigen::MatrixXd> llt_;
};

/// A = P' L D L' P, A n x n and symmetric, with P the order of its pivots.
class PivotedCholesky {
 public:
  explicit PivotedCholesky(const Eigen::MatrixXd& a);
  /// All pivots are numbers and the least one is above `least`.
  [[nodiscard]] bool PivotsAbove(double least) const;
  /// No pivot is below zero.
  [[nodiscard]] bool positive_semidefinite() const {
    return ldlt_.info() == Eigen::Success && ldlt_.isPositive();
  }
  /// A^-1 b
  [[nodiscard]] Eigen::MatrixXd Solve(const Eigen::MatrixXd& b) const;
  [[nodiscard]] Eigen::VectorXd Solve(const Eigen::VectorXd& b) const;

 private:
  Eigen::LDLT<Eigen::MatrixXd> ldlt_;
};

/// A = Q R, A m x n.
class Orthogonal {
 public:
  explicit Orthogonal(const Eigen::MatrixXd& a);
  /// The first columns of Q, m at most: n are a basis of A's columns, those after n of what they
  /// leave.
  [[nodiscard]] Eigen::MatrixXd Q(Eigen::Index columns) const;
  /// min(m, n) x n
  [[nodiscard]] Eigen::MatrixXd R() const;

 private:
  Eigen::HouseholderQR<Eigen::MatrixXd> qr_;
};

/// A P = Q R, A m x n: the columns in the order in which each is the longest of what those before
/// it leave.
class PivotedOrthogonal {
 public:
  explicit PivotedOrthogonal(const Eigen::MatrixXd& a);
  /// Columns count for the rank whose pivot is above `threshold` times the largest.
  PivotedOrthogonal(const Eigen::MatrixXd& a, double threshold);
  [[nodiscard]] Eigen::Index rank() const { return qr_.rank(); }
  /// The column of A that stands k-th.
  [[nodiscard]] int Column(Eigen::Index k) const { return qr_.colsPermutation().indices()[k]; }
  /// An orthonormal basis of the columns of A, m x rank.
  [[nodiscard]] Eigen::MatrixXd Basis() const;
  /// Least squares: x of the least |A x - b| with zeros where the rank leaves a choice.
  [[nodiscard]] Eigen::MatrixXd Solve(const Eigen::MatrixXd& b) const;

 private:
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr_;
};

/// A = U diag(values) V', A m x n, with min(m, n) values.
struct SingularValues {
  Eigen::VectorXd values;  ///< descending
  Eigen::MatrixXd v;       ///< n x min(m, n)
};
[[nodiscard]] SingularValues DecomposeSingular(const Eigen::MatrixXd& a);

}  // namespace sarblock::dense
