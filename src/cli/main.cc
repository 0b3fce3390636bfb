// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/version.h"

#include <exception>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "columns.h"
#include "command_line.h"
#include "commands.h"
#include "core/parallel.h"
#include "definitions.h"
#include "diagnose_command.h"
#include "environment.h"
#include "leberl_command.h"
#include "manual.h"
#include "report_command.h"
#include "study_command.h"
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

int Main(int argc, char** argv) {
  google::InitGoogleLogging(argv[0]);
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_ERROR;

  Session session;
  CLI::App app(
      "sarblock: least-squares stereo block adjustment for side-looking radar, with the exact "
      "covariance of everything it solves.",
      "sarblock");
  app.set_version_flag("--version", std::string("sarblock ") + Version());
  app.require_subcommand(1);
  app.fallthrough();
  AddGlobalOptions(&app, &session);
  AddSimulate(&app, &session);
  AddImport(&app, &session);
  AddCheck(&app, &session);
  AddIntersect(&app, &session);
  AddPredict(&app, &session);
  AddAdjust(&app, &session);
  AddDiagnose(&app, &session);
  AddReport(&app, &session);
  AddExport(&app, &session);
  AddConvert(&app, &session);
  AddStudy(&app, &session);
  AddLeberl(&app, &session);
  AddManualOptions(&app);
  AddFooters(&app);
  const std::vector<std::string> arguments = ArgumentsOf(argc, argv);
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", FitHelp(app.help()));
    return kAccepted;
  } catch (const CLI::Success& success) {
    static_cast<void>(app.exit(success));
    return kAccepted;
  } catch (const CLI::ParseError& error) {
    const std::string mistake = ExplainUsage(app, arguments);
    if (mistake.empty()) {
      static_cast<void>(app.exit(error));
    } else {
      Tell(FitColumns("sarblock: " + mistake + "\nRun with --help for more information."));
    }
    return kWrongUsage;
  }
  InstallInterruptHandler();
  MakeProgress(&session);
  const auto fail = [&session](const char* what, int code) {
    session.progress.reset();  // clears the bar's line
    const std::string text = std::string("sarblock: ") + what;
    Tell(isatty(STDERR_FILENO) == 1 ? FitColumns(text) : text);  // one line for other programs
    return code;
  };
  try {
    const ThreadLimit limit(session.Threads());
    return session.run();
  } catch (const InputError& error) {
    return fail(error.what(), kBadInput);
  } catch (const UndeterminedError& error) {
    return fail(error.what(), kUndetermined);
  } catch (const Interrupted& error) {
    return fail(error.what(), kNotAccepted);
  }
}

}  // namespace
}  // namespace sarblock::cli

int main(int argc, char** argv) {
  using namespace sarblock::cli;
  OpenStandardStreams();
  try {
    return FinishOutput(Main(argc, argv));
  } catch (const std::exception& error) {
    return ExplainError(error);
  }
}
