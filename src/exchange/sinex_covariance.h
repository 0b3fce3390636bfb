// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "export_view.h"
#include <Eigen/Core>

namespace sarblock {

/// Covariances of the exported points in frame axes.
struct SinexCovariance {
  /// Of two different points, by their places in ExportView::points, row > column.
  struct Cross {
    std::size_t row = 0;
    std::size_t column = 0;
    Eigen::Matrix3d covariance_m2;  ///< rows those of `row`
  };
  std::vector<Eigen::Matrix3d> own;
  std::vector<Cross> cross;  ///< sorted by row, then column; empty if not asked for
};

/// Own covariances from points.csv and, of the pairs in pairs.csv, the symmetric part of the cross
/// covariance:
///
///     (Q_ab + Q_ab') / 2 = (Q_a + Q_b - cov(b - a)) / 2
///
/// All that the covariance of a difference tells; differences of the two points get exactly the
/// covariance of the table back. Throws InputError where the matrix is not positive definite so,
/// which it need not be while covariances of other pairs are not given and count as zero.
[[nodiscard]] SinexCovariance FormCovariance(const ExportView& view);

}  // namespace sarblock
