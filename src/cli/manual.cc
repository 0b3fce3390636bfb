// SPDX-License-Identifier: Apache-2.0
#include "manual.h"

#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <string_view>

#include "session.h"
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
    for (const std::string& key : files::SceneKeys()) keys.push_back({key, {}, ""});
  }
  for (const files::AdjustOption& option : files::AdjustOptionTable()) {
    if (option.type == "table") continue;
    SetKey key{
        (scene ? "adjust." : "") + std::string(option.key),
        {},
        fmt::format(
            "{} ({}: {}; default: {})", option.help, option.type, option.allowed, option.standard)};
    if (option.type == "text" || option.type == "flag") key.values = WordsOf(option.allowed);
    keys.push_back(std::move(key));
  }
  if (!scene) {
    keys.push_back({"trajectory.through",
                    {"states", "orbit", "positions", "smooth", "auto"},
                    "how flight paths are made of recorded states (docs/formats.md)"});
    keys.push_back({"trajectory.sigma_m", {}, "standard deviation of recorded positions"});
    keys.push_back({"trajectory.sigma_mps", {}, "standard deviation of recorded velocities"});
    keys.push_back({"reduction.troposphere",
                    {"standard", "none"},
                    "delay that is taken off ranges, or a table of the weather (docs/formats.md)"});
    keys.push_back({"reduction.ionosphere", {"none"}, "table { tec_tecu, share_1 } to take off"});
    keys.push_back({"reduction.tide", {"solid", "none"}, "tides that points are free of"});
    keys.push_back({"reduction.range_m", {}, "constant that is taken off measured ranges"});
    keys.push_back({"reduction.time_s", {}, "constant that is taken off measured times"});
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

namespace {

constexpr const char* kDescription =
    "Takes what was measured in overlapping radar images (azimuth times, slant ranges, squints or "
    "Doppler centroids), the flight paths as recorded and the points that are known, and gives the "
    "most probable positions of all points and corrections of all flight paths, each with its "
    "exact covariance. A simulator with known truth and the closed forms of Leberl (1979) are "
    "included.";

constexpr std::array kExamples = std::to_array<const char*>({
    "sarblock simulate datasets/scenes/block-12-strips.toml -o build/block",
    "sarblock check build/block",
    "sarblock predict build/block -o build/plan --set covariance=intersection",
    "sarblock adjust build/block -o build/result --strict",
    "sarblock adjust build/block -o build/robust --set robust=huber",
    "sarblock leberl table1 --csv",
});

std::string Upper(std::string text) {
  std::ranges::transform(
      text, text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string Join(const std::vector<std::string>& parts, const char* between) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : between) + part;
  return text;
}

/// "-o, --output FOLDER" or "BLOCK".
std::string NameAndValue(const OptionDefinition& option) {
  std::string text = option.positional ? Upper(option.names[0]) : Join(option.names, ", ");
  if (!option.positional && !option.value.empty()) text += " " + option.value;
  return option.several ? text + " ..." : text;
}

std::string Sentence(const OptionDefinition& option) {
  std::string text = option.help;
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  if (!option.constraint.empty()) text += "; " + option.constraint;
  return text;
}

std::string Synopsis(const CommandDefinition& command) {
  std::string text = "sarblock " + command.path;
  bool others = false;
  for (const OptionDefinition& option : command.options) {
    if (option.positional && option.required) text += " " + NameAndValue(option);
    if (option.positional && !option.required) text += " [" + NameAndValue(option) + "]";
  }
  for (const OptionDefinition& option : command.options) {
    if (option.positional) continue;
    if (option.required) {
      text += fmt::format(" {} {}", option.names.front(), option.value);
    } else {
      others = true;
    }
  }
  return others ? text + " [OPTION]..." : text;
}

// --- man ---

std::string RoffText(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else {
      if ((c == '.' || c == '\'') && (escaped.empty() || escaped.back() == '\n')) escaped += "\\&";
      escaped += c;
    }
  }
  return escaped;
}

std::string RoffItem(const std::string& tag, const std::string& text) {
  return ".TP\n.B " + RoffText(tag) + "\n" + RoffText(text) + "\n";
}

std::string RoffOptions(const std::vector<OptionDefinition>& options) {
  std::string text;
  for (const OptionDefinition& option : options) {
    std::string help = Sentence(option);
    if (!option.standard.empty()) help += " (default " + option.standard + ")";
    text += RoffItem(NameAndValue(option), help + ".");
  }
  return text;
}

// --- Markdown ---

std::string Cell(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string MarkdownOptions(const std::vector<OptionDefinition>& options) {
  std::string text = "| argument or option | default | meaning |\n| --- | --- | --- |\n";
  for (const OptionDefinition& option : options) {
    text += fmt::format("| `{}` | {} | {} |\n",
                        Cell(NameAndValue(option)),
                        option.required ? "required" : Cell(option.standard),
                        Cell(Sentence(option)));
  }
  return text;
}

}  // namespace

std::string ManualRoff(const CommandDefinition& program) {
  std::string text = fmt::format(
      ".\\\" Printed by sarblock --dump-manual roff.\n"
      ".TH SARBLOCK 1 \"{}\" \"sarblock {}\" \"User Commands\"\n"
      ".SH NAME\nsarblock \\- stereo block adjustment for side\\-looking radar\n"
      ".SH SYNOPSIS\n.B sarblock\n.I COMMAND\n[ARGUMENT]... [OPTION]...\n"
      ".SH DESCRIPTION\n{}\n.PP\n"
      "Results go to files or to standard output, messages and the progress bar to standard "
      "error.\n"
      ".SH COMMANDS\n",
      SARBLOCK_RELEASE_DATE,
      Version(),
      RoffText(kDescription));
  for (const CommandDefinition* command : RunnableCommands(program)) {
    text += fmt::format(".SS {}\n{}.\n", RoffText(Synopsis(*command)), RoffText(command->help));
    text += RoffOptions(command->options);
  }
  text += ".SH OPTIONS OF EVERY COMMAND\n" + RoffOptions(program.options);
  text += ".SH KEYS OF [adjust]\nIn the file block.toml and, dotted, for\n.BR \\-\\-set .\n";
  for (const SetKey& key : SetKeysOf("adjust")) text += RoffItem(key.key, key.text);
  text += ".SH EXIT STATUS\n";
  for (const auto& [code, meaning] : ExitCodes()) {
    text += RoffItem(std::to_string(code), meaning + ".");
  }
  text += ".SH EXAMPLES\n.nf\n";
  for (const char* example : kExamples) text += RoffText(example) + "\n";
  text += ".fi\n";
  text +=
      ".SH FILES\nA block is a folder of block.toml, trajectories.csv, observations.csv and "
      "points.csv; a result is a folder of summary.json and tables.\n"
      "The manual is in /usr/share/doc/sarblock, scenes are in /usr/share/sarblock/scenes.\n"
      ".SH SEE ALSO\nF. Leberl (1979), Accuracy Analysis of Stereo Side\\-Looking Radar.\n";
  return text;
}

std::string ManualMarkdown(const CommandDefinition& program) {
  std::string text =
      "# Every command and option\n\n"
      "Written by `sarblock --dump-manual markdown` from the definitions that read the command "
      "line; do\nnot edit. The same as `man sarblock`. Keys of `--set`: [every key of "
      "`[adjust]`](adjust_options.md),\n[every key of a scene](scenes.md#keys).\n\n"
      "## Options of every command\n\n" +
      MarkdownOptions(program.options) +
      "\nResults go to files or to standard output, messages and the progress bar to standard "
      "error.\n\n## Exit codes\n\n| code | meaning |\n| --- | --- |\n";
  for (const auto& [code, meaning] : ExitCodes()) {
    text += fmt::format("| {} | {} |\n", code, meaning);
  }
  for (const CommandDefinition* command : RunnableCommands(program)) {
    text += fmt::format("\n## sarblock {}\n\n{}.\n\n<!-- run: form -->\n\n    {}\n",
                        command->path,
                        command->help,
                        Synopsis(*command));
    if (!command->options.empty()) text += "\n" + MarkdownOptions(command->options);
  }
  text += "\n## Examples\n\n";
  for (const char* example : kExamples) text += fmt::format("    {}\n", example);
  return text;
}

std::string ManualKeys(const CommandDefinition& program) {
  std::string text;
  for (const CommandDefinition* command : RunnableCommands(program)) {
    for (const SetKey& key : SetKeysOf(command->path))
      text += command->path + "\t" + key.key + "\n";
  }
  return text;
}

namespace {

std::string Words(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

std::string OptionWords(const std::vector<OptionDefinition>& options) {
  std::string text;
  for (const OptionDefinition& option : options) {
    if (!option.positional) text += " " + option.names.back();
  }
  return text;
}

/// The last word of a path: "sentinel1" of "import sentinel1".
std::string NameOf(const CommandDefinition& command) {
  return command.path.substr(command.path.rfind(' ') + 1);
}

std::string CommandWords(const CommandDefinition& command) {
  std::vector<std::string> names;
  for (const CommandDefinition& below : command.commands) names.push_back(NameOf(below));
  return Words(names);
}

/// Calls `visit` for the program and every command below it.
template <typename Visit>
void ForEach(const CommandDefinition& command, const Visit& visit) {
  visit(command);
  for (const CommandDefinition& below : command.commands) ForEach(below, visit);
}

// --- bash ---

constexpr const char* kBashBegin =
    R"(# bash completion for sarblock; printed by `sarblock --completion bash`.
_sarblock() {
  # Words by blanks alone: `=` belongs to --set KEY=VALUE, whatever COMP_WORDBREAKS says.
  local line=${COMP_LINE:0:COMP_POINT} words=() command="" commands="" options="" kind="file"
  local values="" i
  read -ra words <<< "$line"
  [[ $line == *[[:space:]] ]] && words+=("")
  local cur=${words[${#words[@]} - 1]} prev=${words[${#words[@]} - 2]}
  COMPREPLY=()
  for ((i = 1; i < ${#words[@]} - 1; ++i)); do
    case "$command:${words[i]}" in
)";

constexpr const char* kBashEnd = R"(
  if [[ $cur == -* && $kind != key ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$cur")
    return
  fi
  case "$kind" in
    number) ;;
    choice) mapfile -t COMPREPLY < <(compgen -W "$values" -- "$cur") ;;
    key)
      if [[ $cur == *=* ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$values" -- "${cur#*=}")
        [[ $COMP_WORDBREAKS == *=* ]] || COMPREPLY=("${COMPREPLY[@]/#/${cur%%=*}=}")
      else
        mapfile -t COMPREPLY < <(compgen -W "$values" -- "$cur")
        compopt -o nospace 2> /dev/null
      fi
      ;;
    folder)
      mapfile -t COMPREPLY < <(compgen -d -- "$cur")
      compopt -o filenames 2> /dev/null
      ;;
    *)
      if [[ -n $commands ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$commands" -- "$cur")
      else
        mapfile -t COMPREPLY < <(compgen -f -- "$cur")
        compopt -o filenames 2> /dev/null
      fi
      ;;
  esac
}
complete -F _sarblock sarblock
)";

/// The case of the option before the cursor: what it takes.
std::string BashValueCases(const CommandDefinition& command, const std::string& pattern) {
  std::string text;
  for (const OptionDefinition& option : command.options) {
    if (option.positional || option.kind == ValueKind::kNone) continue;
    std::string line;
    for (const std::string& name : option.names) {
      line += fmt::format("{}{}:{}", line.empty() ? "" : " | ", pattern, name);
    }
    switch (option.kind) {
      case ValueKind::kNumber:
        line += ") kind=number ;;";
        break;
      case ValueKind::kChoice:
        line += fmt::format(") kind=choice values=\"{}\" ;;", Words(option.choices));
        break;
      case ValueKind::kFolder:
        line += ") kind=folder ;;";
        break;
      case ValueKind::kKey:
        line += ") kind=key ;;";
        break;
      default:
        line += ") kind=file commands=\"\" ;;";
    }
    text += "    " + line + "\n";
  }
  return text;
}

/// Sets `values` for --set: keys, or the words of the key before the `=`.
std::string BashKeys(const CommandDefinition& program) {
  std::string text = "  if [[ $kind == key ]]; then\n    case \"$command:$cur\" in\n";
  for (const CommandDefinition* command : RunnableCommands(program)) {
    std::string keys;
    for (const SetKey& key : SetKeysOf(command->path)) {
      keys += (keys.empty() ? "" : " ") + key.key + "=";
      if (key.values.empty()) continue;
      text += fmt::format(
          "      \"{}:{}=\"*) values=\"{}\" ;;\n", command->path, key.key, Words(key.values));
    }
    text += fmt::format("      \"{}:\"*=*) ;;\n", command->path);
    text += fmt::format("      \"{}:\"*) values=\"{}\" ;;\n", command->path, keys);
  }
  return text + "    esac\n  fi\n";
}

}  // namespace

std::string BashCompletion(const CommandDefinition& program) {
  std::string text = kBashBegin;
  ForEach(program, [&](const CommandDefinition& command) {
    for (const CommandDefinition& below : command.commands) {
      text += fmt::format(
          "      \"{}:{}\") command=\"{}\" ;;\n", command.path, NameOf(below), below.path);
    }
  });
  text += "    esac\n  done\n  case \"$command\" in\n";
  ForEach(program, [&](const CommandDefinition& command) {
    std::string line = fmt::format("    \"{}\") commands=\"{}\" options=\"{}{} --help\"",
                                   command.path,
                                   CommandWords(command),
                                   command.path.empty() ? "" : OptionWords(command.options),
                                   OptionWords(program.options));
    // Arguments that are all folders are completed as such.
    bool folders = false, files = false;
    for (const OptionDefinition& option : command.options) {
      if (!option.positional) continue;
      (option.kind == ValueKind::kFolder ? folders : files) = true;
    }
    if (folders && !files) line += " kind=folder";
    text += line + " ;;\n";
  });
  text += "  esac\n  case \"$command:$prev\" in\n";
  ForEach(program, [&](const CommandDefinition& command) {
    text += BashValueCases(command, command.path.empty() ? "*" : "\"" + command.path + "\"");
  });
  return text + "  esac\n" + BashKeys(program) + (kBashEnd + 1);
}

}  // namespace sarblock::cli
