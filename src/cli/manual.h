// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "definitions.h"

namespace sarblock::cli {

/// The manual as a page of man and as docs/commands.md; the keys of --set, one a line behind their
/// command and a tab.
[[nodiscard]] std::string ManualRoff(const CommandDefinition& program);
[[nodiscard]] std::string ManualMarkdown(const CommandDefinition& program);
[[nodiscard]] std::string ManualKeys(const CommandDefinition& program);

/// Completion scripts.
[[nodiscard]] std::string BashCompletion(const CommandDefinition& program);
[[nodiscard]] std::string ZshCompletion(const CommandDefinition& program);
[[nodiscard]] std::string FishCompletion(const CommandDefinition& program);

}  // namespace sarblock::cli
