// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include <Eigen/Core>

namespace sarblock {

/// What one time contributes to a fit: the antenna by the q parameters of a format (`by_format`)
/// and by the n corrections of a result (`by_result`), as many rows each.
struct FitTime {
  Eigen::MatrixXd by_format, by_result;
};

/// The parameters of a format by least squares: of all q those that come nearest to what x
/// corrections do to the antenna at all times together,
///
///     sum_k |A_k q - J_k x|^2 = min,   q = G x,   G = (sum A_k' A_k)^-1 sum A_k' J_k
///
/// docs/export.md, eq. (1). Where the corrections are parameters of the format, J_k = A_k T, it is
/// T. Throws InputError where the times do not determine q.
[[nodiscard]] Eigen::MatrixXd FitParameters(std::span<const FitTime> times);

/// Largest standard deviation, over the times, of what the format does not hold: the root of the
/// largest trace of (J_k - A_k G) C (J_k - A_k G)' over its first `rows` rows, which are in metres.
[[nodiscard]] double UnfittedSigma_m(std::span<const FitTime> times,
                                     Eigen::Index rows,
                                     const Eigen::MatrixXd& fit,
                                     const Eigen::MatrixXd& covariance);

}  // namespace sarblock
