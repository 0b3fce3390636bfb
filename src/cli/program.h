// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "session.h"

namespace sarblock::cli {

/// A program of this command line.
struct Program {
  const char* name = nullptr;
  const char* description = nullptr;
  std::vector<std::function<void(CLI::App*, Session*)>> commands;
  Ranks* ranks = nullptr;  ///< of a job of several processes; null: a process alone
  int cores = 0;           ///< threads without --threads
};

/// Runs the program and returns its exit code. Of several ranks all return the code they agree on;
/// the first alone prints.
[[nodiscard]] int RunProgram(const Program& program, int argc, char** argv);

}  // namespace sarblock::cli
