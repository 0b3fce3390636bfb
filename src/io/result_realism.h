// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "result_view.h"
#include "tables/table.h"
#include <nlohmann/json.hpp>

namespace sarblock {

/// The sections `variance_components` and `montecarlo` of summary.json.
[[nodiscard]] nlohmann::ordered_json VarianceComponentsSection(const AdjustOptions& options,
                                                               const AdjustResult& result);
[[nodiscard]] nlohmann::ordered_json MonteCarloSection(const MonteCarloReport& report);

/// montecarlo.csv: the points compared, sample against rigorous standard deviations.
void WriteMonteCarloTable(TableSink* sink, const ResultView& view);

}  // namespace sarblock
