// SPDX-License-Identifier: Apache-2.0
#pragma once

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

}  // namespace sarblock::dense
