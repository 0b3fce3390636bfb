// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/version.h"

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

const std::vector<std::string>& Commands() {
  static const std::vector<std::string> commands = {
      "simulate", "import", "check", "intersect", "predict", "adjust", "leberl"};
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

TEST(UsageTest, VersionIsThatOfTheLibrary) {
  const ProgramRun run = RunProgram({"--version"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out, std::string("sarblock ") + Version() + "\n");
  EXPECT_EQ(run.err, "");
}

TEST(UsageTest, WrongUsageExitsWithTwoAndAMessage) {
  const std::vector<std::vector<std::string>> wrong = {
      {},
      {"adjst"},
      {"adjust"},
      {"adjust", "block"},
      {"adjust", "-o", "result"},
      {"adjust", "block", "-o", "result", "--robust", "huber"},
      {"adjust", "block", "-o", "result", "--threads", "many"},
      {"adjust", "block", "-o", "result", "--threads", "-1"},
      {"adjust", "block", "second", "-o", "result"},
      {"check"},
      {"simulate", "scene.toml"},
      {"intersect", "block"},
      {"predict", "block"},
      {"--no-such-option"},
      {"check", "block", "--set"},
  };
  for (const std::vector<std::string>& arguments : wrong) {
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 2) << testing::PrintToString(arguments);
    EXPECT_NE(run.err, "") << testing::PrintToString(arguments);
    EXPECT_EQ(run.out, "") << testing::PrintToString(arguments);
  }
}

}  // namespace
}  // namespace sarblock
