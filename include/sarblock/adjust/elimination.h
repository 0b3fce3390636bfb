// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/problem.h"
#include "sarblock/adjust/robust.h"

#include <array>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// How looks are weighted in a linearisation.
struct Weighting {
  RobustLoss loss = RobustLoss::kNone;
  double scale = 0.0;
  /// The solver's last steps under a loss: take its curvature along the residual for what it is.
  bool second_order = false;
};

/// One look at one state, whitened: its two equations are standard normal if the model is true.
/// Under a robust loss both carry the square root of the look's weight.
struct WhitenedLook {
  LookColumns columns;
  Eigen::Matrix<double, 2, 3> by_point;
  Eigen::Vector2d error_1;
  /// Rows of the Jacobian by the look's local columns; the first column_count are set.
  std::array<double, ParameterLayout::kMaxLocalColumns> range_row, doppler_row;
  double cost_1 = 0.0;    ///< half the squared length, robust loss applied
  double radial_1 = 1.0;  ///< RobustValue::radial_1
};

/// False where the model has no value at this state.
[[nodiscard]] bool EvaluateWhitened(const AdjustmentProblem& problem,
                                    const BlockState& state,
                                    const Weighting& weighting,
                                    std::size_t point,
                                    std::size_t look,
                                    WhitenedLook* out);

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

/// A column of J_p shorter than this part (squared) of the longest is damped as if it had that
/// length.
inline constexpr double kLeastColumnPart_1 = 1e-12;

}  // namespace sarblock
