// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <vector>

#include "model/problem.h"
#include <Eigen/Core>

namespace sarblock::test {

/// The covariance of a small block with 50 digits from beginning to end, rounded at the end: the
/// observation equations of look_model_twin.h, their partials by central differences of 1e-15
/// (right to 1e-20 and better), all normal equations at once, a dense Cholesky factor and its
/// inverse. The weights are the problem's own, taken as exact. Every point is solved by looks that
/// all take part.
struct ExtendedCovariance {
  std::vector<Eigen::Matrix3d> points;  ///< by point, frame axes
  double condition = 0.0;               ///< of the Jacobian with unit columns: root of that of J'J
};
[[nodiscard]] ExtendedCovariance CovarianceInFiftyDigits(const AdjustmentProblem& problem,
                                                         const std::vector<CorrectionGroup>& groups,
                                                         const BlockState& state);

}  // namespace sarblock::test
