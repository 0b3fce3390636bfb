// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <optional>

#include "model/problem.h"
#include "normals/reduced_system.h"
#include "solve/inner_datum.h"

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
