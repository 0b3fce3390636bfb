// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/result.h"

#include <optional>
#include <string>
#include <vector>

#include "linear/block_cholesky.h"
#include "model/problem.h"
#include "normals/reduced_system.h"
#include "weak_directions.h"
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
  double settle_below = 0.0;
  double relative_change = 1e-2;  ///< from step to step: settled
  double rounding = 1e-15;        ///< smaller values are settled
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

/// Factors the reduced matrix and finds its null and nearly null directions, without a dense
/// decomposition of it: subspace iteration on the factor, with the diagonal lifted by 1e-9 where S
/// has none. `scaled` is S in units of `scale` (parameter = scale x scaled parameter), with unit
/// diagonal except where elimination cancelled it. Where the report is regular, `factor` holds the
/// factor of `scaled`. `state`, if given, lets the report name the point each direction moves most.
[[nodiscard]] RankReport AnalyseRank(const AdjustmentProblem& problem,
                                     const BorderedMatrix& scaled,
                                     const Eigen::VectorXd& scale,
                                     const BlockState* state,
                                     BorderedCholesky* factor);

/// Throws UndeterminedError with the words of the report and of `structure` (structure.h)
/// unless the report is regular.
void RequireRegular(const AdjustmentProblem& problem,
                    const RankReport& report,
                    const std::vector<std::string>& structure = {});

/// One warning for each nearly undetermined direction.
void WarnOfWeakDirections(const RankReport& rank, AdjustResult* result);

/// Factors the scaled S of a system that was formed and reports what it does not determine. Only a
/// regular report leaves a factor to work with. `state`, where given, lets the report name the
/// points that move.
[[nodiscard]] RankReport FactorAndAnalyse(ReducedSystem* system, const BlockState* state = nullptr);
/// The same; throws UndeterminedError in the words of the report unless it is regular.
RankReport FactorRegular(ReducedSystem* system);

/// Directions of the corrections that nothing determines, as columns in the parameters' units;
/// n x 0 where S is regular. Leaves no factor to work with unless it is.
[[nodiscard]] Eigen::MatrixXd NullSpace(ReducedSystem* system);

/// Throws UndeterminedError if there is nothing that can be solved.
void RequireSolvable(const AdjustmentProblem& problem);

/// Forms the reduced system at a state, leaving out the points whose own equations turn out rank
/// deficient, with their reason.
void FormDetermined(const BlockState& state,
                    const Weighting& weighting,
                    AdjustmentProblem* problem,
                    std::optional<ReducedSystem>* system,
                    ProgressSink* progress);

}  // namespace sarblock
