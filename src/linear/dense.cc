// SPDX-License-Identifier: Apache-2.0
#include "dense.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <mutex>
#include <new>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <cblas.h>
#include <dlfcn.h>
#include <glog/logging.h>
#include <sys/mman.h>

// Fortran symbols of LAPACK; the trailing size is the hidden length of the character argument.
extern "C" {
void dpotrf_(const char*, const int*, double*, const int*, int*, std::size_t);
void dpotri_(const char*, const int*, double*, const int*, int*, std::size_t);
}

namespace sarblock::dense {
namespace {

constexpr auto kLayout = CblasColMajor;

void TriangularSolve(CBLAS_SIDE side,
                     CBLAS_TRANSPOSE transposed,
                     int m,
                     int n,
                     const double* l,
                     int ldl,
                     double* b,
                     int ldb) {
  if (m > 0 && n > 0) {
    cblas_dtrsm(kLayout, side, CblasLower, transposed, CblasNonUnit, m, n, 1.0, l, ldl, b, ldb);
  }
}

void LeftSolve(
    CBLAS_TRANSPOSE transposed, int n, int columns, const double* l, int ldl, double* b, int ldb) {
  if (columns == 1 && n > 0) {  // dtrsm packs the triangle even for one column
    cblas_dtrsv(kLayout, CblasLower, transposed, CblasNonUnit, n, l, ldl, b, 1);
  } else {
    TriangularSolve(CblasLeft, transposed, n, columns, l, ldl, b, ldb);
  }
}

/// Looked up at run time: the installation chooses the BLAS of libblas.so.3.
struct BlasThreads {
  int (*get)() = nullptr;
  void (*set)(int) = nullptr;  ///< null: a BLAS whose threads cannot be set
};

const BlasThreads& BlasThreadsOfProcess() {
  static const BlasThreads blas = [] {
    void* const get = dlsym(RTLD_DEFAULT, "openblas_get_num_threads");
    void* const set = dlsym(RTLD_DEFAULT, "openblas_set_num_threads");
    if (get == nullptr || set == nullptr) {
      return BlasThreads{};
    }
    return BlasThreads{reinterpret_cast<int (*)()>(get), reinterpret_cast<void (*)(int)>(set)};
  }();
  return blas;
}

struct KeptBlasThreads {
  std::mutex mutex;
  int holders = 0;
  int threads = 0;
};
KeptBlasThreads g_kept;

}  // namespace

void UseOneBlasThread() {
  const BlasThreads& blas = BlasThreadsOfProcess();
  if (blas.set != nullptr && blas.get() != 1) {
    blas.set(1);
  }
}

BlasThreadsKept::BlasThreadsKept() {
  const BlasThreads& blas = BlasThreadsOfProcess();
  const std::lock_guard lock(g_kept.mutex);
  if (g_kept.holders++ == 0 && blas.set != nullptr) {
    g_kept.threads = blas.get();
  }
}

BlasThreadsKept::~BlasThreadsKept() {
  const BlasThreads& blas = BlasThreadsOfProcess();
  const std::lock_guard lock(g_kept.mutex);
  if (--g_kept.holders == 0 && blas.set != nullptr && blas.get() != g_kept.threads) {
    blas.set(g_kept.threads);
  }
}

int Factor(int n, double* a, int lda) {
  if (n == 0) {
    return 0;
  }
  int info = 0;
  dpotrf_("L", &n, a, &lda, &info, 1);
  CHECK_GE(info, 0);
  const int good = info > 0 ? info - 1 : n;
  for (int k = 0; k < good; ++k) {  // OpenBLAS lets a NaN pass
    const double pivot = a[static_cast<std::size_t>(k) * static_cast<std::size_t>(lda + 1)];
    if (!(pivot > 0.0)) {
      return k + 1;
    }
  }
  return info;
}

void InvertFromFactor(int n, double* a, int lda) {
  if (n == 0) {
    return;
  }
  int info = 0;
  dpotri_("L", &n, a, &lda, &info, 1);
  CHECK_EQ(info, 0);
}

void SolveRightTransposed(int m, int n, const double* l, int ldl, double* b, int ldb) {
  TriangularSolve(CblasRight, CblasTrans, m, n, l, ldl, b, ldb);
}

void SolveRight(int m, int n, const double* l, int ldl, double* b, int ldb) {
  TriangularSolve(CblasRight, CblasNoTrans, m, n, l, ldl, b, ldb);
}

void SolveLeft(int n, int columns, const double* l, int ldl, double* b, int ldb) {
  LeftSolve(CblasNoTrans, n, columns, l, ldl, b, ldb);
}

void SolveLeftTransposed(int n, int columns, const double* l, int ldl, double* b, int ldb) {
  LeftSolve(CblasTrans, n, columns, l, ldl, b, ldb);
}

void SubtractSquare(int n, int k, const double* a, int lda, double* c, int ldc) {
  if (n > 0 && k > 0) {
    cblas_dsyrk(kLayout, CblasLower, CblasNoTrans, n, k, -1.0, a, lda, 1.0, c, ldc);
  }
}

void SubtractProductTransposed(
    int m, int n, int k, const double* a, int lda, const double* b, int ldb, double* c, int ldc) {
  if (m > 0 && n > 0 && k > 0) {
    cblas_dgemm(kLayout, CblasNoTrans, CblasTrans, m, n, k, -1.0, a, lda, b, ldb, 1.0, c, ldc);
  }
}

void SubtractProduct(
    int m, int n, int k, const double* a, int lda, const double* b, int ldb, double* c, int ldc) {
  if (m > 0 && n > 0 && k > 0) {
    cblas_dgemm(kLayout, CblasNoTrans, CblasNoTrans, m, n, k, -1.0, a, lda, b, ldb, 1.0, c, ldc);
  }
}

void NegativeSymmetricProduct(
    int m, int n, const double* s, int lds, const double* b, int ldb, double* c, int ldc) {
  if (m > 0 && n > 0) {
    cblas_dsymm(kLayout, CblasLeft, CblasLower, m, n, -1.0, s, lds, b, ldb, 0.0, c, ldc);
  }
}

void SubtractTransposedProduct(
    int m, int n, int k, const double* a, int lda, const double* b, int ldb, double* c, int ldc) {
  if (m == 0 || n == 0 || k == 0) {
    return;
  }
  if (n == 1) {
    cblas_dgemv(kLayout, CblasTrans, k, m, -1.0, a, lda, b, 1, 1.0, c, 1);
  } else {
    cblas_dgemm(kLayout, CblasTrans, CblasNoTrans, m, n, k, -1.0, a, lda, b, ldb, 1.0, c, ldc);
  }
}

void Product(
    int m, int n, int k, const double* a, int lda, const double* b, int ldb, double* c, int ldc) {
  if (m == 0 || n == 0) {
    return;
  }
  if (n == 1) {
    cblas_dgemv(kLayout, CblasNoTrans, m, k, 1.0, a, lda, b, 1, 0.0, c, 1);
  } else {
    cblas_dgemm(kLayout, CblasNoTrans, CblasNoTrans, m, n, k, 1.0, a, lda, b, ldb, 0.0, c, ldc);
  }
}

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::optional<Eigen::Matrix3d> LowerFactor(const Eigen::Matrix3d& a) {
  const Eigen::LLT<Eigen::Matrix3d> factor(a);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return factor.matrixL();
}

double InverseForm(const Eigen::Matrix3d& a, const Eigen::Vector3d& x) {
  return x.dot(a.ldlt().solve(x));
}

int SignedSquares(int n, double* a, double* g, double* sign) {
  // A diagonal element that is at least this part of all others lets these grow least.
  const double kDiagonalPart = (1.0 + std::sqrt(17.0)) / 8.0;
  const auto at = [&](int i, int k) -> double& { return a[i + k * n]; };
  double least = 0.0;
  int count = 0;
  // Takes the pivot `value` along cosine e_p + sine e_q as the next term.
  const auto take = [&](int p, double cosine, int q, double sine, double value) {
    const double inverse = 1.0 / std::sqrt(std::abs(value));
    double* term = g + count * n;
    for (int i = 0; i < n; ++i) term[i] = inverse * (cosine * at(i, p) + sine * at(i, q));
    sign[count++] = value < 0.0 ? -1.0 : 1.0;
  };
  const auto subtract = [&](int first) {
    for (; first < count; ++first) {
      const double* term = g + first * n;
      for (int k = 0; k < n; ++k) {
        for (int i = 0; i < n; ++i) at(i, k) -= sign[first] * term[i] * term[k];
      }
    }
  };
  const auto clear = [&](int r) {
    for (int i = 0; i < n; ++i) at(i, r) = at(r, i) = 0.0;
  };
  while (count < n) {
    int r = 0, p = 0, q = 0;
    double diagonal = 0.0, other = 0.0;
    for (int k = 0; k < n; ++k) {
      if (std::abs(at(k, k)) > diagonal) diagonal = std::abs(at(r = k, k));
      for (int i = k + 1; i < n; ++i) {
        if (std::abs(at(i, k)) > other) other = std::abs(at(p = i, q = k));
      }
    }
    const double largest = std::max(diagonal, other);
    if (count == 0) least = n * std::numeric_limits<double>::epsilon() * largest;
    if (!(largest > least)) break;
    const int first = count;
    if (diagonal >= kDiagonalPart * other) {
      take(r, 1.0, r, 0.0, at(r, r));
      subtract(first);
      clear(r);
    } else {
      // Its axes by Jacobi's rotation (Golub and Van Loan (2013), Matrix Computations,
      // section 8.5.2).
      const double pp = at(p, p), qq = at(q, q), pq = at(p, q);
      const double tau = 0.5 * (qq - pp) / pq;
      const double t = std::copysign(1.0 / (std::abs(tau) + std::hypot(1.0, tau)), tau);
      const double c = 1.0 / std::hypot(1.0, t), s = t * c;
      take(p, c, q, -s, pp - t * pq);
      take(p, s, q, c, qq + t * pq);
      subtract(first);
      clear(p);
      clear(q);
    }
  }
  return count;
}

Eigenpairs SymmetricEigenpairs(const MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

VectorXd SymmetricEigenvalues(const MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

Cholesky::Cholesky(const MatrixXd& a) : llt_(a) {}
MatrixXd Cholesky::L() const { return llt_.matrixL(); }
double Cholesky::LogDeterminant() const {
  return 2.0 * llt_.matrixLLT().diagonal().array().log().sum();
}
MatrixXd Cholesky::Solve(const MatrixXd& b) const { return llt_.solve(b); }
VectorXd Cholesky::Solve(const VectorXd& b) const { return llt_.solve(b); }
MatrixXd Cholesky::Inverse() const { return Solve(MatrixXd(MatrixXd::Identity(rows(), rows()))); }
MatrixXd Cholesky::SolveLower(MatrixXd b) const {
  llt_.matrixL().solveInPlace(b);
  return b;
}
VectorXd Cholesky::SolveLower(VectorXd b) const {
  llt_.matrixL().solveInPlace(b);
  return b;
}

PivotedCholesky::PivotedCholesky(const MatrixXd& a) : ldlt_(a) {}
bool PivotedCholesky::PivotsAbove(double least) const {
  return ldlt_.info() == Eigen::Success && ldlt_.vectorD().minCoeff() > least;
}
MatrixXd PivotedCholesky::Solve(const MatrixXd& b) const { return ldlt_.solve(b); }
VectorXd PivotedCholesky::Solve(const VectorXd& b) const { return ldlt_.solve(b); }

Orthogonal::Orthogonal(const MatrixXd& a) : qr_(a) {}
MatrixXd Orthogonal::Q(Index columns) const {
  return qr_.householderQ() * MatrixXd::Identity(qr_.rows(), columns);
}
MatrixXd Orthogonal::R() const {
  return qr_.matrixQR().topRows(std::min(qr_.rows(), qr_.cols())).triangularView<Eigen::Upper>();
}

PivotedOrthogonal::PivotedOrthogonal(const MatrixXd& a) : qr_(a) {}
PivotedOrthogonal::PivotedOrthogonal(const MatrixXd& a, double threshold) : qr_(a) {
  qr_.setThreshold(threshold);
}
MatrixXd PivotedOrthogonal::Basis() const {
  return qr_.householderQ() * MatrixXd::Identity(qr_.rows(), qr_.rank());
}
MatrixXd PivotedOrthogonal::Solve(const MatrixXd& b) const { return qr_.solve(b); }

SingularValues DecomposeSingular(const MatrixXd& a) {
  const Eigen::JacobiSVD<MatrixXd> svd(a, Eigen::ComputeThinV);
  return {svd.singularValues(), svd.matrixV()};
}

}  // namespace sarblock::dense

namespace sarblock::sparse {
namespace {

/// Small ranges come from the heap piece by piece: to map and unmap one takes longer than to use
/// it.
constexpr std::size_t kFromHeap = std::size_t{1} << 15;

}  // namespace

FrontMemory::FrontMemory(std::size_t most) : most_(Rounded(most)) {
  if (most_ <= kFromHeap) return;
  void* range = mmap(nullptr,
                     most_ * sizeof(double),
                     PROT_READ | PROT_WRITE,
                     MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE,
                     -1,
                     0);
  if (range == MAP_FAILED) return;
#ifdef MADV_HUGEPAGE
  static_cast<void>(madvise(range, most_ * sizeof(double), MADV_HUGEPAGE));  // advice only
#endif
  begin_ = static_cast<double*>(range);
  free_[0] = most_;
}

FrontMemory::~FrontMemory() {
  if (begin_ != nullptr) munmap(begin_, most_ * sizeof(double));
}

FrontMemory::Place FrontMemory::Take(std::size_t count) {
  const std::size_t length = Rounded(count);
  if (begin_ == nullptr) {
    void* place = std::aligned_alloc(kGrain * sizeof(double), length * sizeof(double));
    if (place == nullptr) throw std::bad_alloc();
    const std::lock_guard lock(mutex_);
    most_taken_ = std::max(most_taken_, taken_ += length);
    return {static_cast<double*>(place), Return(this, length)};
  }
  const std::lock_guard lock(mutex_);
  most_taken_ = std::max(most_taken_, taken_ += length);
  const auto fits = std::find_if(
      free_.begin(), free_.end(), [length](const auto& hole) { return hole.second >= length; });
  CHECK(fits != free_.end()) << "more was taken than announced";
  const auto [offset, available] = *fits;
  free_.erase(fits);
  if (available > length) free_[offset + length] = available - length;
  return {begin_ + offset, Return(this, length)};
}

std::size_t FrontMemory::most_taken() const {
  const std::lock_guard lock(mutex_);
  return most_taken_;
}

void FrontMemory::Give(double* place, std::size_t count) {
  const std::lock_guard lock(mutex_);
  taken_ -= count;
  if (begin_ == nullptr) {
    std::free(place);
    return;
  }
  auto hole = free_.emplace(static_cast<std::size_t>(place - begin_), count).first;
  const auto after = std::next(hole);
  if (after != free_.end() && hole->first + hole->second == after->first) {
    hole->second += after->second;
    free_.erase(after);
  }
  if (hole != free_.begin()) {
    const auto before = std::prev(hole);
    if (before->first + before->second == hole->first) {
      before->second += hole->second;
      free_.erase(hole);
    }
  }
}

}  // namespace sarblock::sparse
