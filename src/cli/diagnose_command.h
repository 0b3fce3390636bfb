// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/diagnose/diagnose.h"
#include "sarblock/io/block_files.h"
#include "sarblock/model/result.h"

#include <optional>
#include <string>

#include "session.h"

namespace sarblock::cli {

void AddDiagnose(CLI::App* app, Session* session);

/// The diagnosis of a block whose result is not accepted or fails a test; nothing where all is
/// well or `diagnose = false`.
[[nodiscard]] std::optional<Diagnosis> DiagnoseFailure(const BlockFile& file,
                                                       const AdjustResult& result,
                                                       const Session& session);

/// The same of a block that could not be solved, on standard error.
void ExplainRefusal(const BlockFile& file, const Session& session);

/// The same of a block that was refused for contradictions as it was read.
void ExplainUnread(const std::string& folder, ReadOptions read, const Session& session);

/// Two spaces, the sentence and a new line for each.
[[nodiscard]] std::string DescribeDiagnosis(const Diagnosis& diagnosis);

/// Remarks of a diagnosis that reading the block has not made.
[[nodiscard]] std::vector<std::string> RemarksBeside(const std::vector<std::string>& warnings,
                                                     const Diagnosis& diagnosis);

}  // namespace sarblock::cli
