// SPDX-License-Identifier: Apache-2.0
// Exact covariances of the unknowns of a ceres::Problem, whatever its residuals are. CMake:
// sarblock::cost.
//
//     std::vector<double*> points;  // blocks of the ceres::Problem
//     for (Eigen::Vector3d& point : points_m) points.push_back(point.data());
//     const sarblock::ProblemCovariance covariance(problem, points);
//     Eigen::Matrix3d of_point;  // symmetric: rows or columns
//     covariance.Get(points[0], points[0], of_point.data());
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace ceres {
class Problem;
}

namespace sarblock {

/// How a ProblemCovariance is computed.
struct ProblemCovarianceOptions {
  /// Residuals and Jacobians as the losses of the problem weight them, as the solver and
  /// ceres::Covariance do.
  bool apply_loss_function = true;
  int threads = 0;  ///< for the Jacobian and all later steps; 0: all cores
  /// What messages call a parameter block. Without it, and where it returns nothing: "point 12" or
  /// "block 3", the place in `points` or, of the others, in the order in which residuals name them.
  std::function<std::string(const double* block)> name;
};

/// (J' J)^-1 of a ceres::Problem at the present values of its parameter blocks: J the Jacobian of
/// its residuals, which are in standard deviations, in the tangent space of blocks with a manifold.
/// Not scaled by the residuals.
///
/// The blocks named as points are eliminated one by one, each with a QR of its own rows
/// (docs/theory/covariance.md, eq. (22)); what is left are the equations of the others, whose
/// Cholesky factor and selected inverse (Takahashi) follow the blocks that points and residuals
/// connect. Nothing is approximated, and time and memory grow with the points and with the fill of
/// the factor, not with the square of the unknowns. Points may be any numerous blocks of which no
/// two share a residual: the points of a bundle block, tie points of radar, depths.
///
/// It keeps what it needs: the problem may change or end afterwards. All functions are const and
/// may be called by several threads.
class ProblemCovariance {
 public:
  /// Evaluates the Jacobian, eliminates, factors and inverts.
  ///
  /// Throws InputError where a point is no block of the problem, is there twice or shares a
  /// residual with another; where a block is held by bounds (such an unknown has no normal
  /// distribution); where a residual has no value or a Jacobian is not finite. Throws
  /// UndeterminedError where the residuals do not determine a point (its rows, columns scaled to
  /// unit length, have a condition above 1e12) or the other blocks (their equations, scaled to unit
  /// diagonal, have an eigenvalue below 1e-12); its names() are those of the blocks that can move
  /// together. Near these limits results have four correct digits.
  ProblemCovariance(ceres::Problem& problem,
                    std::span<double* const> points,
                    const ProblemCovarianceOptions& options = {});
  ~ProblemCovariance();
  ProblemCovariance(ProblemCovariance&&) noexcept;
  ProblemCovariance& operator=(ProblemCovariance&&) noexcept;

  /// Covariance of two blocks, row by row, as many rows as `a` and columns as `b` have values; with
  /// a manifold in the space around it, where it is singular. Zero for a block that was constant.
  ///
  /// At once for a point and itself, a point and a block that it has residuals with, and two blocks
  /// with a residual or a point in common. Any other pair takes a solution with the factor for each
  /// tangent direction of `b`: for many of them begin with the block that is the same in all (`b`).
  ///
  /// Throws InputError where one of them was no block of the problem.
  void Get(const double* a, const double* b, double* values) const;
  /// The same in the tangent spaces.
  void GetInTangentSpace(const double* a, const double* b, double* values) const;

  [[nodiscard]] std::size_t rows() const;      ///< residuals
  [[nodiscard]] std::size_t unknowns() const;  ///< of all blocks that are not constant, tangent

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sarblock
