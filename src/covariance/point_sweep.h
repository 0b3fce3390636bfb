// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/result.h"

#include <vector>

#include "model/problem.h"
#include "normals/back.h"
#include "normals/reduced_system.h"
#include <Eigen/Core>

namespace sarblock {

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
/// C = S^-1 on the pattern of S (`inverse`), which holds every block a point needs. Without
/// corrections (`inverse` null) or for flight paths held: R^-1 R^-T.
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
  Eigen::Vector2d error_1 = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> information_1;  ///< its rows of Q
  Eigen::Matrix2d adjusted_1;                 ///< covariance of the adjusted look
  Eigen::Matrix<double, 3, 2> shift_m;        ///< of the point by one sigma in each
};

/// The figures of SweepPoints of the looks of a point that takes part, in their order.
[[nodiscard]] std::vector<LookCovariance> CovariancesOfLooks(const AdjustmentProblem& problem,
                                                             const BlockState& state,
                                                             const CorrectionCovariance* inverse,
                                                             std::size_t point);

/// Reliability of the held components of control points, from their covariances.
[[nodiscard]] std::vector<ControlQuality> ControlQualities(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const std::vector<SymmetricEnu>& covariance_m2);

}  // namespace sarblock
