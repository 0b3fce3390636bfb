// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

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

const std::vector<std::string>& Commands() {
  static const std::vector<std::string> commands = {"simulate",
                                                    "import",
                                                    "check",
                                                    "intersect",
                                                    "predict",
                                                    "adjust",
                                                    "report",
                                                    "export",
                                                    "convert",
                                                    "study",
                                                    "leberl"};
  return commands;
}

TEST(UsageTest, HelpGoesToStandardOutputAndNamesEveryCommandAndGlobalOption) {
  const ProgramRun run = RunProgram({"--help"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.err, "");
  for (const std::string& command : Commands()) EXPECT_THAT(run.out, HasSubstr(command));
  for (const char* option :
       {"--help", "--version", "--threads", "--quiet", "--json", "--set", "--dump-config"}) {
    EXPECT_THAT(run.out, HasSubstr(option));
  }
}

TEST(UsageTest, EveryCommandHasHelp) {
  for (const std::string& command : Commands()) {
    const ProgramRun run = RunProgram({command, "--help"});
    EXPECT_EQ(run.exit_code, 0) << command;
    EXPECT_THAT(run.out, HasSubstr(command));
    EXPECT_EQ(run.err, "") << command;
  }
}

TEST(UsageTest, EveryHelpFits80Columns) {
  std::vector<std::vector<std::string>> all = {{}, {"import", "sentinel1"}, {"leberl", "errors"}};
  for (const std::string& command : Commands()) all.push_back({command});
  for (const char* study : {"densification", "tradeoff", "stability"}) {
    all.push_back({"study", study});
  }
  for (std::vector<std::string>& arguments : all) {
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
