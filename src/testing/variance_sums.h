// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "model/problem.h"
#include "normals/reduced_system.h"
#include <Eigen/Core>

namespace sarblock {

/// Sums over the looks of each component at a solution, in measured space (range and azimuth in
/// units of their standard deviations), with the matrix R = I - A C A' that turns errors into
/// residuals (docs/theory/variance_components.md, eq. (3)-(6)).
struct VarianceSums {
  std::vector<std::size_t> looks;
  Eigen::VectorXd square_1;      ///< v_k' P v_k
  Eigen::VectorXd redundancy_1;  ///< tr R_kk
  /// Helmert's matrix, H_kl = sum of R_ij^2 over i in k, j in l.
  Eigen::MatrixXd helmert_1;
};

/// `system` is factored at `state` without a loss. `component_of` gives by pass the components of
/// its range and azimuth, -1 for none. The part of H that couples different points through the
/// corrections is left out where it would need more than 256 MiB; H is then too small and the
/// standard deviations too large. Parallel over points; independent of the number of threads.
[[nodiscard]] VarianceSums SumVariances(const AdjustmentProblem& problem,
                                        const BlockState& state,
                                        const ReducedSystem& system,
                                        const std::vector<std::array<int, 2>>& component_of,
                                        std::size_t component_count);

}  // namespace sarblock
