// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/problem.h"
#include "normals/back.h"
#include "normals/point.h"
#include "normals/reduced_system.h"
#include <Eigen/Core>

namespace sarblock {

/// R^-1 of a point, and Y = (R^-1 T)' spread over all n corrections (n x 3), unless `full` has no
/// column: with C the covariance of the corrections, cov(p_a, p_b) = Y_a' C Y_b for a != b and
/// cov(p_a) = R^-1 R^-T + Y_a' C Y_a (docs/theory/covariance.md). `factor` and `columns` are
/// storage, reused from point to point.
[[nodiscard]] Eigen::Matrix3d PointSensitivity(const AdjustmentProblem& problem,
                                               const BlockState& state,
                                               std::size_t point,
                                               PointFactor* factor,
                                               PointColumns* columns,
                                               Eigen::Ref<Eigen::MatrixXd> full);

/// A covariance in frame axes [m2] as east, north, up at p.
[[nodiscard]] SymmetricEnu ToEnu(const Frame& frame,
                                 const Eigen::Vector3d& p_m,
                                 const Eigen::Matrix3d& covariance_m2);

/// What a sweep over the points at the solution answers. All of it comes from one evaluation of
/// every look.
struct PointSweep {
  std::vector<SymmetricEnu> covariance_m2;  ///< by point; NaN where not solved
  LookQuality quality;                      ///< empty unless asked for
  std::vector<double> redundancy;           ///< by point, the sum over its looks; like quality
};

/// Covariance of every solved point in east-north-up at the point, exact marginals of the whole
/// adjustment: with the factorisation of the point (normals/point.h) and T = Q' J_c
///
///     cov(p) = R^-1 (I + T C T') R^-T
///
/// C = S^-1 on the pattern of S (`inverse`), which has every block a point needs. Without
/// corrections (`inverse` null) or for fixed flight paths: R^-1 R^-T.
/// model.md, section 7; docs/theory/covariance.md, eqs. (22) to (24).
///
/// With `quality` the reliability of every look as well (docs/theory/quality.md), from the same
/// products: the covariance of the adjusted look i is
///
///     a_i C a_i' = q_i (I + T C T') q_i' - 2 (j_i C T') q_i' + j_i C j_i'
///
/// in a form that keeps its digits where flight paths are weakly determined. Parallel over points.
/// `kept`: factors of the same state and weights, which give the same result to the bit.
[[nodiscard]] PointSweep SweepPoints(const AdjustmentProblem& problem,
                                     const BlockState& state,
                                     const CorrectionCovariance* inverse,
                                     bool quality,
                                     ProgressSink* progress,
                                     const KeptFactors* kept = nullptr);

/// One look at the solution, its two components in units of their standard deviations.
struct LookCovariance {
  std::size_t look = 0;
  Eigen::Vector2d whitened_error = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> information;  ///< its rows of Q
  Eigen::Matrix2d adjusted_covariance;      ///< covariance of the adjusted look
  Eigen::Matrix<double, 3, 2> shift_m;      ///< of the point by one sigma in each
};

/// The figures of SweepPoints of the looks of a point that takes part, in their order.
[[nodiscard]] std::vector<LookCovariance> CovariancesOfLooks(const AdjustmentProblem& problem,
                                                             const BlockState& state,
                                                             const CorrectionCovariance* inverse,
                                                             std::size_t point);

/// Reliability of the fixed components of control points, from their covariances.
[[nodiscard]] std::vector<ControlQuality> ControlQualities(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const std::vector<SymmetricEnu>& covariance_m2);

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
  Eigen::VectorXd v;
  Eigen::MatrixXd q_vv;
  /// What the corrections, and so other points, take of each residual: the diagonal of
  /// Q2 B C B' Q2'.
  Eigen::VectorXd corrections_share;
  /// Q1: what each observation adds to the information on the point, corrections fixed; the rows'
  /// squares add to I.
  Eigen::MatrixX3d information;
  /// Shift of the point by one sigma in each observation, 3 rows, frame axes [m].
  Eigen::Matrix3Xd shift_m;

  [[nodiscard]] Eigen::Index size() const { return v.size(); }
  /// v / sqrt(r); NaN where there is no redundancy.
  [[nodiscard]] double w(Eigen::Index i) const;
  /// Correlation of w(i) and w(k).
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

/// Looks, residuals and information of a point, the rest empty: without the square of its rows.
[[nodiscard]] PointResiduals InformationOfPoint(const AdjustmentProblem& problem,
                                                const BlockState& state,
                                                std::size_t point);

/// Warns of looks that are weighted finer than double precision carries coordinates: one rounding
/// of the largest coordinate behind an equation (point, antenna, range; with a time bias the way
/// flown in one rounding of the time) as a part of its standard deviation. What is above a
/// ten-thousandth may move the point by a thousandth of its sigma. Control may be as tight as it
/// likes: it holds its point to the given coordinates themselves.
void WarnOfRounding(const AdjustmentProblem& problem,
                    const BlockState& state,
                    AdjustResult* result);

/// Covariance that every point would have if the corrections were known exactly: what the noise of
/// its own looks (and its control) leaves, R^-1 R^-T of docs/theory/covariance.md, eq. (22), at the
/// solution of `result`. What the point's covariance holds beyond it comes from the flight paths.
/// East, north, up; NaN where a point is not solved. Not scaled by the posterior factor.
///
/// Empty where that split has no meaning or no use: without corrections, without a covariance of
/// the whole adjustment and with estimated variance components (the weights of `block` are not
/// those of the result). It has none either with an inner datum, which takes out motions that
/// points and paths share. `groups` are the correction groups that the result was made with.
[[nodiscard]] std::vector<SymmetricEnu> FixedPathCovariances(
    const Block& block, const std::vector<CorrectionGroup>& groups, const AdjustResult& result);

}  // namespace sarblock
