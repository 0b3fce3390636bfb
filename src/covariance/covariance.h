// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/result.h"

#include <utility>
#include <vector>

#include "model/problem.h"
#include "normals/reduced_system.h"
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
/// flight paths held, points are independent.
[[nodiscard]] std::vector<PairResult> PairCovariances(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const ReducedSystem* system,
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs,
    ProgressSink* progress);

/// How many independent components the check points of a result are worth: n^2 over the sum of
/// tr(Q_i^-1 Q_ij Q_j^-1 Q_ji) over all pairs, which is 2 n^2 over the variance of the sum of their
/// chi-squares (Satterthwaite 1946). n components where nothing correlates them, far fewer where
/// the datum is common to all and weak. `factor_1` is s0^2 where covariances are scaled by it, 1
/// otherwise. Above kMostCheckPoints a regular part of them stands for all.
/// docs/theory/quality.md.
inline constexpr std::size_t kMostCheckPoints = 300;
[[nodiscard]] double CheckFreedom(const AdjustmentProblem& problem,
                                  const BlockState& state,
                                  const ReducedSystem& system,
                                  const std::vector<CheckResult>& checks,
                                  double factor_1);

/// The differences alone, covariances NaN (level `leberl`).
[[nodiscard]] std::vector<PairResult> PairDifferences(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs);

}  // namespace sarblock
