// SPDX-License-Identifier: Apache-2.0
#include "manual.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/core.h>

namespace sarblock::cli {
namespace {

constexpr const char* kDescription =
    "Takes what was measured in overlapping radar images (azimuth times, slant ranges, squints or "
    "Doppler centroids), the flight paths as recorded and the points that are known, and gives the "
    "most probable positions of all points and corrections of all flight paths, each with its "
    "exact covariance. A simulator with known truth and the closed forms of Leberl (1979) stand "
    "beside it.";

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

}  // namespace sarblock::cli
