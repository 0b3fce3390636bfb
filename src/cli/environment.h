// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <string_view>

namespace sarblock::cli {

/// Opens standard streams that the caller closed, so that no file of a result becomes number 1 or
/// 2: messages go nowhere, and results that should go to standard output fail. Call it first.
void OpenStandardStreams();

/// A line on standard error; one that cannot be written is lost, never an error of its own.
void Tell(std::string_view line) noexcept;

/// Tells of an error that belongs to no command and returns its exit code: 3 where a file, a
/// folder, a stream or the memory of this computer is at fault, else 5.
[[nodiscard]] int ExplainError(const std::exception& error);

/// Writes out what standard output still holds. `exit_code`, or 3 with words where that fails and
/// no error was told of before.
[[nodiscard]] int FinishOutput(int exit_code);

}  // namespace sarblock::cli
