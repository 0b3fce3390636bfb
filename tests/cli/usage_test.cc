// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "support/run_program.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::ProgramRun;
using test::RunProgram;
using testing::HasSubstr;
using testing::Not;

/// All commands, each as its words, as the manual heads its sections.
const std::vector<std::vector<std::string>>& Commands() {
  static const auto commands = [] {
    std::vector<std::vector<std::string>> out;
    std::istringstream manual(RunProgram({"--dump-manual", "markdown"}).out);
    const std::string head = "## sarblock ";
    for (std::string line; std::getline(manual, line);) {
      if (!line.starts_with(head)) continue;
      std::istringstream words(line.substr(head.size()));
      out.emplace_back();
      for (std::string word; words >> word;) out.back().push_back(word);
    }
    return out;
  }();
  return commands;
}

TEST(UsageTest, HelpGoesToStandardOutputAndNamesEveryCommandAndGlobalOption) {
  const ProgramRun run = RunProgram({"--help"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.err, "");
  ASSERT_GT(Commands().size(), 20u);
  for (const auto& command : Commands()) EXPECT_THAT(run.out, HasSubstr("  " + command[0] + " "));
  for (const char* option :
       {"--help", "--version", "--threads", "--quiet", "--json", "--set", "--dump-config"}) {
    EXPECT_THAT(run.out, HasSubstr(option));
  }
}

TEST(UsageTest, EveryCommandHasHelp) {
  for (std::vector<std::string> arguments : Commands()) {
    std::string usage = "Usage: sarblock ";
    for (const std::string& word : arguments) usage += word + " ";
    arguments.emplace_back("--help");
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 0) << usage;
    EXPECT_THAT(run.out, HasSubstr(usage));
    EXPECT_EQ(run.err, "") << usage;
  }
}

TEST(UsageTest, EveryHelpFits80Columns) {
  std::set<std::vector<std::string>> all = {{}};
  for (const std::vector<std::string>& command : Commands()) {
    all.insert(command);
    all.insert({command[0]});
  }
  for (std::vector<std::string> arguments : all) {
    arguments.emplace_back("--help");
    std::istringstream lines(RunProgram(arguments).out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
  }
}

TEST(UsageTest, VersionIsThatOfTheLibrary) {
  const ProgramRun run = RunProgram({"--version"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out, std::string("sarblock ") + Version() + "\n");
  EXPECT_EQ(run.err, "");
}

TEST(UsageTest, HelpAndVersionAreCommandsToo) {
  EXPECT_EQ(RunProgram({"help"}).out, RunProgram({"--help"}).out);
  EXPECT_EQ(RunProgram({"help", "adjust"}).out, RunProgram({"adjust", "--help"}).out);
  EXPECT_EQ(RunProgram({"version"}).out, RunProgram({"--version"}).out);
}

TEST(UsageTest, HelpOfACommandNamesWhatAllHaveAndChoicesAsWords) {
  for (const char* command : {"simulate", "check", "adjust", "predict", "intersect"}) {
    const std::string help = RunProgram({command, "--help"}).out;
    for (const char* option : {"--threads N", "-q,--quiet", "--json", "--set KEY=VALUE"}) {
      EXPECT_THAT(help, HasSubstr(option)) << command;
    }
  }
  EXPECT_THAT(RunProgram({"report", "--help"}).out, Not(HasSubstr("--set")));
  EXPECT_THAT(RunProgram({"import", "sentinel1", "--help"}).out,
              HasSubstr("{check,control,none,tie}"));
}

}  // namespace
}  // namespace sarblock
