// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <vector>

#include "model/problem.h"
#include <Eigen/Core>
#include <Eigen/QR>

namespace sarblock::test {

/// All whitened equations of a block as one dense matrix, written without the elimination of
/// points: columns three a solved point (in order), then the corrections; rows looks, control,
/// priors. The second route of covariance and reduced system.
struct DenseEquations {
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd residual;
  std::vector<int> column_of_point;  ///< -1 where not solved
  int first_correction = 0;
};

/// The state of a result with the weights there; `problem` is one of the same block.
[[nodiscard]] BlockState StateOf(const AdjustResult& result, AdjustmentProblem* problem);

[[nodiscard]] DenseEquations MakeDenseEquations(const AdjustmentProblem& problem,
                                                const BlockState& state);

/// (J'J)^-1 by a QR factorisation in extended precision of J with unit columns.
[[nodiscard]] Eigen::MatrixXd DenseCovariance(const Eigen::MatrixXd& jacobian);

/// Expects a converged result, in `state`, to be the dense least-squares solution: a Gauss-Newton
/// step of less than `max_step` sigmas is left of each unknown, and v'Pv and the covariances of
/// points and corrections agree to 1e-9.
void ExpectDenseLeastSquares(const AdjustmentProblem& problem,
                             const BlockState& state,
                             const AdjustResult& result,
                             double max_step);

/// The frame-axes 3 x 3 matrix of an east-north-up one at p.
[[nodiscard]] Eigen::Matrix3d FrameFromEnu(const Frame& frame,
                                           const Eigen::Vector3d& p_m,
                                           const SymmetricEnu& enu_m2);

}  // namespace sarblock::test
