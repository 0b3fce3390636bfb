// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/files/result.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"
#include "sarblock/tables/output.h"

#include <string>
#include <vector>

#include "tables/open.h"
#include <nlohmann/json.hpp>

namespace sarblock::files {

/// SummaryJson() of a result whose tables are written: `written` is what that cost, `tables` are
/// their checksums, none of a result as one file.
[[nodiscard]] std::string SummaryText(const Block& block,
                                      const AdjustTable& options,
                                      const AdjustResult& result,
                                      const ResultContext& context,
                                      const std::vector<StageCost>& written,
                                      const std::vector<TableSum>& tables);
/// Reads summary.json: the summary, the frame and the passes, still without their paths.
void ReadSummary(const TableSource& source, ResultFile* result);

/// The array `diagnosis` of summary.json: one object an explanation, the most likely first.
[[nodiscard]] nlohmann::ordered_json DiagnosisSection(const Diagnosis& diagnosis);

/// The list `tables` of summary.json: table, bytes, sha256 of the text of each.
[[nodiscard]] nlohmann::ordered_json TablesJson(const std::vector<TableSum>& tables);

}  // namespace sarblock::files
