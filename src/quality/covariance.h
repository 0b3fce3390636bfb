// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "model/problem.h"
#include "normals/reduced_system.h"
#include "solve/inner_datum.h"
#include <Eigen/Core>

namespace sarblock {

/// Covariances of corrections: the upper triangle of the whole matrix while there are at most
/// kFullParameterCovariance corrections, else of parameters whose passes see common points.
inline constexpr int kFullParameterCovariance = 1000;
[[nodiscard]] std::vector<ParameterCovariance> ParameterCovariances(
    const ReducedSystem& system, const CorrectionCovariance& inverse);

/// Differences b - a of the point pairs asked for, with exact covariances
///     cov(p_a) + cov(p_b) - cov(p_a, p_b) - cov(p_a, p_b)'
///     cov(p_a, p_b) = R_a^-1 T_a C T_b' R_b^-T
/// in east-north-up axes at a. Pairs with a point that is not solved are left out. `system` null:
/// flight paths fixed, points are independent.
[[nodiscard]] std::vector<PairResult> PairCovariances(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const ReducedSystem* system,
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs,
    ProgressSink* progress);

/// Effective number of independent components of the check points of a result: n^2 over the sum of
/// tr(Q_i^-1 Q_ij Q_j^-1 Q_ji) over all pairs, which is 2 n^2 over the variance of the sum of their
/// chi-squares (Satterthwaite 1946). n components where nothing correlates them, far fewer where
/// the datum is common to all and weak. `variance_factor` is s0^2 where covariances are scaled by
/// it, 1 otherwise. Above kMaxCheckPoints a regular part of them represents all.
/// docs/theory/quality.md.
inline constexpr std::size_t kMaxCheckPoints = 300;
[[nodiscard]] double CheckFreedom(const AdjustmentProblem& problem,
                                  const BlockState& state,
                                  const ReducedSystem& system,
                                  const std::vector<CheckResult>& checks,
                                  double variance_factor);

/// The differences alone, covariances NaN (level `leberl`).
[[nodiscard]] std::vector<PairResult> PairDifferences(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs);

/// AdjustResult::curvatures: for all corrections, or, if there are more than 200, for those with
/// the largest ratio of the standard deviation to that with all other unknowns known. Computed from
/// at most 100 control points and 100 others, and from 1,000 of each where a curvature is then 0.01
/// or more.
[[nodiscard]] std::vector<CorrectionCurvature> CurvaturesOfCorrections(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const ReducedSystem& system,
    const std::vector<ParameterResult>& parameters);

/// Warns where a curvature is 0.1 or more: limits of 95 % are then 1.7 and 2.7 standard deviations,
/// not 1.96. Call it after ScaleByPosterior.
void WarnOfCurvatures(AdjustResult* result);

/// The horizontal error ellipse of a point: half axes, and the direction of the longer one
/// clockwise from north, in [0, pi).
struct ErrorEllipse {
  double major_m = 0.0;
  double minor_m = 0.0;
  double azimuth_rad = 0.0;
};

/// Eigenvalues and eigenvectors of [[ee, en], [en, nn]] in closed form, times `sigma_scale`. The
/// standard ellipse (scale 1) holds the true place with probability 1 - exp(-1/2), 39.3 percent.
[[nodiscard]] ErrorEllipse EllipseOf(const SymmetricEnu& covariance_m2, double sigma_scale = 1.0);

/// Scale of the ellipse that holds the true place of a normal error with probability
/// 0 < confidence < 1: the root of the chi-square quantile of two degrees of freedom,
///
///     k = sqrt(-2 ln(1 - confidence))
///
/// Throws InputError for other values.
[[nodiscard]] double EllipseScale(double confidence);

constexpr int kEllipseCorners = 36;

/// Corners on the ellipse, east and north of its centre, counter-clockwise.
[[nodiscard]] std::array<Eigen::Vector2d, kEllipseCorners> EllipseCorners(
    const ErrorEllipse& ellipse);

/// The corners about p in true size, in the tangent plane of a geocentric frame at p; their heights
/// are that of p. Longitudes stay within half a turn of that of p, so that a ring across 180
/// degrees is not torn. Within 1e-8 m of GeographicLib's conversion of each corner.
[[nodiscard]] std::array<Geodetic, kEllipseCorners> EllipseRing(const Frame& frame,
                                                                const Eigen::Vector3d& p_m,
                                                                const ErrorEllipse& ellipse);

/// Each solved point with its nearest solved neighbour, each pair once, ascending.
[[nodiscard]] PointPairs NeighbourPairs(const AdjustmentProblem& problem, const BlockState& state);

/// All pairs of solved points; throws InputError above `most` pairs.
[[nodiscard]] PointPairs AllPairs(const AdjustmentProblem& problem, std::size_t most = 2000000);

/// Pairs along and across the track of the first pass at its middle, eight distances each: 0.7 of
/// the extent of the solved points and halves of it, down to where none are found. At most 32 of a
/// distance, their second point within a quarter of the distance of where it should be; a sample
/// that depends on the block alone.
[[nodiscard]] PointPairs DistancePairs(const AdjustmentProblem& problem, const BlockState& state);

/// Variances along, across and up [m^2] of a covariance, by a level unit direction (east, north).
[[nodiscard]] std::array<double, 3> AlongAcrossUp(const SymmetricEnu& covariance_m2,
                                                  const Eigen::Vector2d& along);

/// The pairs of a result by direction and distance. A pair within 20 degrees of a direction is one
/// of it; of a distance are those within a factor of sqrt(2) of the longest pair's over a power of
/// two; distances of fewer than four pairs are left out. Without covariances empty.
[[nodiscard]] std::vector<DifferenceClass> SummariseDifferences(const Block& block,
                                                                const AdjustResult& result);

/// Covariances by ceres::Covariance: the slow independent route beside the reduced normals
/// (`covariance_method = "ceres"`).
struct CeresCovariances {
  std::vector<SymmetricEnu> points;             ///< by point, east-north-up; NaN where not solved
  std::vector<ParameterCovariance> parameters;  ///< upper triangle of the parameters of each pass
  std::vector<PairResult> pairs;                ///< as PairCovariances
};

/// Unknowns (three per point, corrections) up to which covariance_method = "ceres" is offered. Its
/// time grows with their square: 10,000 take minutes where the reduced route takes milliseconds.
inline constexpr std::size_t kMaxCeresUnknowns = 10000;

/// Exact marginal covariances of all unknowns of the Ceres problem at `state`, looks without loss:
/// the sparse QR factorisation of the whole Jacobian (SuiteSparseQR; Ceres' documentation of
/// Covariance::Options), no elimination of points. Parameters: pairs within one parameter block and
/// of blocks whose passes see a common point, or all while there are at most
/// kFullParameterCovariance. Throws UndeterminedError where the Jacobian is rank
/// deficient to Ceres. No limit of size: the caller refuses above kMaxCeresUnknowns.
[[nodiscard]] CeresCovariances CovariancesByCeres(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs,
    int threads);

/// Refuses a block too large for the method asked for.
void RequireCovarianceMethod(const AdjustmentProblem& problem, const AdjustOptions& options);

/// Values, sigmas, covariance of points, corrections and pairs at options.covariance.
/// `datum`: covariances of a floating block are transformed to it.
void FillCovariance(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const ReducedSystem& system,
                    const std::optional<DatumTransform>& datum,
                    const AdjustOptions& options,
                    const PointPairs& pairs,
                    ProgressSink* progress,
                    AdjustResult* result);

}  // namespace sarblock
