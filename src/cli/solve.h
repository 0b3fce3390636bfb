// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/diagnose/diagnose.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"
#include "sarblock/tables/output.h"

#include <string>
#include <vector>

#include "session.h"

namespace sarblock::cli {

void AddDiagnose(CLI::App* app, Session* session);

/// The diagnosis of a block that could not be solved, on standard error; nothing with
/// `diagnose = false`.
void ExplainRefusal(const BlockFile& file, const Session& session);

/// The same of a block that was refused for contradictions as it was read.
void ExplainUnread(const std::string& folder, ReadOptions read, const Session& session);

/// Two spaces, the sentence and a new line for each.
[[nodiscard]] std::string DescribeDiagnosis(const Diagnosis& diagnosis);

/// The draws of an adjustment in parts (files/montecarlo_part.h): --part writes one, --join takes
/// all.
struct AdjustParts {
  std::string part;               ///< "I/N"; empty without one
  std::vector<std::string> join;  ///< folders
  [[nodiscard]] FolderContent output() const {
    return part.empty() ? FolderContent::kResult : FolderContent::kPart;
  }
};

/// Adds --part, which excludes `report`, and --join.
void AddAdjustParts(CLI::App* command, CLI::Option* report, AdjustParts* parts);

/// Sets options.montecarlo_part where a part or a join was asked for. Throws InputError for an
/// adjustment without draws, and where `out` is no name for what is written.
void SetParts(const AdjustParts& parts, const std::string& out, AdjustOptions* options);

/// Writes the part options.montecarlo_part and says so, and why the adjustment is not accepted.
void WritePart(const std::string& out,
               const Block& block,
               const AdjustOptions& options,
               const AdjustResult& result,
               const std::vector<InputFile>& inputs,
               Compression compression,
               const Session& session);

}  // namespace sarblock::cli
