// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/problem.h"
#include "normals/reduced_system.h"
#include <Eigen/Core>

namespace sarblock {

/// Residuals of one point in the measured components, each in units of its standard deviation, and
/// their exact covariance in the whole adjustment: range and azimuth of every look, in the order of
/// the block, then the rows of its known position (whitened by its covariance).
///
/// With J_p = Q1 R, B = Q2' J_c and C the covariance of the corrections,
///     Q_vv = Q2 (I - B C B') Q2'        (docs/theory/quality.md, eq. (4))
struct PointResiduals {
  std::vector<std::uint64_t> looks;
  std::size_t looks_of_point = 0;  ///< that take part
  int control_rows = 0;
  Eigen::VectorXd v_1;
  Eigen::MatrixXd q_vv_1;
  /// What the corrections, and so other points, take of each residual: the diagonal of
  /// Q2 B C B' Q2'.
  Eigen::VectorXd shared_1;
  /// Q1: what each observation adds to the information on the point, corrections held; the rows'
  /// squares add to I.
  Eigen::MatrixX3d information_1;
  /// Shift of the point by one sigma in each observation, 3 rows, frame axes [m].
  Eigen::Matrix3Xd shift_m;

  [[nodiscard]] Eigen::Index size() const { return v_1.size(); }
  /// v / sqrt(r); NaN where there is no redundancy.
  [[nodiscard]] double w_1(Eigen::Index i) const;
  /// Correlation of w_1(i) and w_1(k).
  [[nodiscard]] double Correlation(Eigen::Index i, Eigen::Index k) const;
};

/// `inverse` is that of the system at this state; null without corrections. A point that takes part
/// and is none of its bordered ones.
[[nodiscard]] PointResiduals ResidualsOfPoint(const AdjustmentProblem& problem,
                                              const BlockState& state,
                                              const CorrectionCovariance* inverse,
                                              std::size_t point);

/// The same of one look, where a point has too many for all of them (CorrectionCovariance).
[[nodiscard]] PointResiduals ResidualsOfLook(const AdjustmentProblem& problem,
                                             const BlockState& state,
                                             const CorrectionCovariance* inverse,
                                             std::size_t point,
                                             std::uint64_t look);

/// Looks, residuals and information_1 of a point, the rest empty: without the square of its rows.
[[nodiscard]] PointResiduals InformationOfPoint(const AdjustmentProblem& problem,
                                                const BlockState& state,
                                                std::size_t point);

}  // namespace sarblock
