// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/QR>

namespace sarblock::dense {

// The BLAS and LAPACK routines of the multifrontal factor: column-major, lower triangles, the
// leading dimension right behind each matrix. An empty operand is a valid no-operation.

/// Restricts a threaded OpenBLAS, if that is the BLAS loaded, to one thread for the whole process.
/// Its threads make small fronts slower and let the summation order depend on their number.
void UseOneBlasThread();

/// For a process that uses BLAS for other work as well: while one of these lives BLAS may be
/// restricted, and when the last of them ends it has as many threads as when the first began.
class BlasThreadsKept {
 public:
  BlasThreadsKept();
  ~BlasThreadsKept();
  BlasThreadsKept(const BlasThreadsKept&) = delete;
  BlasThreadsKept& operator=(const BlasThreadsKept&) = delete;
};

/// a = L L', n x n. Returns the number of the first pivot that is not positive, from 1; 0 if none.
[[nodiscard]] int Factor(int n, double* a, int lda);
/// a = (L L')^-1 from L in the lower triangle of a.
void InvertFromFactor(int n, double* a, int lda);
/// b = b L'^-1, b m x n.
void SolveRightTransposed(int m, int n, const double* l, int ldl, double* b, int ldb);
/// b = b L^-1, b m x n.
void SolveRight(int m, int n, const double* l, int ldl, double* b, int ldb);
/// b = L^-1 b, b n x columns.
void SolveLeft(int n, int columns, const double* l, int ldl, double* b, int ldb);
/// b = L'^-1 b, b n x columns.
void SolveLeftTransposed(int n, int columns, const double* l, int ldl, double* b, int ldb);
/// Lower triangle of c -= a a', a n x k.
void SubtractSquare(int n, int k, const double* a, int lda, double* c, int ldc);
/// c -= a b', a m x k, b n x k.
void SubtractProductTransposed(
    int m, int n, int k, const double* a, int lda, const double* b, int ldb, double* c, int ldc);
/// c -= a b, a m x k, b k x n.
void SubtractProduct(
    int m, int n, int k, const double* a, int lda, const double* b, int ldb, double* c, int ldc);
/// c = -s b with s symmetric m x m, b m x n.
void NegativeSymmetricProduct(
    int m, int n, const double* s, int lds, const double* b, int ldb, double* c, int ldc);
/// c -= a' b, a k x m, b k x n.
void SubtractTransposedProduct(
    int m, int n, int k, const double* a, int lda, const double* b, int ldb, double* c, int ldc);
/// c = a b, a m x k, b k x n.
void Product(
    int m, int n, int k, const double* a, int lda, const double* b, int ldb, double* c, int ldc);

// Eigen's decompositions of small dense matrices, compiled once for all modules: each takes three
// to fifteen seconds in every source that calls Eigen's own, also for 2 x 2 and 3 x 3. Exceptions
// are inverses up to 3 x 3 and eigenpairs of 3 x 3. The lower triangle of a symmetric matrix is
// read.

/// L of A = L L', A 3 x 3 and symmetric; none where A is not positive definite.
[[nodiscard]] std::optional<Eigen::Matrix3d> LowerFactor(const Eigen::Matrix3d& a);
/// x' A^-1 x, A 3 x 3, symmetric and positive semidefinite.
[[nodiscard]] double InverseForm(const Eigen::Matrix3d& a, const Eigen::Vector3d& x);

/// A = sum_k sign_k g_k g_k', A n x n and symmetric, with at most n terms: elimination with
/// complete pivoting (Bunch and Parlett (1971), SIAM J. Numer. Anal. 8(4), 639-655), a 2 x 2 pivot
/// as the two terms along its axes. `a`: n x n by columns, destroyed. g_k: columns of `g`, n x n.
/// Returns how many terms there are; what is below rounding of A's largest element makes none.
[[nodiscard]] int SignedSquares(int n, double* a, double* g, double* sign);

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
  /// If false, no other function may be called.
  [[nodiscard]] bool positive_definite() const { return llt_.info() == Eigen::Success; }
  [[nodiscard]] Eigen::Index rows() const { return llt_.rows(); }
  [[nodiscard]] Eigen::MatrixXd L() const;
  /// ln det A
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
  /// The first columns of Q, m at most: the first n are a basis of A's columns, the rest of their
  /// orthogonal complement.
  [[nodiscard]] Eigen::MatrixXd Q(Eigen::Index columns) const;
  /// min(m, n) x n
  [[nodiscard]] Eigen::MatrixXd R() const;

 private:
  Eigen::HouseholderQR<Eigen::MatrixXd> qr_;
};

/// A P = Q R, A m x n. P orders the columns: next comes always the one with the longest part
/// orthogonal to those before it.
class PivotedOrthogonal {
 public:
  explicit PivotedOrthogonal(const Eigen::MatrixXd& a);
  /// Columns count for the rank whose pivot is above `threshold` times the largest.
  PivotedOrthogonal(const Eigen::MatrixXd& a, double threshold);
  [[nodiscard]] Eigen::Index rank() const { return qr_.rank(); }
  /// The column of A at place k.
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

namespace sarblock::sparse {

/// Memory of fronts that come and go on several threads: places in one range of addresses, the
/// lowest that fits, so that touched pages are used again. New pages cost more than the
/// arithmetic of a front of a few hundred rows. Takes as many pages as are in use at once plus
/// the gaps between them; returned with the object.
class FrontMemory {
 public:
  /// `most` doubles over all calls of Take, each rounded up to kGrain. Only addresses are reserved;
  /// where that is little, or the system refuses even those, every place is allocated separately.
  explicit FrontMemory(std::size_t most);
  ~FrontMemory();
  FrontMemory(const FrontMemory&) = delete;
  FrontMemory& operator=(const FrontMemory&) = delete;

  class Return {
   public:
    Return() = default;
    Return(FrontMemory* memory, std::size_t count) : memory_(memory), count_(count) {}
    void operator()(double* place) const { memory_->Give(place, count_); }

   private:
    FrontMemory* memory_ = nullptr;
    std::size_t count_ = 0;
  };
  using Place = std::unique_ptr<double[], Return>;
  /// Uninitialised; goes back when the pointer dies, which must be before this object. Throws
  /// std::bad_alloc.
  [[nodiscard]] Place Take(std::size_t count);

  /// Doubles that were taken at once, at most so far.
  [[nodiscard]] std::size_t most_taken() const;

  static constexpr std::size_t kGrain = 8;  ///< doubles in a cache line
  [[nodiscard]] static std::size_t Rounded(std::size_t count) {
    return (count / kGrain + 1) * kGrain;
  }

 private:
  void Give(double* place, std::size_t count);

  std::size_t most_;
  double* begin_ = nullptr;
  mutable std::mutex mutex_;
  std::size_t taken_ = 0, most_taken_ = 0;
  std::map<std::size_t, std::size_t> free_;  // offset, length of what is free
};

}  // namespace sarblock::sparse
