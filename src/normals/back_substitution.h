// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "elimination.h"
#include "model/problem.h"
#include <Eigen/Core>

namespace sarblock {

/// Displacements of the points after a step, and the decrease of the cost that the quadratic model
/// predicts of their part.
struct PointSteps {
  std::vector<Eigen::Vector3d> displacement_m;
  double predicted_decrease_1 = 0.0;
};

/// Step of every point for a step `dx` of the corrections:
///
///     dp = -V^-1 J_p' (e + J_c dx),   V = J_p' J_p + damping diag(J_p' J_p)
///
/// Thin intersections, whose V has lost digits, go through FactorPoint.
[[nodiscard]] PointSteps SubstituteBack(const AdjustmentProblem& problem,
                                        const BlockState& state,
                                        const Weighting& weighting,
                                        double damping_1,
                                        const Eigen::VectorXd& dx);

}  // namespace sarblock
