// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/files/result.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"
#include "sarblock/tables/output.h"

#include <string>
#include <vector>

#include "session.h"

namespace sarblock::cli {

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
