// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <Eigen/Core>

namespace sarblock {

/// The 3 x 3 matrix, east, north, up, of its six numbers (SymmetricEnu).
[[nodiscard]] inline Eigen::Matrix3d MatrixOf(const SymmetricEnu& c) {
  Eigen::Matrix3d matrix;
  matrix << c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2];
  return matrix;
}

/// The six numbers of a symmetric 3 x 3 matrix, from its upper triangle.
[[nodiscard]] inline SymmetricEnu SymmetricOf(const Eigen::Matrix3d& c) {
  return {c(0, 0), c(1, 1), c(2, 2), c(0, 1), c(0, 2), c(1, 2)};
}

}  // namespace sarblock
