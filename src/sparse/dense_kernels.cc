// SPDX-License-Identifier: Apache-2.0
#include "dense_kernels.h"

#include <cstddef>
#include <mutex>

#include <dlfcn.h>
#include <glog/logging.h>

// Fortran symbols; the trailing sizes are the hidden lengths of the character arguments.
extern "C" {
void dpotrf_(const char*, const int*, double*, const int*, int*, std::size_t);
void dpotri_(const char*, const int*, double*, const int*, int*, std::size_t);
void dtrsm_(const char*,
            const char*,
            const char*,
            const char*,
            const int*,
            const int*,
            const double*,
            const double*,
            const int*,
            double*,
            const int*,
            std::size_t,
            std::size_t,
            std::size_t,
            std::size_t);
void dtrsv_(const char*,
            const char*,
            const char*,
            const int*,
            const double*,
            const int*,
            double*,
            const int*,
            std::size_t,
            std::size_t,
            std::size_t);
void dsyrk_(const char*,
            const char*,
            const int*,
            const int*,
            const double*,
            const double*,
            const int*,
            const double*,
            double*,
            const int*,
            std::size_t,
            std::size_t);
void dsymm_(const char*,
            const char*,
            const int*,
            const int*,
            const double*,
            const double*,
            const int*,
            const double*,
            const int*,
            const double*,
            double*,
            const int*,
            std::size_t,
            std::size_t);
void dgemm_(const char*,
            const char*,
            const int*,
            const int*,
            const int*,
            const double*,
            const double*,
            const int*,
            const double*,
            const int*,
            const double*,
            double*,
            const int*,
            std::size_t,
            std::size_t);
void dgemv_(const char*,
            const int*,
            const int*,
            const double*,
            const double*,
            const int*,
            const double*,
            const int*,
            const double*,
            double*,
            const int*,
            std::size_t);
}

namespace sarblock::dense {
namespace {

constexpr double kOne = 1.0, kMinusOne = -1.0, kZero = 0.0;
constexpr int kStep = 1;

void TriangularSolve(const char* side,
                     const char* transposed,
                     int m,
                     int n,
                     const double* l,
                     int ldl,
                     double* b,
                     int ldb) {
  if (m > 0 && n > 0) {
    dtrsm_(side, "L", transposed, "N", &m, &n, &kOne, l, &ldl, b, &ldb, 1, 1, 1, 1);
  }
}

void LeftSolve(
    const char* transposed, int n, int columns, const double* l, int ldl, double* b, int ldb) {
  if (columns == 1 && n > 0) {  // dtrsm packs the triangle even for one column
    dtrsv_("L", transposed, "N", &n, l, &ldl, b, &kStep, 1, 1, 1);
  } else {
    TriangularSolve("L", transposed, n, columns, l, ldl, b, ldb);
  }
}

/// Looked up at run time: which BLAS stands behind libblas.so.3 is the installation's choice.
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
  TriangularSolve("R", "T", m, n, l, ldl, b, ldb);
}

void SolveRight(int m, int n, const double* l, int ldl, double* b, int ldb) {
  TriangularSolve("R", "N", m, n, l, ldl, b, ldb);
}

void SolveLeft(int n, int columns, const double* l, int ldl, double* b, int ldb) {
  LeftSolve("N", n, columns, l, ldl, b, ldb);
}

void SolveLeftTransposed(int n, int columns, const double* l, int ldl, double* b, int ldb) {
  LeftSolve("T", n, columns, l, ldl, b, ldb);
}

void SubtractSquare(int n, int k, const double* a, int lda, double* c, int ldc) {
  if (n > 0 && k > 0) {
    dsyrk_("L", "N", &n, &k, &kMinusOne, a, &lda, &kOne, c, &ldc, 1, 1);
  }
}

void SubtractProductTransposed(
    int m, int n, int k, const double* a, int lda, const double* b, int ldb, double* c, int ldc) {
  if (m > 0 && n > 0 && k > 0) {
    dgemm_("N", "T", &m, &n, &k, &kMinusOne, a, &lda, b, &ldb, &kOne, c, &ldc, 1, 1);
  }
}

void SubtractProduct(
    int m, int n, int k, const double* a, int lda, const double* b, int ldb, double* c, int ldc) {
  if (m > 0 && n > 0 && k > 0) {
    dgemm_("N", "N", &m, &n, &k, &kMinusOne, a, &lda, b, &ldb, &kOne, c, &ldc, 1, 1);
  }
}

void NegativeSymmetricProduct(
    int m, int n, const double* s, int lds, const double* b, int ldb, double* c, int ldc) {
  if (m > 0 && n > 0) {
    dsymm_("L", "L", &m, &n, &kMinusOne, s, &lds, b, &ldb, &kZero, c, &ldc, 1, 1);
  }
}

void SubtractTransposedProduct(
    int m, int n, int k, const double* a, int lda, const double* b, int ldb, double* c, int ldc) {
  if (m == 0 || n == 0 || k == 0) {
    return;
  }
  if (n == 1) {
    dgemv_("T", &k, &m, &kMinusOne, a, &lda, b, &kStep, &kOne, c, &kStep, 1);
  } else {
    dgemm_("T", "N", &m, &n, &k, &kMinusOne, a, &lda, b, &ldb, &kOne, c, &ldc, 1, 1);
  }
}

void Product(
    int m, int n, int k, const double* a, int lda, const double* b, int ldb, double* c, int ldc) {
  if (m == 0 || n == 0) {
    return;
  }
  if (n == 1) {
    dgemv_("N", &m, &k, &kOne, a, &lda, b, &kStep, &kZero, c, &kStep, 1);
  } else {
    dgemm_("N", "N", &m, &n, &k, &kOne, a, &lda, b, &ldb, &kZero, c, &ldc, 1, 1);
  }
}

}  // namespace sarblock::dense
