// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "model/look_model.h"
#include "model/problem.h"
#include <Eigen/Core>

namespace sarblock {

/// How looks are weighted in a linearisation.
struct Weighting {
  RobustLoss loss = RobustLoss::kNone;
  double scale = 0.0;
  /// The solver's last steps under a loss: take its curvature along the residual for what it is.
  bool second_order = false;
  /// Where given, looks are weighted as UpdateWeights would at this state, and their weights put
  /// here, by look. Else by the problem's.
  std::vector<LookWeights>* renewed = nullptr;
};

/// One look at one state, weighted: its two equations are standard normal if the model is true.
/// Under a robust loss both carry the square root of the look's weight.
struct WhitenedLook : LookEvaluation {
  std::size_t look = 0;  ///< index in the block
  LookColumns columns;
  double cost_1 = 0.0;    ///< half the squared length, robust loss applied
  double radial_1 = 1.0;  ///< RobustValue::radial_1
};

/// The equations of one point and the thin QR factorisation of their Jacobian by the point
/// (docs/theory/covariance.md, eq. (22)):
///
///     J_p = Q R,   c = Q' e;   two rows a look in use, the rows of its control, then, if damped,
///                              three rows sqrt(damping J_p' J_p)
///
/// J_c stays with the looks, each its own columns: this is what the solver, the covariance and the
/// quality figures are made of. The storage is reused from point to point.
struct PointFactor {
  std::vector<WhitenedLook> looks;  ///< the first look_count are set; rows 2 k and 2 k + 1
  int look_count = 0;
  int looks_not_evaluated = 0;
  int looks_beyond_path = 0;  ///< that read a path continued beyond its ends
  double cost_1 = 0.0;        ///< half the square sum, robust loss applied

  int row_count = 0;
  std::vector<double> q;  ///< row_count x 3, column by column
  std::vector<double> e;  ///< row_count
  Eigen::Matrix3d r = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< J_p' e, undamped
  Eigen::Vector3d square_1 = Eigen::Vector3d::Zero();  ///< squared lengths of J_p's columns
  /// 1 / condition of J_p with its columns scaled to unit length (Frobenius norms, so 1/3 at most);
  /// 0 where a column vanishes or there are fewer than three rows; not computed when damped.
  double reciprocal_condition_1 = 0.0;

  [[nodiscard]] Eigen::Vector3d RowOfQ(int row) const {
    const auto i = static_cast<std::size_t>(row), m = static_cast<std::size_t>(row_count);
    return {q[i], q[m + i], q[2 * m + i]};
  }
};

/// J_c of a point over the distinct parameter blocks its looks touch.
struct PointColumns {
  std::vector<int> blocks;  ///< ascending
  std::vector<int> begin;   ///< first column of each
  int width = 0;            ///< columns of J_c
  /// T = Q' J_c, 3 x width, row by row.
  std::vector<double> t;
  /// Row by row, row_count x (width + 1): the complement M = (I - Q Q') [J_c | e]; filled by
  /// Complement.
  std::vector<double> m;

  std::vector<int> column_of_block;  ///< by parameter block; valid for those in `blocks`
  std::vector<double> scratch;
};

}  // namespace sarblock
