// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kernels.h"

// The kernels of kernels.h, compiled once for every processor and once for those with vectors of
// four doubles (kernels.cc, kernels_avx2.cc). No header of a library: nothing that a linker
// could share between the two may be compiled here. The second rounds a product and its sum at
// once, so that the two differ in the last digits.

// Vectors are written out, because compilers leave short loops over six or nine numbers scalar.
#define SARBLOCK_INLINE inline __attribute__((always_inline))

namespace sarblock {
namespace {

using Size = decltype(sizeof 0);
using Pair = double __attribute__((vector_size(16)));
using Quad = double __attribute__((vector_size(32)));

SARBLOCK_INLINE Size Index(int i) { return static_cast<Size>(i); }

template <typename V>
SARBLOCK_INLINE void Load(const double* p, V* v) {
  __builtin_memcpy(v, p, sizeof *v);  // of any alignment
}

template <typename V>
SARBLOCK_INLINE void AddTo(double* p, const V& v) {
  V sum;
  Load(p, &sum);
  sum += v;
  __builtin_memcpy(p, &sum, sizeof sum);
}

/// sum += a b by pairs, in the order of the rows.
SARBLOCK_INLINE void AddPairs(const Quad& a, const Quad& b, Pair* sum) {
  const Quad products = a * b;
  *sum += Pair{products[0], products[1]};
  *sum += Pair{products[2], products[3]};
}
SARBLOCK_INLINE void AddPairs(const Pair& a, const Pair& b, Pair* sum) { *sum += a * b; }
SARBLOCK_INLINE void AddPairs(double a, double b, Pair* sum) { *sum += Pair{a * b, 0.0}; }

/// Consecutive rows in the widest vectors that hold them: kQuads of four, kPairs of two, kSingles.
template <Size kQuads, Size kPairs, Size kSingles>
struct Strip {
  Quad quad[kQuads > 0 ? kQuads : 1];
  Pair pair[kPairs > 0 ? kPairs : 1];
  double single[kSingles > 0 ? kSingles : 1];

