// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "model/problem.h"
#include "normals/point.h"
#include <Eigen/Core>

namespace sarblock {

/// R^-1 of a point, and Y = (R^-1 T)' spread over all n corrections (n x 3), unless `full` has no
/// column: with C the covariance of the corrections, cov(p_a, p_b) = Y_a' C Y_b for a != b and
/// cov(p_a) = R^-1 R^-T + Y_a' C Y_a (docs/theory/covariance.md). `factor` and `columns` are
/// storage, reused from point to point.
[[nodiscard]] Eigen::Matrix3d SpreadPoint(const AdjustmentProblem& problem,
                                          const BlockState& state,
                                          std::size_t point,
                                          PointFactor* factor,
                                          PointColumns* columns,
                                          Eigen::Ref<Eigen::MatrixXd> full);

}  // namespace sarblock
