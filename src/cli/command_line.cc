// SPDX-License-Identifier: Apache-2.0
#include "command_line.h"

#include "sarblock/core/id_table.h"

#include <algorithm>

#include "definitions.h"
#include <fmt/ranges.h>

namespace sarblock::cli {
namespace {

std::vector<std::string> CommandNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

/// Long options of a command and of all that it stands below.
std::vector<std::string> OptionNames(const CLI::App* app) {
  std::vector<std::string> names;
  for (; app != nullptr; app = app->get_parent()) {
    for (const CLI::Option* option : app->get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  }
  return names;
}

void AddFooterTo(CLI::App* command, const std::string& path) {
  const auto below = command->get_subcommands([](const CLI::App*) { return true; });
  for (CLI::App* one : command->get_subcommands([](CLI::App*) { return true; })) {
    AddFooterTo(one, path.empty() ? one->get_name() : path + " " + one->get_name());
  }
  if (path.empty() || !below.empty()) return;
  std::string text =
      "Of every command:\n"
      "  --threads N      threads to use (left out: all cores)\n"
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

}  // namespace sarblock::cli