  /// Calls f(vector, the same vector of `other`, first row).
  template <typename F>
  SARBLOCK_INLINE void ForEach(const Strip& other, F&& f) {
#pragma GCC unroll 2
    for (Size i = 0; i < kQuads; ++i) f(quad[i], other.quad[i], 4 * i);
#pragma GCC unroll 2
    for (Size i = 0; i < kPairs; ++i) f(pair[i], other.pair[i], 4 * kQuads + 2 * i);
#pragma GCC unroll 2
    for (Size i = 0; i < kSingles; ++i) {
      f(single[i], other.single[i], 4 * kQuads + 2 * kPairs + i);
    }
  }
  SARBLOCK_INLINE void Read(const double* p) {
    ForEach(
        *this, [p](auto& v, const auto&, Size row) __attribute__((always_inline)) {
          Load(p + row, &v);
        });
  }
  SARBLOCK_INLINE void AddToRows(double* p) {
    ForEach(
        *this, [p](auto& v, const auto&, Size row) __attribute__((always_inline)) {
          AddTo(p + row, v);
        });
  }
  /// this = scale other
  SARBLOCK_INLINE void SetScaled(double scale, const Strip& other) {
    ForEach(
        other, [scale](auto& v, const auto& w, Size) __attribute__((always_inline)) {
          v = scale * w;
        });
  }
  /// this += scale other
  SARBLOCK_INLINE void AddScaled(double scale, const Strip& other) {
    ForEach(
        other, [scale](auto& v, const auto& w, Size) __attribute__((always_inline)) {
          v += scale * w;
        });
  }
  /// this += the squares of other's rows
  SARBLOCK_INLINE void AddSquares(const Strip& other) {
    ForEach(
        other, [](auto& v, const auto& w, Size) __attribute__((always_inline)) { v += w * w; });
  }
  /// Products with `other` row by row, summed by pairs.
  SARBLOCK_INLINE void AddProductsTo(Pair* sum, const Strip& other) {
    ForEach(
        other, [sum](auto& v, const auto& w, Size) __attribute__((always_inline)) {
          AddPairs(v, w, sum);
        });
  }
};

/// Calls f(an empty strip, first row) for strips that cover `rows` rows.
template <typename F>
SARBLOCK_INLINE void ForStrips(Size rows, F&& f) {
  Size first = 0;
  for (; first + 8 <= rows; first += 8) f(Strip<2, 0, 0>{}, first);
  switch (rows - first) {
    case 7:
      return f(Strip<1, 1, 1>{}, first);
    case 6:
      return f(Strip<1, 1, 0>{}, first);
    case 5:
      return f(Strip<1, 0, 1>{}, first);
    case 4:
      return f(Strip<1, 0, 0>{}, first);
    case 3:
      return f(Strip<0, 1, 1>{}, first);
    case 2:
      return f(Strip<0, 1, 0>{}, first);
    case 1:
      return f(Strip<0, 0, 1>{}, first);
    default:
      return;
  }
}

/// out += sign sum_k a_k b_k' for one block, kTerms terms in registers.
template <Size kTerms>
SARBLOCK_INLINE void AddBlock(double* out,
                              Size rows,
                              Size columns,
                              const double* a,
                              const double* b,
                              Size stride,
                              double sign) {
  ForStrips(
      rows, [&](auto strip, Size first) __attribute__((always_inline)) {
        decltype(strip) row[kTerms];
#pragma GCC unroll 3
        for (Size k = 0; k < kTerms; ++k) {
          row[k].Read(a + k * stride + first);
          row[k].SetScaled(sign, row[k]);
        }
        double* column = out + first;
        for (Size c = 0; c < columns; ++c, column += rows) {
          strip.SetScaled(b[c], row[0]);
#pragma GCC unroll 3
          for (Size k = 1; k < kTerms; ++k) strip.AddScaled(b[k * stride + c], row[k]);
          strip.AddToRows(column);
        }
      });
}

template <Size kTerms>
void Square(const PointBlocks& blocks, const double* x, Size stride, double sign, double* values) {
  const Size* value = blocks.value;
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
template <typename S>
SARBLOCK_INLINE void AddToStrip(const double* c,
                                Size rows,
                                Size columns,
                                const double* t,
                                Size stride,
                                double scale,
                                S (&y)[3]) {
  S element;
  for (Size q = 0; q < columns; ++q, c += rows) {
    element.Read(c);
#pragma GCC unroll 3
    for (Size a = 0; a < 3; ++a) y[a].AddScaled(scale * t[a * stride + q], element);
  }
}

template <typename S>
SARBLOCK_INLINE void SetZero(S (&y)[3]) {
#pragma GCC unroll 3
  for (Size a = 0; a < 3; ++a) y[a] = S{};
}

void AddSquareHere(const PointBlocks& blocks,
                   const double* x,
                   Size stride,
                   int terms,
                   double sign,
                   double* values) {
  for (; terms >= 3; terms -= 3, x += 3 * stride) Square<3>(blocks, x, stride, sign, values);
  if (terms == 2) Square<2>(blocks, x, stride, sign, values);
  if (terms == 1) Square<1>(blocks, x, stride, sign, values);
}

void AddProductsHere(
    double* out, int rows, int columns, const double* a, const double* b, Size stride, int terms) {
  for (; terms >= 2; terms -= 2, a += 2 * stride, b += 2 * stride) {
    AddBlock<2>(out, Index(rows), Index(columns), a, b, stride, 1.0);
  }
  if (terms == 1) AddBlock<1>(out, Index(rows), Index(columns), a, b, stride, 1.0);
}

void AddQuadraticFormHere(
    const PointBlocks& blocks, const double* t, Size stride, const double* values, double* form) {
  // T C T' = A + A' with A the products of the blocks below the diagonal and half of those on it.
  Pair sum[3][3] = {};
  const Size* value = blocks.value;
  for (int i = 0; i < blocks.count; ++i) {
    const Size rows = Index(blocks.size[i]);
    const double* ti = t + blocks.begin[i];
    ForStrips(
        rows, [&](auto strip, Size first) __attribute__((always_inline)) {
          decltype(strip) y[3];
          SetZero(y);
          for (int j = 0; j < i; ++j) {
            AddToStrip(values + value[j] + first,
                       rows,
                       Index(blocks.size[j]),
                       t + blocks.begin[j],
                       stride,
                       1.0,
                       y);
          }
          AddToStrip(values + value[i] + first, rows, rows, ti, stride, 0.5, y);
#pragma GCC unroll 3
          for (Size a = 0; a < 3; ++a) {
            strip.Read(ti + a * stride + first);
#pragma GCC unroll 3
            for (Size b = 0; b < 3; ++b) strip.AddProductsTo(&sum[a][b], y[b]);
          }
        });
    value += i + 1;
  }
  for (Size a = 0; a < 3; ++a) {
    for (Size b = 0; b < 3; ++b) {
      form[3 * a + b] += (sum[a][b][0] + sum[a][b][1]) + (sum[b][a][0] + sum[b][a][1]);
    }
  }
}

/// y_j += T_i C_ij: the rows of a block of C in a strip, given T_i there.
template <typename S>
SARBLOCK_INLINE void AddMirrored(
    const double* c, Size rows, Size columns, const double* t, Size stride, double* y) {
  S row[3], element;
#pragma GCC unroll 3
  for (Size a = 0; a < 3; ++a) row[a].Read(t + a * stride);
  for (Size q = 0; q < columns; ++q, c += rows) {
    element.Read(c);
#pragma GCC unroll 3
    for (Size a = 0; a < 3; ++a) {
      Pair sum = {};
      row[a].AddProductsTo(&sum, element);
      y[a * stride + q] += sum[0] + sum[1];
    }
  }
}

void AddProductWithMatrixHere(
    const PointBlocks& blocks, const double* t, Size stride, const double* values, double* y) {
  const Size* value = blocks.value;
  for (int i = 0; i < blocks.count; ++i) {
    const Size rows = Index(blocks.size[i]);
    ForStrips(
        rows, [&](auto strip, Size first) __attribute__((always_inline)) {
          using S = decltype(strip);
          S sum[3];
          SetZero(sum);
          for (int j = 0; j <= i; ++j) {
            const double* c = values + value[j] + first;
            const Size columns = Index(blocks.size[j]);
            AddToStrip(c, rows, columns, t + blocks.begin[j], stride, 1.0, sum);
            if (j == i) continue;
            AddMirrored<S>(
                c, rows, columns, t + blocks.begin[i] + first, stride, y + blocks.begin[j]);
          }
#pragma GCC unroll 3
          for (Size a = 0; a < 3; ++a) {
            sum[a].AddToRows(y + a * stride + Index(blocks.begin[i]) + first);
          }
        });
    value += i + 1;
  }
}

void AddTurnedHere(double* out,
                   Size stride,
                   int terms,
                   const double* basis,
                   Size basis_stride,
                   const double* range,
                   const double* doppler,
                   int columns) {
  ForStrips(
      Index(columns), [&](auto strip, Size first) __attribute__((always_inline)) {
        decltype(strip) both[2];
        both[0].Read(range + first);
        both[1].Read(doppler + first);
        for (Size k = 0; k < Index(terms); ++k) {
          const double* b = basis + k * basis_stride;
          strip.SetScaled(b[0], both[0]);
          strip.AddScaled(b[1], both[1]);
          strip.AddToRows(out + k * stride + first);
        }
      });
}

void AddLookHere(int columns,
                 const double* range,
                 const double* doppler,
                 const double* whitened_error,
                 double* diagonal,
                 double* gradient) {
  ForStrips(
      Index(columns), [&](auto strip, Size first) __attribute__((always_inline)) {
        decltype(strip) both[2];
        both[0].Read(range + first);
        both[1].Read(doppler + first);
        strip.SetScaled(whitened_error[0], both[0]);
        strip.AddScaled(whitened_error[1], both[1]);
        strip.AddToRows(gradient + first);
        strip = {};
        strip.AddSquares(both[0]);
        strip.AddSquares(both[1]);
        strip.AddToRows(diagonal + first);
      });
}

void AddCombinationHere(
    int columns, const double* x, Size stride, int terms, const double* c, double* out) {
  ForStrips(
      Index(columns), [&](auto strip, Size first) __attribute__((always_inline)) {
        decltype(strip) row;
        strip = {};
        for (Size k = 0; k < Index(terms); ++k) {
          row.Read(x + k * stride + first);
          strip.AddScaled(c[k], row);
        }
        strip.AddToRows(out + first);
      });
}

constexpr ProductKernels kKernelsHere{AddSquareHere,
                                      AddProductsHere,
                                      AddQuadraticFormHere,
                                      AddProductWithMatrixHere,
                                      AddTurnedHere,
                                      AddLookHere,
                                      AddCombinationHere};

}  // namespace

}  // namespace sarblock
