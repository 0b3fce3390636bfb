// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "model/problem.h"
#include "normals/reduced_system.h"
#include "solve/inner_datum.h"

namespace sarblock {

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
/// kFullParameterCovariance (covariance.h). Throws UndeterminedError where the Jacobian is rank
/// deficient to Ceres. No limit of size: the caller refuses above kMaxCeresUnknowns.
[[nodiscard]] CeresCovariances CovariancesByCeres(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs,
    int threads);

/// Refuses a block too large for the method asked for (result_covariance.h).
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
