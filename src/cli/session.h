// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/tables/output.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/ranks.h"
#include "exit_code.h"
#include "tables/table.h"
#include <CLI/CLI.hpp>

namespace sarblock::cli {

/// What every command understands.
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
  std::function<int()> run;                ///< set by the command that was chosen

  [[nodiscard]] int Threads() const;
  /// True for the rank that reads, writes and prints for all.
  [[nodiscard]] bool first() const { return ranks == nullptr || ranks->first(); }
  /// A line for people on standard error, unless quiet.
  void Say(const std::string& line) const;
  /// Lines for people on standard output, fitted to a terminal, unless quiet.
  void Show(const std::string& text) const;
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
