// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/elimination.h"
#include "sarblock/adjust/problem.h"

#include <array>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// The equations of one point as an iteration of the solver needs them: each look's own columns,
/// nothing where a look has no column. With the thin QR factorisation of the (damped) J_p,
///     J_p = Q R,  T = Q' J_c,  c = Q' e,
/// the point adds J_c' J_c - T' T to S. That subtraction costs digits where a point takes most of
/// what a correction's equations say; the solver only needs a good step. The final linearisation
/// uses the complement Q2 instead (EliminatePoint), which costs about twice as much.
/// Storage is reused from point to point.
struct ThinPoint {
  std::vector<WhitenedLook> looks;  ///< the first look_count are set
  int look_count = 0;
  int looks_not_evaluated = 0;
  double cost_1 = 0.0;

  int row_count = 0;
  std::vector<double> q;  ///< row_count x 3, column by column
  std::vector<double> e;  ///< row_count
  Eigen::Matrix3d r = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< J_p' e, undamped
  Eigen::Vector3d square = Eigen::Vector3d::Zero();    ///< squared lengths of J_p's columns
};

/// Evaluates the looks and control of a point, appends the damping rows and factors J_p.
void FactorThin(const AdjustmentProblem& problem,
                const BlockState& state,
                const Weighting& weighting,
                double damping_1,
                std::size_t point,
                ThinPoint* out);

/// Q' of a vector of the point's rows.
[[nodiscard]] Eigen::Vector3d Project(const ThinPoint& thin, const std::vector<double>& rows);

}  // namespace sarblock
