// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/diagnose/diagnose.h"
#include "sarblock/files/block_file.h"

#include <string>

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

}  // namespace sarblock::cli
