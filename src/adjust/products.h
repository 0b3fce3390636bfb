// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace sarblock {

/// out += sign sum_k a_k b_k', out `rows` x `columns` column by column; row vector a_k of `rows`
/// elements at a + k stride, b_k of `columns` at b + k stride, k < terms. The inner kernel of the
/// reduced normals: unrolled for the usual sizes of parameter blocks.
void AddProducts(double* out,
                 int rows,
                 int columns,
                 const double* a,
                 const double* b,
                 std::size_t stride,
                 int terms,
                 double sign);

/// The rows y (3 x width, `stride` apart) of Y = T C, one stored block of C at a time: `c`, rows x
/// columns column by column, stands at rows `i` and columns `j` of C; mirrored unless on the
/// diagonal.
void AddBlockProduct(const double* c,
                     int rows,
                     int columns,
                     const double* t_i,
                     const double* t_j,
                     std::size_t stride,
                     bool diagonal,
                     double* y_i,
                     double* y_j);

}  // namespace sarblock
