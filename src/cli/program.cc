// SPDX-License-Identifier: Apache-2.0
#include "program.h"

#include "sarblock/core/error.h"

#include <exception>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "columns.h"
#include "command_line.h"
#include "core/threads.h"
#include "definitions.h"
#include "environment.h"
#include "manual.h"
#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <glog/logging.h>
#include <unistd.h>

namespace sarblock::cli {
namespace {

using Writer = std::function<std::string(const CommandDefinition&)>;

CLI::Option* AddPrinter(CLI::App* app,
                        const std::string& name,
                        const std::map<std::string, Writer>& writers,
                        const std::string& help) {
  std::vector<std::string> names;
  for (const auto& [key, writer] : writers) names.push_back(key);
  return app
      ->add_option_function<std::string>(
          name,
          [app, writers](const std::string& choice) {
            fmt::print("{}", writers.at(choice)(DefinitionsOf(*app)));
            throw CLI::Success();
          },
          help)
      ->check(CLI::IsMember(names));
}

/// Adds `--completion SHELL` and, not shown by --help, `--dump-manual FORMAT`. Both print what they
/// are asked for, made from the parser's own definitions, and end. To be called last.
void AddManualOptions(CLI::App* app) {
  AddPrinter(app,
             "--completion",
             {{"bash", BashCompletion}, {"zsh", ZshCompletion}, {"fish", FishCompletion}},
             "Print the completion script for a shell and end");
  AddPrinter(app,
             "--dump-manual",
             {{"roff", ManualRoff}, {"markdown", ManualMarkdown}, {"keys", ManualKeys}},
             "Print the manual and end")
      ->group("");
}

/// Parses and runs. What the parser has to say it says itself.
Ending ParseAndRun(const Program& program, int argc, char** argv, Session* session) {
  const std::string name = program.name;
  CLI::App app(name + ": " + program.description, name);
  app.set_version_flag("--version", name + " " + Version());
  app.require_subcommand(1);
  app.fallthrough();
  AddGlobalOptions(&app, session);
  for (const auto& add : program.commands) add(&app, session);
  AddManualOptions(&app);
  AddFooters(&app);
  const std::vector<std::string> arguments = ArgumentsOf(argc, argv);
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", FitHelp(app.help()));
    return {kAccepted, {}};
  } catch (const CLI::Success& success) {
    static_cast<void>(app.exit(success));
    return {kAccepted, {}};
  } catch (const CLI::ParseError& error) {
    const std::string mistake = ExplainUsage(app, arguments);
    if (!session->first()) return {kWrongUsage, {}};
    if (mistake.empty()) {
      static_cast<void>(app.exit(error));
    } else {
      Tell(FitColumns("sarblock: " + mistake + "\nRun with --help for more information."));
    }
    return {kWrongUsage, {}};
  }
  InstallInterruptHandler();
  MakeProgress(session);
  const ThreadLimit limit(session->Threads());
  return {session->run(), {}};
}

}  // namespace

int RunProgram(const Program& program, int argc, char** argv) {
  google::InitGoogleLogging(argv[0]);
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_ERROR;
  Session session;
  session.ranks = program.ranks;
  session.cores = program.cores;
  Ending ending;
  try {
    ending = ParseAndRun(program, argc, argv, &session);
  } catch (const std::exception& error) {
    ending = EndingOf(error);
  }
  if (session.ranks != nullptr) ending = session.ranks->Conclude(ending);
  if (!session.first()) return ending.exit_code;
  session.progress.reset();  // clears the bar's line
  if (ending.failed()) {
    const std::string text = "sarblock: " + ending.words;
    Tell(isatty(STDERR_FILENO) == 1 ? FitColumns(text) : text);  // one line for other programs
  }
  return FinishOutput(ending.exit_code);
}

}  // namespace sarblock::cli
