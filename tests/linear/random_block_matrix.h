// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <random>
#include <utility>
#include <vector>

#include "linear/block_matrix.h"
#include <Eigen/Dense>

namespace sarblock::test {

using Pairs = std::vector<std::pair<int, int>>;

/// Block sizes 1..largest.
inline std::vector<int> RandomSizes(int count, int largest, std::mt19937_64& engine) {
  std::vector<int> sizes(static_cast<std::size_t>(count));
  for (int& size : sizes) {
    size = 1 + static_cast<int>(engine() % static_cast<unsigned>(largest));
  }
  return sizes;
}

inline Pairs Band(int count, int width) {
  Pairs pairs;
  for (int j = 0; j < count; ++j) {
    for (int i = j + 1; i < count && i <= j + width; ++i) {
      pairs.emplace_back(i, j);
    }
  }
  return pairs;
}

/// nx x ny x nz grid, blocks paired within `reach` steps along each axis.
inline Pairs Grid(int nx, int ny, int nz, int reach) {
  Pairs pairs;
  for (int a = 0; a < nx * ny * nz; ++a) {
    const int x = a / (ny * nz), y = a / nz % ny, z = a % nz;
    for (int i = x; i <= x + reach && i < nx; ++i) {
      for (int j = y < reach ? 0 : y - reach; j <= y + reach && j < ny; ++j) {
        for (int k = z < reach ? 0 : z - reach; k <= z + reach && k < nz; ++k) {
          const int b = (i * ny + j) * nz + k;
          if (b > a) {
            pairs.emplace_back(a, b);
          }
        }
      }
    }
  }
  return pairs;
}

/// Block `centre` paired with all.
inline Pairs Star(int count, int centre) {
  Pairs pairs;
  for (int b = 0; b < count; ++b) {
    pairs.emplace_back(b, centre);
  }
  return pairs;
}

inline Pairs RandomPairs(int count, int edges, std::mt19937_64& engine) {
  Pairs pairs;
  for (int e = 0; e < edges; ++e) {
    pairs.emplace_back(static_cast<int>(engine() % static_cast<unsigned>(count)),
                       static_cast<int>(engine() % static_cast<unsigned>(count)));
  }
  return pairs;
}

/// A positive definite matrix on the pattern: off-diagonal blocks N(0, 1), each added to the
/// diagonal through a product as normal equations do, plus `ridge` times the unit matrix.
inline BlockSymmetricMatrix RandomPositive(std::vector<int> sizes,
                                           const Pairs& pairs,
                                           double ridge,
                                           std::mt19937_64& engine) {
  BlockSymmetricMatrix matrix(std::move(sizes), pairs);
  std::normal_distribution<double> normal;
  const auto draw = [&](int rows, int columns) {
    return Eigen::MatrixXd(
        Eigen::MatrixXd::NullaryExpr(rows, columns, [&]() { return normal(engine); }));
  };
  for (int j = 0; j < matrix.block_count(); ++j) {
    matrix.Block(j, j) += ridge * Eigen::MatrixXd::Identity(matrix.size(j), matrix.size(j));
    for (const int i : matrix.RowsOfColumn(j)) {
      const int common = 1 + matrix.size(j) / 2;
      const Eigen::MatrixXd a = draw(common, matrix.size(i)), b = draw(common, matrix.size(j));
      matrix.Block(j, j) += b.transpose() * b;
      if (i != j) {
        matrix.Block(i, i) += a.transpose() * a;
        matrix.Block(i, j) += a.transpose() * b;
      }
    }
  }
  return matrix;
}

}  // namespace sarblock::test
