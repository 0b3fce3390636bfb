// SPDX-License-Identifier: Apache-2.0
#include "products.h"

#include <cstring>
#include <type_traits>

// Pairs of doubles are what every x86-64 and arm64 computes with; written out, because compilers
// leave short loops over six or nine numbers scalar.
#define SARBLOCK_INLINE inline __attribute__((always_inline))

namespace sarblock {
namespace {

using Pair = double __attribute__((vector_size(16)));
template <std::size_t kWidth>
using Vector = std::conditional_t<kWidth == 2, Pair, double>;

template <std::size_t kWidth>
SARBLOCK_INLINE Vector<kWidth> Load(const double* p) {
  Vector<kWidth> v;
  std::memcpy(&v, p, sizeof v);  // of any alignment
  return v;
}

template <typename V>
SARBLOCK_INLINE void AddTo(double* p, const V& v) {
  V sum;
  std::memcpy(&sum, p, sizeof sum);
  sum += v;
  std::memcpy(p, &sum, sizeof sum);
}

std::size_t Index(int i) { return static_cast<std::size_t>(i); }

/// A strip of kCount vectors of kWidth numbers.
template <std::size_t kWidth, std::size_t kCount>
struct Strip {
  static constexpr std::size_t width = kWidth, count = kCount;
};

/// Calls f(strip, first row) for strips that cover `rows` rows.
template <typename F>
SARBLOCK_INLINE void ForStrips(std::size_t rows, F&& f) {
  std::size_t first = 0;
  for (; first + 8 <= rows; first += 8) f(Strip<2, 4>{}, first);
  switch ((rows - first) / 2) {
    case 3:
      f(Strip<2, 3>{}, first);
      break;
    case 2:
      f(Strip<2, 2>{}, first);
      break;
    case 1:
      f(Strip<2, 1>{}, first);
      break;
    default:
      break;
  }
  if (rows % 2 != 0) f(Strip<1, 1>{}, rows - 1);
}

/// out += sign sum_k a_k b_k' for the rows of a strip, kTerms terms held in registers.
template <std::size_t kWidth, std::size_t kCount, std::size_t kTerms>
SARBLOCK_INLINE void AddOuter(double* out,
                              std::size_t rows,
                              std::size_t columns,
                              const double* a,
                              const double* b,
                              std::size_t stride,
                              double sign) {
  Vector<kWidth> row[kTerms][kCount];
#pragma GCC unroll 3
  for (std::size_t k = 0; k < kTerms; ++k) {
#pragma GCC unroll 4
    for (std::size_t r = 0; r < kCount; ++r)
      row[k][r] = sign * Load<kWidth>(a + k * stride + r * kWidth);
  }
  for (std::size_t c = 0; c < columns; ++c, out += rows) {
#pragma GCC unroll 4
    for (std::size_t r = 0; r < kCount; ++r) {
      Vector<kWidth> sum = b[c] * row[0][r];
#pragma GCC unroll 3
      for (std::size_t k = 1; k < kTerms; ++k) sum += b[k * stride + c] * row[k][r];
      AddTo(out + r * kWidth, sum);
    }
  }
}

template <std::size_t kTerms>
SARBLOCK_INLINE void AddBlock(double* out,
                              std::size_t rows,
                              std::size_t columns,
                              const double* a,
                              const double* b,
                              std::size_t stride,
                              double sign) {
  ForStrips(
      rows, [&](auto strip, std::size_t first) __attribute__((always_inline)) {
        AddOuter<decltype(strip)::width, decltype(strip)::count, kTerms>(
            out + first, rows, columns, a + first, b, stride, sign);
      });
}

template <std::size_t kTerms>
void Square(
    const PointBlocks& blocks, const double* x, std::size_t stride, double sign, double* values) {
  const std::size_t* value = blocks.value;
  for (int i = 0; i < blocks.count; ++i) {
    for (int j = 0; j <= i; ++j, ++value) {
      AddBlock<kTerms>(values + *value,
                       Index(blocks.size[i]),
                       Index(blocks.size[j]),
                       x + blocks.begin[i],
                       x + blocks.begin[j],
                       stride,
                       sign);
    }
  }
}

/// y (three axes, rows of a strip) += scale C_ij T_j'.
template <std::size_t kWidth, std::size_t kCount>
SARBLOCK_INLINE void AddToStrip(const double* c,
                                std::size_t rows,
                                std::size_t columns,
                                const double* t,
                                std::size_t stride,
                                double scale,
                                Vector<kWidth> (&y)[3][kCount]) {
  for (std::size_t q = 0; q < columns; ++q, c += rows) {
    const double t0 = scale * t[q], t1 = scale * t[stride + q], t2 = scale * t[2 * stride + q];
#pragma GCC unroll 4
    for (std::size_t r = 0; r < kCount; ++r) {
      const Vector<kWidth> element = Load<kWidth>(c + r * kWidth);
      y[0][r] += t0 * element;
      y[1][r] += t1 * element;
      y[2][r] += t2 * element;
    }
  }
}

/// sum[a][b] += x_a y_b over the rows of a strip, x three rows `stride` apart.
template <std::size_t kWidth, std::size_t kCount>
SARBLOCK_INLINE void AddDots(const double* x,
                             std::size_t stride,
                             const Vector<kWidth> (&y)[3][kCount],
                             Pair (&sum)[3][3]) {
#pragma GCC unroll 3
  for (std::size_t a = 0; a < 3; ++a) {
#pragma GCC unroll 4
    for (std::size_t r = 0; r < kCount; ++r) {
      const Vector<kWidth> element = Load<kWidth>(x + a * stride + r * kWidth);
#pragma GCC unroll 3
      for (std::size_t b = 0; b < 3; ++b) {
        if constexpr (kWidth == 2) {
          sum[a][b] += element * y[b][r];
        } else {
          sum[a][b] += Pair{element * y[b][r], 0.0};
        }
      }
    }
  }
}

/// y_j += T_i C_ij: the rows of a block of C in a strip, given T_i there.
template <std::size_t kWidth, std::size_t kCount>
SARBLOCK_INLINE void AddMirrored(const double* c,
                                 std::size_t rows,
                                 std::size_t columns,
                                 const double* t,
                                 std::size_t stride,
                                 double* y) {
  Vector<kWidth> row[3][kCount];
#pragma GCC unroll 3
  for (std::size_t a = 0; a < 3; ++a) {
#pragma GCC unroll 4
    for (std::size_t r = 0; r < kCount; ++r) row[a][r] = Load<kWidth>(t + a * stride + r * kWidth);
  }
  for (std::size_t q = 0; q < columns; ++q, c += rows) {
#pragma GCC unroll 3
    for (std::size_t a = 0; a < 3; ++a) {
      Vector<kWidth> sum = row[a][0] * Load<kWidth>(c);
#pragma GCC unroll 4
      for (std::size_t r = 1; r < kCount; ++r) sum += row[a][r] * Load<kWidth>(c + r * kWidth);
      double& out = y[a * stride + q];
      if constexpr (kWidth == 2) {
        out += sum[0] + sum[1];
      } else {
        out += sum;
      }
    }
  }
}

}  // namespace

void AddSquare(const PointBlocks& blocks,
               const double* x,
               std::size_t stride,
               int terms,
               double sign,
               double* values) {
  for (; terms >= 3; terms -= 3, x += 3 * stride) Square<3>(blocks, x, stride, sign, values);
  if (terms == 2) Square<2>(blocks, x, stride, sign, values);
  if (terms == 1) Square<1>(blocks, x, stride, sign, values);
}

void AddProducts(double* out,
                 int rows,
                 int columns,
                 const double* a,
                 const double* b,
                 std::size_t stride,
                 int terms) {
  for (; terms >= 2; terms -= 2, a += 2 * stride, b += 2 * stride) {
    AddBlock<2>(out, Index(rows), Index(columns), a, b, stride, 1.0);
  }
  if (terms == 1) AddBlock<1>(out, Index(rows), Index(columns), a, b, stride, 1.0);
}

void AddQuadraticForm(const PointBlocks& blocks,
                      const double* t,
                      std::size_t stride,
                      const double* values,
                      double* form) {
  // T C T' = A + A' with A the products of the blocks below the diagonal and half of those on it.
  Pair sum[3][3] = {};
  const std::size_t* value = blocks.value;
  for (int i = 0; i < blocks.count; ++i) {
    const std::size_t rows = Index(blocks.size[i]);
    const double* ti = t + blocks.begin[i];
    ForStrips(
        rows, [&](auto strip, std::size_t first) __attribute__((always_inline)) {
          constexpr std::size_t kWidth = decltype(strip)::width, kCount = decltype(strip)::count;
          Vector<kWidth> y[3][kCount] = {};
          for (int j = 0; j < i; ++j) {
            AddToStrip<kWidth, kCount>(values + value[j] + first,
                                       rows,
                                       Index(blocks.size[j]),
                                       t + blocks.begin[j],
                                       stride,
                                       1.0,
                                       y);
          }
          AddToStrip<kWidth, kCount>(values + value[i] + first, rows, rows, ti, stride, 0.5, y);
          AddDots<kWidth, kCount>(ti + first, stride, y, sum);
        });
    value += i + 1;
  }
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      form[3 * a + b] += (sum[a][b][0] + sum[a][b][1]) + (sum[b][a][0] + sum[b][a][1]);
    }
  }
}

