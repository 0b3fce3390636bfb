// SPDX-License-Identifier: Apache-2.0
// Files, folders and streams of this computer that cannot be used: exit code 3 with words.
#include <cstdlib>
#include <filesystem>
#include <string>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>
#include <sys/wait.h>

namespace sarblock {
namespace {

using testing::HasSubstr;
using testing::Not;

class EnvironmentTest : public test::CliTest {
 protected:
  /// Exit code of the program behind a shell that redirects; 128 and more: ended by a signal.
  [[nodiscard]] int Shell(const std::string& arguments) const {
    const std::string line = "cd '" + folder_.string() + "' && '" SARBLOCK_PROGRAM "' " + arguments;
    const int status = std::system(line.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
};

TEST_F(EnvironmentTest, FoldersThatCannotBeReachedAreInputErrors) {
  const Path block = Simulated("leberl-aircraft", "block");
  std::filesystem::create_symlink(folder_ / "loop", folder_ / "loop");
  const std::string long_name(300, 'n');
  for (const Path& folder : {folder_ / "loop", folder_ / long_name, folder_ / "block/points.csv"}) {
    for (const char* command : {"check", "report", "adjust", "intersect", "predict", "export"}) {
      const std::string name = command;
      std::vector<std::string> arguments = {name, folder};
      if (name == "export") arguments.insert(arguments.end(), {"--format", "kml"});
      if (name != "check" && name != "report") {
        arguments.insert(arguments.end(), {"-o", folder_ / "x"});
      }
      const test::ProgramRun run = test::RunProgram(arguments);
      EXPECT_EQ(run.exit_code, 3) << command << ' ' << folder << run.err;
      EXPECT_THAT(run.err, HasSubstr(folder.string().substr(0, 100))) << command;
      EXPECT_THAT(run.err, Not(HasSubstr("internal"))) << command;
    }
    const test::ProgramRun out = test::RunProgram({"adjust", block, "-o", folder / "x"});
    EXPECT_EQ(out.exit_code, 3) << folder << out.err;
    EXPECT_THAT(out.err, Not(HasSubstr("internal")));
  }
}

TEST_F(EnvironmentTest, StandardErrorThatCannotBeWrittenChangesNoExitCode) {
  static_cast<void>(Simulated("leberl-aircraft", "block"));
  EXPECT_EQ(Shell("adjust nosuch -o x 2>&-"), 3);
  EXPECT_EQ(Shell("adjust nosuch -o x 2>/dev/full"), 3);
  EXPECT_EQ(Shell("adjust block -o r1 >/dev/null 2>&-"), 0);
  EXPECT_EQ(Shell("adjust block -o r2 >/dev/null 2>/dev/full"), 0);
  EXPECT_EQ(Shell("nocommand 2>/dev/full"), 2);
  EXPECT_EQ(FilesOf(folder_ / "r1"), FilesOf(folder_ / "r2"));
}

TEST_F(EnvironmentTest, StandardOutputThatCannotBeWrittenIsAnInputError) {
  static_cast<void>(Simulated("leberl-aircraft", "block"));
  int run = 0;
  for (const char* command : {"adjust block -o r%",
                              "adjust block -o r% --json",
                              "check block --json",
                              "leberl table1 --csv",
                              "--dump-manual markdown",
                              "--help",
                              "--version"}) {
    for (const char* stream : {" >/dev/full 2>said", " >&- 2>said"}) {
      std::string line = std::string(command) + stream;
      if (const std::size_t at = line.find('%'); at != std::string::npos) {
        line.replace(at, 1, std::to_string(++run));
      }
      EXPECT_EQ(Shell(line), 3) << line;
      EXPECT_THAT(Content(folder_ / "said"), Not(HasSubstr("internal"))) << line;
      EXPECT_NE(Content(folder_ / "said"), "") << line;
    }
  }
}

}  // namespace
}  // namespace sarblock
