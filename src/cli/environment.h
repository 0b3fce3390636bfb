// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <functional>
#include <string_view>

#include "core/ranks.h"

namespace sarblock::cli {

/// Opens standard streams that the caller closed, so that no file of a result becomes number 1 or
/// 2: messages go nowhere, and results that should go to standard output fail. Call it first.
void OpenStandardStreams();

/// A line on standard error; one that cannot be written is lost, never an error of its own.
void Tell(std::string_view line) noexcept;

/// The words of an error and its exit code: those of interface.md for the library's own; 3 where a
/// file, a folder, a stream or the memory of this computer is at fault, else 5.
[[nodiscard]] Ending EndingOf(const std::exception& error);

/// Work of all ranks (null: of this process alone), among which its divided loops are divided.
/// Where it fails on one rank it ends with an exception on all: the rank's own, or OtherRankFailed.
void RunTogether(Ranks* ranks, const std::function<void()>& work);

/// Writes out what standard output still holds. `exit_code`, or 3 with words where that fails and
/// no error was told of before.
[[nodiscard]] int FinishOutput(int exit_code);

}  // namespace sarblock::cli
