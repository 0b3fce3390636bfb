// SPDX-License-Identifier: Apache-2.0
// --scratch: the same bytes, less memory predicted, nothing left behind, refusals in words.
#include <cstdlib>
#include <string>
#include <vector>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

class ScratchCommandTest : public test::CliTest {
 protected:
  ScratchCommandTest() { std::filesystem::create_directory(folder_ / "files"); }

  /// With arrays by look and by point that are large enough for files.
  [[nodiscard]] Path LargeBlock() const {
    return Simulated("leberl-aircraft",
                     "block",
                     {"--set",
                      "points.count=90000",
                      "--set",
                      "navigation.constant_sigma_m=[1, 1, 1]"});  // settles in few iterations
  }
  [[nodiscard]] bool NothingLeft() const { return std::filesystem::is_empty(folder_ / "files"); }

  void ExpectSameTables(const std::string& a, const std::string& b) const {
    std::size_t tables = 0;
    for (const std::string& name : FilesOf(folder_ / a)) {
      if (!name.ends_with(".csv")) continue;
      ++tables;
      EXPECT_TRUE(Content(folder_ / a / name) == Content(folder_ / b / name)) << name;
    }
    EXPECT_GT(tables, 2U);
    EXPECT_EQ(FilesOf(folder_ / a), FilesOf(folder_ / b));
  }
  [[nodiscard]] nlohmann::json NeedsOf(const std::vector<std::string>& arguments) const {
    const test::ProgramRun run = test::RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return nlohmann::json::parse(run.out)["needs"];
  }
};

TEST_F(ScratchCommandTest, WritesTheSameBytesWithLessMemory) {
  const Path block = LargeBlock();
  const std::string files = folder_ / "files";
  // What is mapped is counted apart from memory.
  const nlohmann::json memory = NeedsOf({"check", block, "--json"});
  const nlohmann::json apart = NeedsOf({"check", block, "--json", "--scratch", files});
  const double scratch_bytes = apart["scratch_bytes"].get<double>();
  EXPECT_EQ(memory["scratch_bytes"].get<double>(), 0.0);
  EXPECT_GT(scratch_bytes, 20e6);
  EXPECT_EQ(memory["memory_bytes"].get<double>() - apart["memory_bytes"].get<double>(),
            scratch_bytes);
  EXPECT_THAT(test::RunProgram({"check", block, "--scratch", files}).out,
              HasSubstr(" MiB in scratch files (looks "));

  // A limit between both refuses the one and not the other.
  const std::string limit =
      std::to_string((memory["memory_bytes"].get<double>() - 0.5 * scratch_bytes) / (1 << 20));
  const test::ProgramRun refused = Run("adjust", block, "refused", {"--memory", limit});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, HasSubstr(", with looks and points in files (--scratch) or for a part"));
  const std::vector<std::string> both = {"--memory", limit, "--scratch", files};
  EXPECT_EQ(Run("adjust", block, "adjusted-mapped", both).exit_code, 0);
  EXPECT_TRUE(NothingLeft());

  // Tables of a folder, and those of an HDF5 file.
  EXPECT_EQ(Run("adjust", block, "adjusted").exit_code, 0);
  ExpectSameTables("adjusted", "adjusted-mapped");
  ASSERT_EQ(Run("intersect", block, "plain.h5").exit_code, 0);
  ASSERT_EQ(Run("intersect", block, "mapped.h5", {"--scratch", files}).exit_code, 0);
  for (const std::string name : {"plain", "mapped"}) {
    const test::ProgramRun run =
        test::RunProgram({"convert", folder_ / (name + ".h5"), folder_ / name});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  ExpectSameTables("plain", "mapped");

  // A limit of the shell stands for a disk that is full in the middle of the work.
  const std::string line = "ulimit -f 2000; cd '" + folder_.string() +
                           "' && '" SARBLOCK_PROGRAM
                           "' adjust block -o refused --scratch files 2>said";
  const int status = std::system(line.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 3);
  EXPECT_THAT(Content(folder_ / "said"), HasSubstr("sarblock: files: has no place for a scratch "));
  EXPECT_THAT(Content(folder_ / "said"), HasSubstr("MiB: File too large; --scratch takes"));
  EXPECT_TRUE(FilesOf(folder_ / "refused").empty());
  EXPECT_TRUE(NothingLeft());
}

TEST_F(ScratchCommandTest, RefusesAFolderThatCannotBeWritten) {
  const Path block = Simulated("leberl-aircraft", "block");
  std::ofstream(folder_ / "file") << "text";
  for (const Path& folder : {folder_ / "missing", folder_ / "file", Path("/proc")}) {
    for (const char* command : {"adjust", "intersect", "predict"}) {
      const test::ProgramRun run = Run(command, block, "result", {"--scratch", folder});
      EXPECT_EQ(run.exit_code, 3) << command;
      EXPECT_THAT(run.err, HasSubstr(folder.string() + ": has no place for a scratch file: "));
      EXPECT_TRUE(FilesOf(folder_ / "result").empty());
    }
    EXPECT_EQ(test::RunProgram({"check", block, "--scratch", folder}).exit_code, 3);
  }
}

}  // namespace
}  // namespace sarblock
