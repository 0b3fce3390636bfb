// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace sarblock::test {

/// How a run of the program ended.
struct ProgramRun {
  int exit_code = -1;  ///< -1: ended by a signal
  std::string out;
  std::string err;
};

/// The program `sarblock` (SARBLOCK_PROGRAM) in a process of its own, standard input empty, output
/// and messages kept in two files of `folder`.
class Program {
 public:
  Program(std::filesystem::path folder, const std::vector<std::string>& arguments);
  ~Program();  ///< waits
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void Signal(int signal) const;
  [[nodiscard]] bool Running();
  [[nodiscard]] ProgramRun Wait();

 private:
  std::filesystem::path folder_;
  pid_t pid_ = -1;
  bool ended_ = false;
  int status_ = 0;
};

/// Runs the program to its end, with its two files in the system's temporary folder.
[[nodiscard]] ProgramRun RunProgram(const std::vector<std::string>& arguments);

}  // namespace sarblock::test
