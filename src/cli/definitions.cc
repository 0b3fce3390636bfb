// SPDX-License-Identifier: Apache-2.0
#include "definitions.h"

#include "sarblock/files/adjust_options.h"
#include "sarblock/files/scene_file.h"

#include <algorithm>
#include <string_view>

#include "session.h"
#include "study_command.h"
#include <CLI/CLI.hpp>
#include <fmt/core.h>

namespace sarblock::cli {
namespace {

bool IsWord(std::string_view text) {
  return !text.empty() &&
         text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string_view::npos;
}

/// "a, b, c" as words; empty where one of them is no plain word.
std::vector<std::string> WordsOf(std::string_view list) {
  std::vector<std::string> words;
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(", "), list.size());
    if (!IsWord(list.substr(0, comma))) return {};
    words.emplace_back(list.substr(0, comma));
    list.remove_prefix(std::min(comma + 2, list.size()));
  }
  return words;
}

/// The names in the description of a choice, "{a,b}"; empty where there is none.
std::vector<std::string> ChoicesIn(std::string_view type) {
  const std::size_t begin = type.find('{');
  const std::size_t end = type.find('}', begin);
  std::vector<std::string> choices;
  if (begin == std::string_view::npos || end == std::string_view::npos) return choices;
  std::string_view inside = type.substr(begin + 1, end - begin - 1);
  while (!inside.empty()) {
    const std::size_t comma = std::min(inside.find(','), inside.size());
    choices.emplace_back(inside.substr(0, comma));
    inside.remove_prefix(std::min(comma + 1, inside.size()));
  }
  return choices;
}

std::string ConstraintIn(std::string_view type) {
  if (type.find("POSITIVE") != std::string_view::npos) return "above 0";
  if (type.find("NONNEGATIVE") != std::string_view::npos) return "0 or more";
  const std::size_t begin = type.find(" in [");
  const std::size_t dash = type.find(" - ", begin);
  const std::size_t end = type.find(']', begin);
  if (begin == std::string_view::npos || dash == std::string_view::npos ||
      end == std::string_view::npos) {
    return {};
  }
  return fmt::format(
      "{} to {}", type.substr(begin + 5, dash - begin - 5), type.substr(dash + 3, end - dash - 3));
}

/// What an option takes, from CLI11's name of its type and validators. A text whose help begins
/// with "Folder" is one, unless it goes on "or .h5 file".
void SetValue(const std::string& type, OptionDefinition* definition) {
  definition->choices = ChoicesIn(type);
  if (definition->names.back() == "--set") {
    definition->kind = ValueKind::kKey;
    definition->value = "KEY=VALUE";
  } else if (!definition->choices.empty()) {
    definition->kind = ValueKind::kChoice;
    for (const std::string& choice : definition->choices) {
      definition->value += (definition->value.empty() ? "" : "|") + choice;
    }
  } else {
    definition->constraint = ConstraintIn(type);
    const std::string base = type.substr(0, type.find_first_of(": "));
    if (base == "TEXT" && definition->help.starts_with("Folder") &&
        definition->help.find(".h5 file") == std::string::npos) {
      definition->value = "FOLDER";
      definition->kind = ValueKind::kFolder;
    } else if (base == "FLOAT") {
      definition->value = "X";
      definition->kind = ValueKind::kNumber;
    } else if (base == "INT" || base == "UINT") {
      definition->value = "N";
      definition->kind = ValueKind::kNumber;
    } else {
      definition->value = base;
      definition->kind = ValueKind::kText;
    }
  }
}

OptionDefinition DefinitionOf(const CLI::Option& option) {
  OptionDefinition definition;
  definition.positional = option.get_positional();
  if (definition.positional) {
    definition.names = {option.get_name(true)};
  } else {
    for (const std::string& name : option.get_snames()) definition.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) definition.names.push_back("--" + name);
  }
  definition.help = option.get_description();
  definition.required = option.get_required();
  definition.standard = option.get_default_str();
  definition.several = option.get_expected_max() > 1;
  if (option.get_type_size() != 0) SetValue(option.get_type_name(), &definition);
  return definition;
}

CommandDefinition DefinitionOf(const CLI::App& app, const std::string& path) {
  CommandDefinition definition;
  definition.path = path;
  definition.help = app.get_description();
  for (const CLI::Option* option : app.get_options()) {
    if (option == app.get_help_ptr() || option->get_group().empty()) continue;
    definition.options.push_back(DefinitionOf(*option));
  }
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_group().empty()) continue;
    definition.commands.push_back(DefinitionOf(
        *command, path.empty() ? command->get_name() : path + " " + command->get_name()));
  }
  return definition;
}

void Collect(const CommandDefinition& command, std::vector<const CommandDefinition*>* all) {
  if (command.commands.empty()) all->push_back(&command);
  for (const CommandDefinition& below : command.commands) Collect(below, all);
}

}  // namespace

CommandDefinition DefinitionsOf(const CLI::App& app) { return DefinitionOf(app, ""); }

std::vector<const CommandDefinition*> RunnableCommands(const CommandDefinition& root) {
  std::vector<const CommandDefinition*> all;
  Collect(root, &all);
  return all;
}

std::vector<SetKey> SetKeysOf(const std::string& command_path) {
  std::vector<SetKey> keys;
  const std::string command = command_path.substr(0, command_path.find(' '));
  // These read no configuration.
  if (command == "leberl" || command == "report" || command == "export" || command == "convert") {
    return keys;
  }
  if (command == "study") {
    for (const std::string& key : StudyKeys(command_path)) keys.push_back({key, {}, ""});
    return keys;
  }
  const bool scene = command == "simulate";
  if (scene) {
    for (const std::string& key : SceneKeys()) keys.push_back({key, {}, ""});
  }
  for (const AdjustOption& option : AdjustOptionTable()) {
    if (option.type == "table") continue;
    SetKey key{(scene ? "adjust." : "") + std::string(option.key),
               {},
               fmt::format("{} ({}: {}; left out: {})",
                           option.help,
                           option.type,
                           option.allowed,
                           option.standard)};
    if (option.type == "text" || option.type == "flag") key.values = WordsOf(option.allowed);
    keys.push_back(std::move(key));
  }
  if (!scene) {
    keys.push_back({"trajectory.through",
                    {"states", "orbit", "positions", "smooth", "auto"},
                    "how flight paths are made of recorded states (docs/formats.md)"});
    keys.push_back({"trajectory.sigma_m", {}, "standard deviation of recorded positions"});
    keys.push_back({"trajectory.sigma_mps", {}, "standard deviation of recorded velocities"});
  }
  return keys;
}

std::vector<std::pair<int, std::string>> ExitCodes() {
  return {
      {kAccepted, "done: accepted, or converged with failed tests"},
      {kNotAccepted,
       "done but not accepted: not converged, or s0^2 above 10; with --strict also converged with "
       "failed tests. Also after Ctrl-C, which leaves no half-written file"},
      {kWrongUsage, "wrong usage"},
      {kBadInput, "input that cannot be used: FILE:LINE: field: what is wrong, what is allowed"},
      {kUndetermined, "the block cannot be determined; the message names parameters or points"},
      {kInternalError, "internal error"},
  };
}

}  // namespace sarblock::cli
