// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/look_equations.h"

#include <limits>
#include <span>

#include <Eigen/Core>

namespace sarblock::internal {

/// The whitened equations of all looks at one point, reduced to a triangle: J = Q R, Q'e = z.
/// Rows are rotated in one at a time, so that nothing is allocated for any number of looks.
struct Triangle {
  Eigen::Matrix3d r = Eigen::Matrix3d::Zero();  ///< upper triangular [1/m]
  Eigen::Vector3d z = Eigen::Vector3d::Zero();
  double rest = 0.0;  ///< norm of the part of e that no displacement changes

  void Absorb(const Eigen::RowVector3d& row, double error);
  [[nodiscard]] double SquareSum() const { return z.squaredNorm() + rest * rest; }
};

/// A converged candidate point, relative to the origin.
struct Candidate {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d r = Eigen::Matrix3d::Zero();  ///< triangle of the whitened Jacobian [1/m]
  double square_sum = std::numeric_limits<double>::infinity();
  int iterations = 0;
  bool converged = false;
  bool determined = false;
  bool firmly = false;  ///< determined by a wide margin
};

/// Gauss-Newton, then damped Newton, from a start point: weights from the start, formed again once
/// at convergence. docs/theory/intersection.md, section 3 and 4.
[[nodiscard]] Candidate Refine(std::span<const FixedPathLook> observations,
                               const Eigen::Vector3d& origin_m,
                               const Eigen::Vector3d& start_m,
                               double max_step_m,
                               const IntersectionOptions& options);

/// (R'R)^-1 for a non-singular triangle.
[[nodiscard]] Eigen::Matrix3d CovarianceOf(const Eigen::Matrix3d& r);

}  // namespace sarblock::internal
