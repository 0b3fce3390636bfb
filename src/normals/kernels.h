// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace sarblock {

/// Places of the parameter blocks of one point: in the point's own columns, and in the values of
/// a symmetric block matrix over all corrections.
struct PointBlocks {
  int count = 0;
  const int* begin = nullptr;  ///< first column of each block, ascending
  const int* size = nullptr;   ///< columns of each
  /// First value of block (i, j), i >= j, size[i] x size[j] column by column, at i (i + 1) / 2 + j.
  const std::size_t* value = nullptr;
};

/// The inner loops of elimination and sweep, over rows of a few vectors `stride` apart. Blocks of
/// any size; rows are taken eight at a time, so that up to 24 parameters are three strips whose
/// sums stay in registers. Every sum runs in an order that depends on the sizes alone.
struct ProductKernels {
  /// values += sign sum_k x_k x_k' over the blocks of a point, k < terms; lower triangle of S.
  void (*AddSquare)(const PointBlocks& blocks,
                    const double* x,
                    std::size_t stride,
                    int terms,
                    double sign,
                    double* values);
  /// out += sum_k a_k b_k' for one block of `rows` x `columns`, column by column.
  void (*AddProducts)(double* out,
                      int rows,
                      int columns,
                      const double* a,
                      const double* b,
                      std::size_t stride,
                      int terms);
  /// form (3 x 3) += T C T', T three rows over the blocks of a point, C in `values`. Half of the
  /// blocks are read once and half of their products formed: T C T' is symmetric.
  void (*AddQuadraticForm)(const PointBlocks& blocks,
                           const double* t,
                           std::size_t stride,
                           const double* values,
                           double* form);
  /// Y += T C, three rows like T.
  void (*AddProductWithMatrix)(const PointBlocks& blocks,
                               const double* t,
                               std::size_t stride,
                               const double* values,
                               double* y);
  /// The two rows of a look in another basis: out_k += basis_k[0] range + basis_k[1] doppler over
  /// `columns` columns, k < terms; out_k `stride` apart, basis_k `basis_stride`.
  void (*AddTurned)(double* out,
                    std::size_t stride,
                    int terms,
                    const double* basis,
                    std::size_t basis_stride,
                    const double* range,
                    const double* doppler,
                    int columns);
  /// What a look adds to J'J's diagonal and to J'e: diagonal += range^2 + doppler^2, gradient +=
  /// range whitened_error[0] + doppler whitened_error[1], over `columns` columns.
  void (*AddLook)(int columns,
                  const double* range,
                  const double* doppler,
                  const double* whitened_error,
                  double* diagonal,
                  double* gradient);
  /// out += sum_k c_k x_k over `columns` columns, k < terms.
  void (*AddCombination)(
      int columns, const double* x, std::size_t stride, int terms, const double* c, double* out);
};

/// For every processor.
[[nodiscard]] const ProductKernels& BaselineKernels();
/// The fastest that this processor runs.
[[nodiscard]] const ProductKernels& KernelsOfThisMachine();

/// For x86-64 processors with vectors of four doubles and fused products.
[[nodiscard]] const ProductKernels& Avx2Kernels();

}  // namespace sarblock
