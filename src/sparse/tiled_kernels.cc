// SPDX-License-Identifier: Apache-2.0
#include "tiled_kernels.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <vector>

#include "dense_kernels.h"
#include "front_schedule.h"

namespace sarblock::dense {
namespace {

constexpr int kTileRows = 384;
constexpr int kTileColumns = 256;
/// Strips of a triangular result, so that little is computed above its diagonal.
constexpr int kStrip = 96;

std::size_t At(int row, int column, int ld) {
  return static_cast<std::size_t>(column) * static_cast<std::size_t>(ld) +
         static_cast<std::size_t>(row);
}

std::size_t Pieces(int count, int size) {
  return static_cast<std::size_t>((count + size - 1) / size);
}

/// Calls work(first, length) for pieces of [0, count).
template <typename Work>
void ForRanges(int count, int size, const Work& work) {
  sparse::ForPieces(Pieces(count, size), [&](std::size_t piece) {
    const int first = static_cast<int>(piece) * size;
    work(first, std::min(size, count - first));
  });
}

struct Tile {
  int row, column, height, width;
};

/// Lower trapezoid of c -= a a(0 : columns)', a rows x k, c rows x columns.
void SubtractTrapezoid(int rows, int columns, int k, const double* a, int lda, double* c, int ldc) {
  std::vector<Tile> tiles;
  for (int column = 0; column < columns; column += kTileColumns) {
    const int width = std::min(kTileColumns, columns - column);
    tiles.push_back({column, column, width, width});
    for (int row = column + width; row < rows; row += kTileRows) {
      tiles.push_back({row, column, std::min(kTileRows, rows - row), width});
    }
  }
  sparse::ForPieces(tiles.size(), [&](std::size_t i) {
    const Tile& t = tiles[i];
    double* target = c + At(t.row, t.column, ldc);
    if (t.row == t.column) {
      SubtractSquare(t.width, k, a + t.row, lda, target, ldc);
    } else {
      SubtractProductTransposed(
          t.height, t.width, k, a + t.row, lda, a + t.column, lda, target, ldc);
    }
  });
}

/// c = -s b, s symmetric m x m by its lower triangle, b and c m x n.
void NegativeSymmetricTiled(
    int m, int n, const double* s, int lds, const double* b, int ldb, double* c, int ldc) {
  ForRanges(m, kTileRows, [&](int row, int height) {
    const int below = row + height;
    NegativeSymmetricProduct(height, n, s + At(row, row, lds), lds, b + row, ldb, c + row, ldc);
    SubtractProduct(height, n, row, s + row, lds, b, ldb, c + row, ldc);
    SubtractTransposedProduct(
        height, n, m - below, s + At(below, row, lds), lds, b + below, ldb, c + row, ldc);
  });
}

/// InvertPanel for one block of columns. `scaled` is workspace of (height - n) n doubles.
void InvertBlock(
    int height, int n, const double* panel, int ld_panel, double* scaled, double* z, int ldz) {
  const int r = height - n;
  for (int c = 0; c < n; ++c) {
    const double* column = panel + At(0, c, ld_panel);
    std::copy(column + n, column + height, scaled + At(0, c, r));
    std::copy(column + c, column + n, z + At(c, c, ldz));
  }
  InvertFromFactor(n, z, ldz);
  if (r == 0) return;
  ForRanges(r, kTileRows, [&](int row, int rows) {
    SolveRight(rows, n, panel, ld_panel, scaled + row, r);
  });
  NegativeSymmetricTiled(r, n, z + At(n, n, ldz), ldz, scaled, r, z + n, ldz);
  ForRanges(n, kStrip, [&](int c, int width) {
    SubtractTransposedProduct(
        n - c, width, r, scaled + At(0, c, r), r, z + At(n, c, ldz), ldz, z + At(c, c, ldz), ldz);
  });
}

}  // namespace

int FactorPanel(int height, int columns, double* a, int lda) {
  for (int first = 0; first < columns; first += kBlockColumns) {
    const int width = std::min(kBlockColumns, columns - first);
    const int next = first + width;
    double* block = a + At(first, first, lda);
    const int failed = Factor(width, block, lda);
    if (failed > 0) return first + failed;
    ForRanges(height - next, kTileRows, [&](int row, int rows) {
      SolveRightTransposed(rows, width, block, lda, block + width + row, lda);
    });
    SubtractTrapezoid(
        height - next, columns - next, width, block + width, lda, a + At(next, next, lda), lda);
  }
  return 0;
}

void SubtractSquareTiled(int n, int k, const double* a, int lda, double* c, int ldc) {
  SubtractTrapezoid(n, n, k, a, lda, c, ldc);
}

void InvertPanel(int height, int columns, const double* panel, double* z) {
  const int last = (columns - 1) / kBlockColumns * kBlockColumns;
  const auto scaled = std::make_unique_for_overwrite<double[]>(
      static_cast<std::size_t>(height) *
      static_cast<std::size_t>(std::min(columns, kBlockColumns)));
  for (int first = last; first >= 0; first -= kBlockColumns) {
    InvertBlock(height - first,
                std::min(kBlockColumns, columns - first),
                panel + At(first, first, height),
                height,
                scaled.get(),
                z + At(first, first, height),
                height);
  }
}

}  // namespace sarblock::dense
