// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace sarblock::cli {

/// Kind of value that an option takes, for completion; a text may be a file.
enum class ValueKind { kNone, kText, kNumber, kFolder, kChoice, kKey };

/// One option or positional argument as the command line's parser knows it.
struct OptionDefinition {
  std::vector<std::string> names;  ///< "-o", "--output"; of a positional its name alone
  std::string value;               ///< placeholder of the value: "N", "FOLDER"; empty: a flag
  ValueKind kind = ValueKind::kNone;
  std::vector<std::string> choices;  ///< of kChoice
  std::string constraint;            ///< "above 0", "0 to 1024"; empty: none
  std::string standard;              ///< value where the option is left out; empty: none
  std::string help;
  bool positional = false;
  bool required = false;
  bool several = false;  ///< takes more than one value
};

/// One command with all that it understands of its own.
struct CommandDefinition {
  std::string path;  ///< "import sentinel1"; empty: the program
  std::string help;
  std::vector<OptionDefinition> options;  ///< without --help
  std::vector<CommandDefinition> commands;
};

/// The tree of commands and options, read from the parser itself, so that manual, completion and
/// tests follow every change of it.
[[nodiscard]] CommandDefinition DefinitionsOf(const CLI::App& app);

/// Every command that can be run, depth first: those that have no commands below them.
[[nodiscard]] std::vector<const CommandDefinition*> RunnableCommands(const CommandDefinition& root);

/// One key of --set.
struct SetKey {
  std::string key;
  std::vector<std::string> values;  ///< where it takes one of a few words
  std::string text;                 ///< meaning, values and default; empty for keys of a scene
};

/// What --set may be given for a command: keys of `[adjust]`, for `simulate` those of the scene
/// with the scene's `adjust.` keys, for a study those of its file; none for a command that reads no
/// configuration.
[[nodiscard]] std::vector<SetKey> SetKeysOf(const std::string& command_path);

/// Exit codes with what each means.
[[nodiscard]] std::vector<std::pair<int, std::string>> ExitCodes();

/// The manual as a page of man and as docs/commands.md; the keys of --set, one per line after their
/// command and a tab.
[[nodiscard]] std::string ManualRoff(const CommandDefinition& program);
[[nodiscard]] std::string ManualMarkdown(const CommandDefinition& program);
[[nodiscard]] std::string ManualKeys(const CommandDefinition& program);

/// Completion script of bash.
[[nodiscard]] std::string BashCompletion(const CommandDefinition& program);

/// Keys of a study file that `--set` may name of the command "study densification", ...
[[nodiscard]] std::vector<std::string> StudyKeys(const std::string& command_path);

}  // namespace sarblock::cli
