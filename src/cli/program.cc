// SPDX-License-Identifier: Apache-2.0
#include "program.h"

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/threads.h"
#include "manual.h"
#include "session.h"
#include "terminal.h"
#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <glog/logging.h>
#include <unistd.h>

namespace sarblock::cli {
namespace {

std::vector<std::string> CommandNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

/// Long options of a command and of all commands above it.
std::vector<std::string> OptionNames(const CLI::App* app) {
  std::vector<std::string> names;
  for (; app != nullptr; app = app->get_parent()) {
    for (const CLI::Option* option : app->get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  }
  return names;
}

/// The option of the chosen command that gives a field of the library its value: --base-m gives
/// "base_m". Empty if there is none.
std::string OptionOf(const CLI::App& app, const std::string& field) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  std::string option = "--" + field;
  std::replace(option.begin(), option.end(), '_', '-');
  const std::vector<std::string> known = OptionNames(command);
  return std::find(known.begin(), known.end(), option) != known.end() ? option : "";
}

/// Refuses numbers of options that are not finite, which the parser reads as such.
void RequireFiniteNumbers(const CLI::App& app) {
  for (const CLI::App* command = &app; command != nullptr;) {
    for (const CLI::Option* option : command->get_options()) {
      if (!option->get_type_name().starts_with("FLOAT")) continue;
      for (const std::string& text : option->results()) {
        if (std::isfinite(std::strtod(text.c_str(), nullptr))) continue;
        throw InputError("--" + option->get_lnames().front(),
                         text + " is given, a finite number is allowed");
      }
    }
    const auto chosen = command->get_subcommands();
    command = chosen.empty() ? nullptr : chosen.front();
  }
}

void AddFooterTo(CLI::App* command, const std::string& path) {
  const auto below = command->get_subcommands([](const CLI::App*) { return true; });
  for (CLI::App* one : command->get_subcommands([](CLI::App*) { return true; })) {
    AddFooterTo(one, path.empty() ? one->get_name() : path + " " + one->get_name());
  }
  if (path.empty() || !below.empty()) return;
  std::string text =
      "Options of every command:\n"
      "  --threads N      threads to use (default: all cores)\n"
      "  -q,--quiet       no messages, no summary, no progress bar\n"
      "  --json           the summary as JSON on standard output";
  const std::vector<SetKey> keys = SetKeysOf(path);
  if (!keys.empty()) {
    text += fmt::format(
        "\n  --set KEY=VALUE  override a key, such as {}; may be repeated.\n"
        "                   Keys: --dump-config prints them with their values, and\n"
        "                   docs/commands.md says which pages explain them",
        keys.front().key);
  }
  command->footer(text);
}

}  // namespace

CLI::Validator ChoiceOf(const std::map<std::string, int>& numbers) {
  std::vector<std::string> names;
  for (const auto& [name, number] : numbers) names.push_back(name);
  const std::string allowed = fmt::format("{}", fmt::join(names, ", "));
  const auto read = [=](std::string& text) -> std::string {
    const auto found = numbers.find(text);
    if (found == numbers.end()) {
      return "'" + text + "' is not known, " + allowed + " are allowed" +
             DidYouMean(NearestName(text, names));
    }
    text = std::to_string(found->second);
    return {};
  };
  return {read, fmt::format("{{{}}}", fmt::join(names, ",")), "choice"};
}

std::vector<std::string> ArgumentsOf(int argc, const char* const* argv) {
  std::vector<std::string> arguments(argv + std::min(argc, 1), argv + argc);
  if (arguments.empty()) return arguments;
  if (arguments.front() == "help") {
    arguments.erase(arguments.begin());
    arguments.emplace_back("--help");
  } else if (arguments.front() == "version") {
    arguments.front() = "--version";
  }
  return arguments;
}

void AddFooters(CLI::App* app) { AddFooterTo(app, ""); }

std::string ExplainUsage(const CLI::App& app, const std::vector<std::string>& arguments) {
  const CLI::App* command = &app;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    const std::string name = argument.substr(0, argument.find('='));
    if (argument.starts_with("--")) {
      const std::vector<std::string> known = OptionNames(command);
      if (std::find(known.begin(), known.end(), name) != known.end()) continue;
      return "'" + name + "' is no option of " + command->get_name() +
             DidYouMean(NearestName(name, known));
    }
    if (argument.starts_with("-")) continue;
    const std::vector<std::string> below = CommandNames(*command);
    if (below.empty()) continue;  // a positional argument or an option's value
    if (std::find(below.begin(), below.end(), argument) != below.end()) {
      command = command->get_subcommand(argument);
      continue;
    }
    // The value of a global option before the command is no command.
    if (i > 0 && arguments[i - 1].starts_with("-")) continue;
    return "'" + argument + "' is no command of " + command->get_name() +
           DidYouMean(NearestName(argument, below));
  }
  const std::vector<std::string> below = CommandNames(*command);
  const bool options = std::any_of(arguments.begin(), arguments.end(), [](const auto& argument) {
    return argument.starts_with("-");
  });
  if (below.empty() || options) return {};
  return fmt::format("{} needs a command: {}", command->get_name(), fmt::join(below, ", "));
}

std::pair<std::string, std::string> SplitPair(const std::string& text,
                                              const char* form,
                                              const FilePlace& place) {
  const std::size_t sign = text.find('=');
  if (sign == std::string::npos || sign == 0 || sign + 1 == text.size()) {
    throw InputError(place, "'" + text + "' is not " + form);
  }
  return {text.substr(0, sign), text.substr(sign + 1)};
}

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
             {{"bash", BashCompletion}},
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
      PrintError(FitColumns("sarblock: " + mistake + "\nRun with --help for more information."));
    }
    return {kWrongUsage, {}};
  }
  RequireFiniteNumbers(app);
  InstallInterruptHandler();
  MakeProgress(session);
  const CancellationScope cancellation(session->progress.get());
  const ThreadLimit limit(session->Threads());
  try {
    return {session->run(), {}};
  } catch (const InputError& error) {
    const std::string option = error.place().file.empty() ? OptionOf(app, error.place().field) : "";
    if (option.empty()) throw;
    throw InputError(option, error.problem());
  }
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
  } catch (const Interrupted& error) {
    // Where a loop was ended in its middle it does not know what it was part of.
    ending = EndingOf(session.stage.empty() ? error : Interrupted(session.stage));
  } catch (const std::exception& error) {
    ending = EndingOf(error);
  }
  if (session.ranks != nullptr) ending = session.ranks->Conclude(ending);
  if (!session.first()) return ending.exit_code;
  session.progress.reset();  // clears the bar's line
  if (ending.failed()) {
    session.after_error.insert(session.after_error.begin(), ending.words);
    for (const std::string& words : session.after_error) {
      const std::string text = "sarblock: " + words;
      PrintError(isatty(STDERR_FILENO) == 1 ? FitColumns(text)
                                            : text);  // one line for other programs
    }
  }
  return FinishOutput(ending.exit_code);
}

}  // namespace sarblock::cli
