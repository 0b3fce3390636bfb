// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/problem.h"
#include "sarblock/adjust/robust.h"

#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// How looks are weighted in a linearisation.
struct Weighting {
  RobustLoss loss = RobustLoss::kNone;
  double scale = 0.0;
};

/// All whitened equations of one point at one state:
///
///     A = [ J_p | J_c | e ],   2 rows a look in use, then the rows of its control
///
/// with the columns of J_c those of the parameter blocks the point's looks touch. Under a robust
/// loss the rows of a look carry the square root of its weight. This is what the solver, the
/// covariance and the quality figures are made of. The storage is reused from point to point.
struct PointRows {
  Eigen::MatrixXd a;  ///< at least row_count x (3 + column_count + 1)
  int row_count = 0;
  int column_count = 0;           ///< of J_c
  std::vector<int> blocks;        ///< distinct parameter blocks, ascending
  std::vector<int> block_column;  ///< first column of each within J_c
  double cost_1 = 0.0;            ///< half the square sum, robust loss applied
  int looks_not_evaluated = 0;

  std::vector<int> slot_of_block;  ///< scratch: by parameter block
};

/// Fills `rows` for a point that takes part. A look without a value at this state is counted and
/// left out.
void LinearisePoint(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const Weighting& weighting,
                    std::size_t point,
                    PointRows* rows);

/// What the elimination of a point leaves, docs/theory/covariance.md eq. (3)-(6): with the thin QR
/// factorisation J_p = Q1 R and Q2 the orthogonal complement,
///     R [3 x 3] upper, T = Q1' J_c [3 x columns], c = Q1' e,
/// and in rows 3.. of rows->a the reduced equations Q2' [J_c | e].
struct EliminatedPoint {
  Eigen::Matrix3d r = Eigen::Matrix3d::Zero();
  /// 1 / condition of J_p with its columns scaled to unit length; 0 where a column vanishes.
  double reciprocal_condition_1 = 0.0;
};

/// Householder elimination in place: afterwards rows 0..2 of rows->a hold [R | T | c].
[[nodiscard]] EliminatedPoint EliminatePoint(PointRows* rows);

/// The same applied to J_p and the columns from `first_column` of rows->a on only (3 + column_count
/// is the errors' column): a step of the point needs no T.
[[nodiscard]] EliminatedPoint EliminateColumns(PointRows* rows, Eigen::Index first_column);

/// Appends the damping of a point: rows sqrt(damping) |J_p column|. Returns the squared lengths of
/// the columns of J_p before. A column that vanishes gets the length 1e-6 of the largest.
Eigen::Vector3d DampPoint(double damping_1, PointRows* rows);

}  // namespace sarblock
