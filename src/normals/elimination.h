// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "model/problem.h"
#include "point_factor.h"
#include <Eigen/Core>

namespace sarblock {

/// False where the model has no value at this state.
[[nodiscard]] bool EvaluateWhitened(const AdjustmentProblem& problem,
                                    const BlockState& state,
                                    const Weighting& weighting,
                                    std::size_t point,
                                    std::size_t look,
                                    WhitenedLook* out);

/// A column of J_p shorter than this part (squared) of the longest is damped as if it had that
/// length.
inline constexpr double kLeastColumnPart_1 = 1e-12;

/// Evaluates and factors the equations of a point that takes part. A look without a value at this
/// state is counted and left out.
void FactorPoint(const AdjustmentProblem& problem,
                 const BlockState& state,
                 const Weighting& weighting,
                 double damping_1,
                 std::size_t point,
                 PointFactor* out);

/// Q' of a vector of the point's rows.
[[nodiscard]] Eigen::Vector3d Project(const PointFactor& factor, const std::vector<double>& rows);

/// Finds the blocks and T.
void ProjectColumns(const AdjustmentProblem& problem,
                    const PointFactor& factor,
                    PointColumns* columns);

/// Forms M after ProjectColumns, projected twice: what elimination leaves of the equations has the
/// digits of J_c itself, however thin the intersection. The point adds M' M to S.
void Complement(const AdjustmentProblem& problem, const PointFactor& factor, PointColumns* columns);

/// Evaluates the looks of a point that take part into out->looks.
void EvaluateLooks(const AdjustmentProblem& problem,
                   const BlockState& state,
                   const Weighting& weighting,
                   std::size_t point,
                   PointFactor* out);

/// Second-order weighting of a look under a robust loss (after Triggs et al. 2000, with a floor):
/// rows keep their weight across the residual and get the loss's own curvature along it; the errors
/// are rescaled so that the gradient stays what it is.
void BendAlongResidual(WhitenedLook* look);

/// R of V = R' R by Cholesky and the inverses of its diagonal; V by its diagonal and the elements
/// (0, 1), (0, 2) and (1, 2) above it. False for an intersection so thin that V = J'J has lost
/// digits that J still has.
[[nodiscard]] bool FactorNormal(const Eigen::Vector3d& diagonal,
                                const Eigen::Vector3d& above,
                                bool damped,
                                Eigen::Matrix3d* r,
                                Eigen::Vector3d* inverse);

}  // namespace sarblock
