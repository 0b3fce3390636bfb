// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <functional>
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
  Eigen::VectorXd square;      ///< v_k' P v_k
  Eigen::VectorXd redundancy;  ///< tr R_kk
  /// Helmert's matrix, H_kl = sum of R_ij^2 over i in k, j in l.
  Eigen::MatrixXd helmert;
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

/// Largest standard deviation of an estimated variance, as part of the variance, that is accepted:
/// a component of its own then has a redundancy of 8 at least. Beyond it the component is fixed.
inline constexpr double kMaxVarianceDeviation = 0.5;

/// The components that the options ask for: range and azimuth of all passes, of each pass, or of
/// each of `variance_groups` and, together, of the passes named in none. Nothing estimated yet.
/// Throws InputError for groups that do not fit.
[[nodiscard]] std::vector<VarianceComponent> ListVarianceComponents(const AdjustOptions& options,
                                                                    const Block& block);

/// Functions of the surrounding adjustment that the estimation calls.
struct VarianceSteps {
  /// Solves again from the state, with the weights the problem now has.
  std::function<void()> solve;
  /// Leaves out what a robust solution found far off; empty without a loss. Taken back afterwards.
  std::function<void()> drop_outliers;
};

/// Variance components by Foerstner's iteration, finished by Helmert's equations
/// (docs/theory/variance_components.md, eq. (7)-(10)):
///
///     sigma_k^2 <- sigma_k^2 v_k' P v_k / r_k,   then   sigma^2 <- sigma^2 (1 + 0.6 H^-1 (v'Pv -
///     r))
///
/// the second only where no element falls below half: variances stay positive. Ends when the step
/// size is below a hundredth of the standard deviation of each, which come from 2 H^-1. A
/// component whose standard deviation exceeds kMaxVarianceDeviation keeps its factor 1 and gets
/// a note. From a solved state; leaves `problem` with the new weights and `state` solved with them.
[[nodiscard]] VarianceComponentReport EstimateVarianceComponents(const AdjustOptions& options,
                                                                 const VarianceSteps& steps,
                                                                 AdjustmentProblem* problem,
                                                                 BlockState* state,
                                                                 ProgressSink* progress);

/// Reports which variance components were fixed and whether the others converged.
void WarnOfComponents(const VarianceComponentReport& report, AdjustResult* result);

}  // namespace sarblock
