// SPDX-License-Identifier: Apache-2.0
#include <set>

#include "manual.h"
#include <fmt/core.h>

namespace sarblock::cli {
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

/// Sets `values` for --set: keys, or the words of the key that stands before the `=`.
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

// --- zsh ---

/// Text inside [...] of a specification that stands in single quotes.
std::string ZshText(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\'') {
      escaped += "'\\''";
    } else {
      if (c == '[' || c == ']' || c == ':' || c == '\\') escaped += '\\';
      escaped += c;
    }
  }
  return escaped;
}

std::string ZshAction(const OptionDefinition& option, const std::string& path) {
  switch (option.kind) {
    case ValueKind::kNumber:
      return ": ";
    case ValueKind::kChoice:
      return ":(" + Words(option.choices) + ")";
    case ValueKind::kFolder:
      return ":_files -/";
    case ValueKind::kKey: {
      std::string keys;
      for (const SetKey& key : SetKeysOf(path)) keys += " " + key.key + "=";
      return ":compadd -S \"\" --" + keys;
    }
    default:
      return ":_files";
  }
}

std::string ZshOptions(const std::vector<OptionDefinition>& options, const std::string& path) {
  std::string text;
  for (const OptionDefinition& option : options) {
    if (option.positional) {
      text += fmt::format(" \\\n        '{}:{}{}'",
                          option.several ? "*" : "",
                          ZshText(option.names[0]),
                          ZshAction(option, path));
      continue;
    }
    for (const std::string& name : option.names) {
      text += fmt::format(
          " \\\n        '{}{}[{}]", option.several ? "*" : "", name, ZshText(option.help));
      if (option.kind != ValueKind::kNone) {
        text += ":" + ZshText(option.value) + ZshAction(option, path);
      }
      text += "'";
    }
  }
  return text;
}

std::string ZshDescribe(const CommandDefinition& command) {
  std::string text;
  for (const CommandDefinition& below : command.commands) {
    text += fmt::format(" '{}:{}'", NameOf(below), ZshText(below.help));
  }
  return text;
}

// --- fish ---

std::string FishText(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\'' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return "'" + escaped + "'";
}

std::string FishCondition(const std::string& path) {
  if (path.empty()) return "";
  std::string condition;
  std::string rest = path;
  while (!rest.empty()) {
    const std::size_t blank = std::min(rest.find(' '), rest.size());
    condition += (condition.empty() ? "" : "; and ") +
                 ("__fish_seen_subcommand_from " + rest.substr(0, blank));
    rest.erase(0, std::min(blank + 1, rest.size()));
  }
  return " -n " + FishText(condition);
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

std::string ZshCompletion(const CommandDefinition& program) {
  std::string text =
      "#compdef sarblock\n# zsh completion; printed by `sarblock --completion zsh`.\n"
      "_sarblock() {\n  local context state state_descr line command=\"\" i\n  typeset -A "
      "opt_args\n"
      "  for ((i = 2; i < CURRENT; ++i)); do\n    case \"$command:${words[i]}\" in\n";
  ForEach(program, [&](const CommandDefinition& command) {
    for (const CommandDefinition& below : command.commands) {
      text +=
          fmt::format("      '{}:{}') command='{}' ;;\n", command.path, NameOf(below), below.path);
    }
  });
  text +=
      "    esac\n  done\n  local depth=${#${(z)command}}\n"
      "  words=(sarblock \"${words[@]:$((depth + 1))}\")\n  ((CURRENT -= depth))\n"
      "  case \"$command\" in\n";
  ForEach(program, [&](const CommandDefinition& command) {
    const std::string common = ZshOptions(program.options, command.path);
    const std::string own = command.path.empty() ? "" : ZshOptions(command.options, command.path);
    text += fmt::format("    '{}')\n", command.path);
    if (command.commands.empty()) {
      text += fmt::format("      _arguments -s{}{}\n", own, common);
    } else {
      text += fmt::format("      local -a commands=({})\n", ZshDescribe(command));
      text += fmt::format(
          "      _arguments -s '1:command:->command'{}\n"
          "      [[ $state == command ]] && _describe command commands\n",
          common);
    }
    text += "      ;;\n";
  });
  return text + "  esac\n}\n_sarblock \"$@\"\n";
}

std::string FishCompletion(const CommandDefinition& program) {
  std::string text = "# fish completion for sarblock; printed by `sarblock --completion fish`.\n";
  ForEach(program, [&](const CommandDefinition& command) {
    for (const CommandDefinition& below : command.commands) {
      std::string condition = "__fish_use_subcommand";
      if (!command.path.empty()) {
        condition = "__fish_seen_subcommand_from " + command.path +
                    "; and not __fish_seen_subcommand_from " + CommandWords(command);
      }
      text += fmt::format("complete -c sarblock -f -n {} -a {} -d {}\n",
                          FishText(condition),
                          NameOf(below),
                          FishText(below.help));
    }
    for (const OptionDefinition& option : command.options) {
      if (option.positional) continue;
      std::string line = "complete -c sarblock" + FishCondition(command.path);
      for (const std::string& name : option.names) {
        line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      }
      if (option.kind == ValueKind::kChoice) line += " -x -a " + FishText(Words(option.choices));
      if (option.kind == ValueKind::kFolder) line += " -x -a '(__fish_complete_directories)'";
      if (option.kind == ValueKind::kNumber || option.kind == ValueKind::kKey) line += " -x";
      if (option.kind == ValueKind::kText) line += " -r -F";
      text += line + " -d " + FishText(option.help) + "\n";
    }
  });
  for (const CommandDefinition* command : RunnableCommands(program)) {
    std::string keys;
    for (const SetKey& key : SetKeysOf(command->path)) {
      keys += (keys.empty() ? "" : " ") + key.key + "=";
    }
    if (keys.empty()) continue;
    text += fmt::format(
        "complete -c sarblock{} -l set -x -a '{}'\n", FishCondition(command->path), keys);
  }
  return text;
}

}  // namespace sarblock::cli
