// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "reliability.h"

namespace sarblock {

/// Levels and critical values of a result's tests; counts those of its quality figures.
[[nodiscard]] ReliabilityFigures ReliabilityOf(const AdjustOptions& options,
                                               const AdjustResult& result);

/// Studentised residual w / s0 (Pope 1976), s0^2 the variance factor; NaN without one.
[[nodiscard]] double TauOf(double w_1, const AdjustResult& result);

/// Standard deviation of a look's azimuth in metres at the target; where it is given in seconds by
/// the azimuth rate at `p_m` on the nominal path: to the relative change of the velocity by the
/// corrections.
[[nodiscard]] double AzimuthSigma_m(const Block& block,
                                    std::uint64_t look,
                                    const Eigen::Vector3d& p_m);

[[nodiscard]] QualitySummary SummariseQuality(const Block& block,
                                              const AdjustOptions& options,
                                              const AdjustResult& result);

[[nodiscard]] CheckSummary SummariseChecks(const AdjustResult& result, double level);

/// "The predicted accuracy is realistic: errors of check points are 1.04 times as large as
/// predicted, 0.9 to 1.1 is allowed (95 %)."; empty without check points.
[[nodiscard]] std::string DescribeChecks(const CheckSummary& summary, double level);

/// One line a finding of the search for blunders, with the words of the field.
[[nodiscard]] std::string DescribeFinding(const Block& block, const BlunderFinding& finding);
/// "rejected", "point left out", "control released", "kept", "readmitted".
[[nodiscard]] const char* NameOf(BlunderFinding::Action action);

}  // namespace sarblock
