// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <string>
#include <vector>

#include "linear/block_cholesky.h"
#include "model/problem.h"
#include "normals/reduced_system.h"
#include "rank_report.h"
#include <Eigen/Core>

namespace sarblock {

/// Factors the reduced matrix and finds its null and nearly null directions, without a dense
/// decomposition of it: subspace iteration on the factor, with the diagonal lifted by 1e-9 where S
/// has none. `scaled` is S in units of `scale` (parameter = scale x scaled parameter), its diagonal
/// one but where elimination took all of it. Where the report is regular, `factor` holds the factor
/// of `scaled`. `state`, if given, lets the report name the point each direction moves most.
[[nodiscard]] RankReport AnalyseRank(const AdjustmentProblem& problem,
                                     const BorderedMatrix& scaled,
                                     const Eigen::VectorXd& scale,
                                     const BlockState* state,
                                     BorderedCholesky* factor);

/// Throws UndeterminedError with the words of the report and of `structure` (block_structure.h)
/// unless the report is regular.
void RequireRegular(const AdjustmentProblem& problem,
                    const RankReport& report,
                    const std::vector<std::string>& structure = {});

/// One warning for each nearly undetermined direction.
void WarnOfWeakDirections(const RankReport& rank, AdjustResult* result);

/// Factors the scaled S of a system that was formed and tells what it does not determine. Only a
/// regular report leaves a factor to work with. `state`, where given, lets the report name the
/// points that move.
[[nodiscard]] RankReport FactorAndAnalyse(ReducedSystem* system, const BlockState* state = nullptr);
/// The same; throws UndeterminedError in the words of the report unless it is regular.
RankReport FactorRegular(ReducedSystem* system);

/// Directions of the corrections that nothing determines, as columns in the parameters' units;
/// n x 0 where S is regular. Leaves no factor to work with unless it is.
[[nodiscard]] Eigen::MatrixXd NullSpace(ReducedSystem* system);

}  // namespace sarblock
