// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <nlohmann/json.hpp>

namespace sarblock {

/// The parts `quality`, `snooping` and `check_points` of summary.json.
[[nodiscard]] nlohmann::ordered_json QualityJson(const Block& block,
                                                 const AdjustOptions& options,
                                                 const AdjustResult& result);
[[nodiscard]] nlohmann::ordered_json SnoopingJson(const Block& block, const SnoopingReport& report);
[[nodiscard]] nlohmann::ordered_json CheckPointsJson(const CheckSummary& summary, double level);

}  // namespace sarblock