void AddProductWithMatrix(const PointBlocks& blocks,
                          const double* t,
                          std::size_t stride,
                          const double* values,
                          double* y) {
  const std::size_t* value = blocks.value;
  for (int i = 0; i < blocks.count; ++i) {
    const std::size_t rows = Index(blocks.size[i]);
    ForStrips(
        rows, [&](auto strip, std::size_t first) __attribute__((always_inline)) {
          constexpr std::size_t kWidth = decltype(strip)::width, kCount = decltype(strip)::count;
          Vector<kWidth> sum[3][kCount] = {};
          for (int j = 0; j <= i; ++j) {
            AddToStrip<kWidth, kCount>(values + value[j] + first,
                                       rows,
                                       Index(blocks.size[j]),
                                       t + blocks.begin[j],
                                       stride,
                                       1.0,
                                       sum);
            if (j == i) continue;
            AddMirrored<kWidth, kCount>(values + value[j] + first,
                                        rows,
                                        Index(blocks.size[j]),
                                        t + blocks.begin[i] + first,
                                        stride,
                                        y + blocks.begin[j]);
          }
          for (std::size_t a = 0; a < 3; ++a) {
            double* out = y + a * stride + Index(blocks.begin[i]) + first;
            for (std::size_t r = 0; r < kCount; ++r) AddTo(out + r * kWidth, sum[a][r]);
          }
        });
    value += i + 1;
  }
}

void AddTurned(double* out,
               std::size_t stride,
               int terms,
               const double* basis,
               std::size_t basis_stride,
               const double* range,
               const double* doppler,
               int columns) {
  ForStrips(
      Index(columns), [&](auto strip, std::size_t first) __attribute__((always_inline)) {
        constexpr std::size_t kWidth = decltype(strip)::width, kCount = decltype(strip)::count;
        for (int k = 0; k < terms; ++k) {
          const double* b = basis + Index(k) * basis_stride;
          double* sum = out + Index(k) * stride + first;
#pragma GCC unroll 4
          for (std::size_t r = 0; r < kCount; ++r) {
            AddTo(sum + r * kWidth,
                  b[0] * Load<kWidth>(range + first + r * kWidth) +
                      b[1] * Load<kWidth>(doppler + first + r * kWidth));
          }
        }
      });
}

}  // namespace sarblock
