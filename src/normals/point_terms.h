// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "kernel_choice.h"
#include "linear/block_matrix.h"
#include "model/problem.h"
#include "point_factor.h"
#include "products.h"
#include <Eigen/Core>

namespace sarblock {

/// What the kernels of products.h need of a point beside its PointColumns. The storage is reused
/// from point to point.
struct PointTerms {
  PointColumns columns;
  std::vector<int> size;           ///< columns of each block
  std::vector<std::size_t> value;  ///< PointBlocks::value in the matrix of FindBlocks
  /// N' J_c, row by row, and N' e; N completes Q to an orthonormal basis of the point's rows.
  std::vector<double> rest, rest_e;
  std::vector<double> basis;
};

/// The kernels of this machine.
[[nodiscard]] inline const ProductKernels& Kernels() {
  static const ProductKernels& kernels = KernelsOfThisMachine();
  return kernels;
}

/// Puts a block where it belongs in an ascending list of distinct ones.
inline void InsertBlock(int id, std::vector<int>* blocks) {
  std::size_t at = blocks->size();
  while (at > 0 && (*blocks)[at - 1] > id) --at;
  if (at > 0 && (*blocks)[at - 1] == id) return;
  if (at == blocks->size()) {  // looks mostly come in the order of their passes
    blocks->push_back(id);
  } else {
    blocks->insert(blocks->begin() + static_cast<std::ptrdiff_t>(at), id);
  }
}

/// The same for the blocks of a look.
inline void InsertBlocks(const LookColumns& look, std::vector<int>* blocks) {
  for (int b = 0; b < look.block_count; ++b) {
    InsertBlock(look.block[static_cast<std::size_t>(b)], blocks);
  }
}

/// Finds the blocks of J_c and their columns.
void FindColumns(const ParameterLayout& layout, const PointFactor& factor, PointColumns* columns);

/// The columns of the blocks given in columns->blocks.
void PlaceColumns(const ParameterLayout& layout, PointColumns* columns);

/// Finds where the blocks stand in a matrix of the block's pattern, after FindColumns.
[[nodiscard]] PointBlocks FindBlocks(const ParameterLayout& layout,
                                     const BlockPattern& pattern,
                                     PointTerms* terms);

/// The same with the slots of the pattern in place of first values.
[[nodiscard]] PointBlocks FindSlots(const ParameterLayout& layout,
                                    const BlockPattern& pattern,
                                    PointTerms* terms);

/// out (`terms` rows over the columns) += B' J_c, B `terms` columns of row_count rows.
void AddTurnedColumns(const ParameterLayout& layout,
                      const PointFactor& factor,
                      const PointColumns& columns,
                      const double* b,
                      int terms,
                      double* out);

/// What elimination leaves of the equations, after FindColumns: N' J_c and N' e, with the digits of
/// J_c itself, however thin the intersection. The point adds (N' J_c)' (N' J_c) to S. row_count
/// must be 3 at least.
void TurnToRest(const ParameterLayout& layout, const PointFactor& factor, PointTerms* terms);

/// sum_i a_i b_i over m numbers, four sums side by side: a chain of additions as long as the rows
/// would wait on each of them.
[[nodiscard]] inline double Dot(std::size_t m, const double* a, const double* b) {
  double s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0;
  std::size_t i = 0;
  for (; i + 4 <= m; i += 4) {
    s0 += a[i] * b[i];
    s1 += a[i + 1] * b[i + 1];
    s2 += a[i + 2] * b[i + 2];
    s3 += a[i + 3] * b[i + 3];
  }
  for (; i < m; ++i) s0 += a[i] * b[i];
  return (s0 + s2) + (s1 + s3);
}

/// J'J and J'e of a point, the two rows of a look side by side.
class PointSums {
 public:
  PointSums() {
    for (Eigen::Array2d& sum : sums_) sum.setZero();
  }
  void Add(const Eigen::Matrix<double, 2, 3>& j, const Eigen::Vector2d& error_1) {
    const Eigen::Array2d j0 = j.col(0).array(), j1 = j.col(1).array(), j2 = j.col(2).array();
    const Eigen::Array2d e = error_1.array();
    sums_[0] += j0 * j0;
    sums_[1] += j1 * j1;
    sums_[2] += j2 * j2;
    sums_[3] += j0 * j1;
    sums_[4] += j0 * j2;
    sums_[5] += j1 * j2;
    sums_[6] += j0 * e;
    sums_[7] += j1 * e;
    sums_[8] += j2 * e;
  }
  void AddGradient(const Eigen::Matrix<double, 2, 3>& j, const Eigen::Vector2d& error_1) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      sums_[static_cast<std::size_t>(6 + c)] += j.col(c).array() * error_1.array();
    }
  }
  /// Rows beyond those of the control are zero.
  void Add(const ControlEvaluation& control) {
    Eigen::Matrix<double, 2, 3> last = Eigen::Matrix<double, 2, 3>::Zero();
    last.row(0) = control.by_point.row(2);
    Add(control.by_point.topRows<2>(), control.residual.head<2>());
    Add(last, {control.residual[2], 0.0});
  }
  [[nodiscard]] Eigen::Vector3d Diagonal() const { return Three(0); }
  /// (0, 1), (0, 2) and (1, 2) of J'J.
  [[nodiscard]] Eigen::Vector3d Above() const { return Three(3); }
  [[nodiscard]] Eigen::Vector3d Gradient() const { return Three(6); }

 private:
  [[nodiscard]] Eigen::Vector3d Three(std::size_t first) const {
    return {sums_[first].sum(), sums_[first + 1].sum(), sums_[first + 2].sum()};
  }
  std::array<Eigen::Array2d, 9> sums_;
};

/// R^-1 of an upper triangle.
[[nodiscard]] inline Eigen::Matrix3d InverseOfUpper(const Eigen::Matrix3d& r) {
  const double r00 = 1.0 / r(0, 0), r11 = 1.0 / r(1, 1), r22 = 1.0 / r(2, 2);
  const double r01 = -r00 * r(0, 1) * r11, r12 = -r11 * r(1, 2) * r22;
  const double r02 = -r00 * (r(0, 1) * r12 + r(0, 2) * r22);
  Eigen::Matrix3d inverse;
  inverse << r00, r01, r02, 0.0, r11, r12, 0.0, 0.0, r22;
  return inverse;
}

}  // namespace sarblock
