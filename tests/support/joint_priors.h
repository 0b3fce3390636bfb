// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstdint>

#include "support/small_blocks.h"
#include <Eigen/Core>

namespace sarblock::test {

/// Q = D R D of these standard deviations, R = (G G' + 0.05 I) with a random G of few columns,
/// scaled to unit diagonal: correlations up to 0.98.
[[nodiscard]] Eigen::MatrixXd StrongCovariance(const Eigen::VectorXd& sigma, std::uint64_t seed);

/// Position of degree 1 in these axes and a range bias, with one joint prior "path" of all seven:
/// constants of about 2 m, drifts of about 1.5 m, the bias of 0.9 m.
[[nodiscard]] AdjustOptions WithJointPrior(PositionCorrection::Axes axes, std::uint64_t seed);

/// The block of a plan with noise, one control point and one known in plan only.
[[nodiscard]] KnownBlock NoisyBlockWithControl(const BlockPlan& plan);

/// Expects the values and the standard deviations of all corrections to be the same, to 1e-7
/// standard deviations.
void ExpectSameCorrections(const AdjustResult& a, const AdjustResult& b);

}  // namespace sarblock::test
