// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/tables/output.h"

#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/ranks.h"
#include "tables/table.h"
#include <CLI/CLI.hpp>

namespace sarblock::cli {

/// Exit codes (interface.md).
enum ExitCode : int {
  kAccepted = 0,
  kNotAccepted = 1,
  kWrongUsage = 2,
  kBadInput = 3,
  kUndetermined = 4,
  kInternalError = 5,
};

/// Opens standard streams that the caller closed, so that no file of a result becomes number 1 or
/// 2: messages go nowhere, and results that should go to standard output fail. Call it first.
void OpenStandardStreams();

/// Prints a line on standard error; a failure to write it is ignored.
void PrintError(std::string_view line) noexcept;

/// The words of an error and its exit code: those of interface.md for the library's own; 3 where a
/// file, a folder, a stream or the memory of this computer is at fault, else 5.
[[nodiscard]] Ending EndingOf(const std::exception& error);

/// Work of all ranks (null: of this process alone), over which its divided loops are distributed.
/// If it fails on one rank it ends with an exception on all: the rank's own, or OtherRankFailed.
void RunTogether(Ranks* ranks, const std::function<void()>& work);

/// Flushes standard output. Returns `exit_code`, or 3 with a message if that fails and no error was
/// printed before.
[[nodiscard]] int FinishOutput(int exit_code);

/// Options and services that all commands share.
struct Session {
  Ranks* ranks = nullptr;  ///< that work together; null: this process alone
  int cores = 0;           ///< threads where none are asked for
  int threads = 0;         ///< 0: `cores`
  bool quiet = false;
  bool json = false;
  bool dump_config = false;
  std::vector<std::string> set;
  std::unique_ptr<ProgressSink> progress;  ///< a bar on a terminal, else silent
  std::function<void()> clear_bar;         ///< takes the bar away until the next step
  std::string stage;                       ///< the last that `progress` showed; empty before
  std::function<int()> run;                ///< set by the command that was chosen
  /// Explanations printed after the error that ends the program.
  std::vector<std::string> after_error;

  [[nodiscard]] int Threads() const;
  /// True for the rank that reads, writes and prints for all.
  [[nodiscard]] bool first() const { return ranks == nullptr || ranks->first(); }
  /// A line for people on standard error, unless quiet.
  void Warn(const std::string& line) const;
  /// Lines for people on standard output, fitted to a terminal, unless quiet.
  void Print(const std::string& text) const;
};

/// Adds the global options; the bar is made by MakeProgress once they are parsed.
void AddGlobalOptions(CLI::App* app, Session* session);
void MakeProgress(Session* session);

/// Adds --force, which writes over files of others; `foreign` begins as kRefuse.
void AddForce(CLI::App* command,
              ForeignFiles* foreign,
              const std::string& help = "Write into a folder that holds other files");

/// Adds --memory, AdjustOptions::memory_mib.
void AddMemory(CLI::App* command, double* memory_mib);

/// Adds --part I/N, a text of TaskPartOf(); empty without one.
CLI::Option* AddPart(CLI::App* command, std::string* part, const std::string& help);

/// Adds --scratch, the folder of a ScratchScope; empty without one.
void AddScratch(CLI::App* command, std::string* folder);

/// Ctrl-C asks the running work to end between steps; a second one ends at once. Temporary files
/// are removed both ways; a folder that was being written is cleared by the next run into it.
void InstallInterruptHandler();

}  // namespace sarblock::cli
