// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "session.h"
#include <CLI/CLI.hpp>
#include <fmt/core.h>

namespace sarblock::cli {

/// Each adds one command; when it is chosen, session->run is set to its work.
void AddSimulate(CLI::App* app, Session* session);
void AddImport(CLI::App* app, Session* session);
void AddCheck(CLI::App* app, Session* session);
void AddIntersect(CLI::App* app, Session* session);
void AddPredict(CLI::App* app, Session* session);
void AddAdjust(CLI::App* app, Session* session);
void AddDiagnose(CLI::App* app, Session* session);
void AddExport(CLI::App* app, Session* session);
void AddConvert(CLI::App* app, Session* session);
void AddStudy(CLI::App* app, Session* session);  ///< with every kind of study

/// Adds `report`; when it is chosen, session->run is set to its work.
void AddReport(CLI::App* app, Session* session);

/// Writes report.html into a result's folder and says so (`--report` of the solving commands).
void ReportResult(const std::string& folder, const Session& session);

/// The value of a name in `numbers`, as CLI11 reads an enumeration; any other name is refused with
/// the allowed ones and the nearest.
[[nodiscard]] CLI::Validator ChoiceOf(const std::map<std::string, int>& numbers);

/// The same for the values of an enumeration.
template <typename Value>
CLI::Validator ChoiceOf(const std::map<std::string, Value>& values) {
  std::map<std::string, int> numbers;
  for (const auto& [name, value] : values) numbers[name] = static_cast<int>(value);
  return ChoiceOf(numbers);
}

/// The two sides of `LEFT=RIGHT`, neither empty; `form` says so in the InputError at `place`.
[[nodiscard]] std::pair<std::string, std::string> SplitPair(const std::string& text,
                                                            const char* form,
                                                            const FilePlace& place);

/// The arguments of the command line, without the program. `help`, `help COMMAND...` and `version`
/// become the options of the same meaning.
[[nodiscard]] std::vector<std::string> ArgumentsOf(int argc, const char* const* argv);

/// Ends the help of every command below `app` with the options that all commands have.
void AddFooters(CLI::App* app);

/// Explains arguments that name no command of `app`, or no option of their command, with the
/// nearest name; empty where neither is the mistake.
[[nodiscard]] std::string ExplainUsage(const CLI::App& app,
                                       const std::vector<std::string>& arguments);

/// A program of this command line.
struct Program {
  const char* name = nullptr;
  const char* description = nullptr;
  std::vector<std::function<void(CLI::App*, Session*)>> commands;
  Ranks* ranks = nullptr;  ///< of a job of several processes; null: a process alone
  int cores = 0;           ///< threads without --threads
};

/// Runs the program and returns its exit code. Several ranks return the code they agree on; only
/// the first prints.
[[nodiscard]] int RunProgram(const Program& program, int argc, char** argv);

}  // namespace sarblock::cli
