// SPDX-License-Identifier: Apache-2.0
#include "products.h"

#include <array>

namespace sarblock {
namespace {

/// kRows > 0: rows known to the compiler, the sums of a column stay in registers. 0: any number.
template <int kRows>
void Products(double* out,
              int any_rows,
              int columns,
              const double* a,
              const double* b,
              std::size_t stride,
              int terms,
              double sign) {
  if constexpr (kRows > 0) {
    constexpr auto kCount = static_cast<std::size_t>(kRows);
    for (int c = 0; c < columns; ++c, out += kRows) {
      std::array<double, kCount> sum{};
      for (int k = 0; k < terms; ++k) {
        const double* row = a + static_cast<std::size_t>(k) * stride;
        const double scale = b[static_cast<std::size_t>(k) * stride + static_cast<std::size_t>(c)];
        for (std::size_t r = 0; r < kCount; ++r) sum[r] += scale * row[r];
      }
      for (std::size_t r = 0; r < kCount; ++r) out[r] += sign * sum[r];
    }
  } else {
    for (int c = 0; c < columns; ++c, out += any_rows) {
      for (int k = 0; k < terms; ++k) {
        const double* row = a + static_cast<std::size_t>(k) * stride;
        const double scale =
            sign * b[static_cast<std::size_t>(k) * stride + static_cast<std::size_t>(c)];
        for (int r = 0; r < any_rows; ++r) out[r] += scale * row[r];
      }
    }
  }
}

template <int kRows>
void BlockProduct(const double* c,
                  int any_rows,
                  int columns,
                  const double* t_i,
                  const double* t_j,
                  std::size_t stride,
                  bool diagonal,
                  double* y_i,
                  double* y_j) {
  const int rows = kRows > 0 ? kRows : any_rows;
  for (int col = 0; col < columns; ++col, c += rows) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double* ti = t_i + axis * stride;
      double dot = 0.0;
      for (int r = 0; r < rows; ++r) dot += ti[r] * c[r];
      y_j[axis * stride + static_cast<std::size_t>(col)] += dot;
      if (diagonal) continue;
      const double scale = t_j[axis * stride + static_cast<std::size_t>(col)];
      double* yi = y_i + axis * stride;
      for (int r = 0; r < rows; ++r) yi[r] += scale * c[r];
    }
  }
}

}  // namespace

void AddProducts(double* out,
                 int rows,
                 int columns,
                 const double* a,
                 const double* b,
                 std::size_t stride,
                 int terms,
                 double sign) {
  switch (rows) {
    case 1:
      return Products<1>(out, rows, columns, a, b, stride, terms, sign);
    case 2:
      return Products<2>(out, rows, columns, a, b, stride, terms, sign);
    case 3:
      return Products<3>(out, rows, columns, a, b, stride, terms, sign);
    case 6:
      return Products<6>(out, rows, columns, a, b, stride, terms, sign);
    case 9:
      return Products<9>(out, rows, columns, a, b, stride, terms, sign);
    case 12:
      return Products<12>(out, rows, columns, a, b, stride, terms, sign);
    case 24:
      return Products<24>(out, rows, columns, a, b, stride, terms, sign);
    default:
      return Products<0>(out, rows, columns, a, b, stride, terms, sign);
  }
}

void AddBlockProduct(const double* c,
                     int rows,
                     int columns,
                     const double* t_i,
                     const double* t_j,
                     std::size_t stride,
                     bool diagonal,
                     double* y_i,
                     double* y_j) {
  switch (rows) {
    case 3:
      return BlockProduct<3>(c, rows, columns, t_i, t_j, stride, diagonal, y_i, y_j);
    case 6:
      return BlockProduct<6>(c, rows, columns, t_i, t_j, stride, diagonal, y_i, y_j);
    case 12:
      return BlockProduct<12>(c, rows, columns, t_i, t_j, stride, diagonal, y_i, y_j);
    default:
      return BlockProduct<0>(c, rows, columns, t_i, t_j, stride, diagonal, y_i, y_j);
  }
}

}  // namespace sarblock
