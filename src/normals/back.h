// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/problem.h"
#include "pieces.h"
#include "point.h"
#include <Eigen/Core>

namespace sarblock {

/// The factors of all points of one linearisation, kept from the sum of S to the sweep over the
/// points, so that a look is evaluated once for both (BytesFor). Large blocks recompute them
/// instead, to the same bits, or to the last digit where weights were formed on the way.
class KeptFactors {
 public:
  /// Memory that may be kept: 29,000 points of five looks, six parameters.
  static constexpr std::size_t kMaxBytes = std::size_t{48} << 20;

  /// `bytes`: the result of BytesFor for them, allocated at once.
  KeptFactors(std::size_t points, std::size_t parts, std::size_t bytes);

  /// Keeps the undamped factor of a point and its T (ProjectColumns); one thread a part. A point
  /// with a look that has no value is not kept.
  void Keep(std::size_t part,
            std::size_t point,
            const PointFactor& factor,
            const PointColumns& columns);

  /// Among ranks (core/ranks.h) every rank has all parts afterwards. Part k has the points of piece
  /// k and was kept by rank `rank_of_part[k]`. Factors computed anew at weights that were formed on
  /// the way (Weighting::renewed) would differ in their last digit.
  void Share(const PointPieces& pieces, const std::vector<int>& rank_of_part);

  /// R, the blocks of a point with their columns, and T, 3 x width row by row, in the memory it was
  /// kept in. Null for a point that was not kept or has another number of looks now.
  [[nodiscard]] const double* Restore(const AdjustmentProblem& problem,
                                      std::size_t point,
                                      Eigen::Matrix3d* r,
                                      PointColumns* columns) const;

  /// The results of FactorPoint that the quality figures read, for a point that Restore knows: Q,
  /// R, e and of every look its index, columns, rows and whitened_error.
  void RestoreLooks(const AdjustmentProblem& problem, std::size_t point, PointFactor* out) const;

  /// Memory for points with so many looks and local columns of looks together.
  [[nodiscard]] static std::size_t BytesFor(std::size_t points,
                                            std::size_t looks,
                                            std::size_t columns) {
    return sizeof(double) * (26 * points + 8 * looks + 5 * columns);
  }

 private:
  static constexpr std::size_t kNone = 0;  // a part's first number is not a point's
  struct Place {
    std::size_t number = kNone;  // in its part's numbers
    std::size_t block = 0;       // in its part's blocks
    std::uint32_t part = 0;
    std::uint16_t looks = 0, blocks = 0;
  };
  struct Part {
    std::vector<double> numbers;
    std::vector<int> blocks;
  };
  std::vector<Place> places_;  // by point
  std::vector<Part> parts_;
};

/// Displacements of the points after a step, and the decrease of the cost that the quadratic model
/// predicts of their part.
struct PointSteps {
  std::vector<Eigen::Vector3d> displacement_m;
  double predicted_decrease = 0.0;
};

/// Step of every point for a step `dx` of the corrections:
///
///     dp = -V^-1 J_p' (e + J_c dx),   V = J_p' J_p + damping diag(J_p' J_p)
///
/// Thin intersections, whose V has lost digits, go through FactorPoint.
[[nodiscard]] PointSteps SubstituteBack(const AdjustmentProblem& problem,
                                        const BlockState& state,
                                        const Weighting& weighting,
                                        double damping,
                                        const Eigen::VectorXd& dx);

/// Nonlinear part of the errors after a step, as a right side of S: with the errors e of the looks,
/// whitened by the weights at `state`, and the steps dp of the points for dx (SubstituteBack),
///
///     d = e(x + dx, p + dp) - e - J_c dx - J_p dp,   J_c' d - J_c' J_p V^-1 J_p' d
///
/// to second order half their second derivative along the step, and -S^-1 of it half the geodesic
/// acceleration of Transtrum and Sethna (2012), arXiv:1201.5885. `dx`: step of the corrections, as
/// many as S has rows, one at least. A look without a value there adds nothing.
[[nodiscard]] Eigen::VectorXd BendOfStep(const AdjustmentProblem& problem,
                                         const BlockState& state,
                                         const Weighting& weighting,
                                         double damping,
                                         const Eigen::VectorXd& dx);

/// A point of a sample and the number of points that it represents.
struct SampledPoint {
  std::size_t point = 0;
  double weight = 1.0;
};

/// dx' BendOfStep() of each column dx of `steps`, undamped and without a loss, as a sum over
/// points.
[[nodiscard]] Eigen::VectorXd BendsAlongSteps(const AdjustmentProblem& problem,
                                              const BlockState& state,
                                              const Eigen::MatrixXd& steps,
                                              const std::vector<SampledPoint>& points);

}  // namespace sarblock
