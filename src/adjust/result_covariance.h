// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/inner_datum.h"
#include "sarblock/adjust/options.h"
#include "sarblock/adjust/problem.h"
#include "sarblock/adjust/reduced_system.h"
#include "sarblock/adjust/result.h"
#include "sarblock/core/progress.h"

#include <optional>

namespace sarblock {

/// Refuses a block too large for the method asked for (ceres_covariance.h).
void RequireCovarianceMethod(const AdjustmentProblem& problem, const AdjustOptions& options);

/// Values, sigmas, covariance of points, corrections and pairs at options.covariance.
/// `datum`: of a floating block, whose covariances are transformed to it.
void FillCovariance(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const ReducedSystem& system,
                    const std::optional<DatumTransform>& datum,
                    const AdjustOptions& options,
                    const PointPairs& pairs,
                    ProgressSink* progress,
                    AdjustResult* result);

}  // namespace sarblock
