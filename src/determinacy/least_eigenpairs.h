// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "linear/block_cholesky.h"
#include <Eigen/Core>

namespace sarblock {

/// Least eigenvalues of a symmetric matrix, ascending, with orthonormal eigenvectors as columns.
struct LeastEigenpairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

struct LeastEigenpairOptions {
  int count = 6;  ///< pairs wanted; fewer for a smaller matrix
  /// Pairs below this value, and always the first, have to settle.
  double settle_below_1 = 0.0;
  double relative_change_1 = 1e-2;  ///< from step to step: settled
  double rounding_1 = 1e-15;        ///< values below it are settled whatever they do
  int most_steps = 40;
};

/// Several least eigenpairs of `matrix` at once by inverse iteration of a subspace with
/// Rayleigh-Ritz steps, never by a dense decomposition of it: with X orthonormal,
///     X <- orth(F^-1 X),   X' S X = U diag(values) U',   X <- X U
/// (Golub and Van Loan, Matrix Computations, 8.2.4). `factor` holds F = S, or S with its diagonal
/// lifted a little where S itself cannot be factored; values are Rayleigh quotients of S either
/// way, never below the true ones but for rounding of 1e-16 times the largest. A step costs
/// `count` solutions, made together. Deterministic start; docs/theory/rank.md, section 2.
[[nodiscard]] LeastEigenpairs FindLeastEigenpairs(const BorderedMatrix& matrix,
                                                  const BorderedCholesky& factor,
                                                  const LeastEigenpairOptions& options = {});

/// Largest eigenvalue by power iteration to a relative change of 1e-3 or 200 steps: never above
/// the true one but for rounding. 0 for an empty matrix.
[[nodiscard]] double LargestEigenvalue(const BorderedMatrix& matrix);

}  // namespace sarblock
