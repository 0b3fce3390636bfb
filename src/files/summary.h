// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/files/result.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <filesystem>
#include <vector>

#include "result_tables.h"
#include "tables/open.h"
#include "tables/table.h"
#include <nlohmann/json.hpp>

namespace sarblock::files {

/// The parts `differences`, `quality`, `snooping` and `check_points` of summary.json.
[[nodiscard]] nlohmann::ordered_json DifferencesJson(
    const std::vector<DifferenceClass>& differences);
[[nodiscard]] nlohmann::ordered_json QualityJson(const Block& block,
                                                 const AdjustTable& options,
                                                 const AdjustResult& result);
[[nodiscard]] nlohmann::ordered_json SnoopingJson(const Block& block, const SnoopingReport& report);
[[nodiscard]] nlohmann::ordered_json CheckPointsJson(const CheckSummary& summary, double level);

/// The sections `variance_components` and `montecarlo` of summary.json.
[[nodiscard]] nlohmann::ordered_json VarianceComponentsSection(const AdjustTable& options,
                                                               const AdjustResult& result);
[[nodiscard]] nlohmann::ordered_json MonteCarloSection(const MonteCarloReport& report);

/// montecarlo.csv: the points compared, sample against rigorous standard deviations.
void WriteMonteCarloTable(TableSink* sink, const ResultView& view);

/// The array `diagnosis` of summary.json: one object an explanation, the most likely first.
[[nodiscard]] nlohmann::ordered_json DiagnosisSection(const Diagnosis& diagnosis);

/// The [adjust] table of a run, key by key, and the number of its threads.
[[nodiscard]] nlohmann::ordered_json ConfigurationJson(const AdjustTable& options);
/// Its tables: table, bytes, sha256 of the text of each.
[[nodiscard]] nlohmann::ordered_json TablesJson(const std::vector<TableSum>& tables);
/// The files that it read: file, bytes, sha256 each.
[[nodiscard]] nlohmann::ordered_json InputsJson(const std::vector<InputFile>& files);

/// The correction groups that a result was made with, given or chosen, from the configuration in
/// its summary; none of `intersect`. Throws InputError where the configuration is not one that
/// `adjust` writes.
[[nodiscard]] std::vector<CorrectionGroup> CorrectionsOf(const ResultFile& result);

}  // namespace sarblock::files
