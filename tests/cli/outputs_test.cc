// SPDX-License-Identifier: Apache-2.0
// Folders that commands write to: files of others are kept, nothing stale stays beside new tables,
// and a run that is killed or finds no space leaves the old result, the new one, or none.
#include <csignal>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sarblock {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class OutputsTest : public test::CliTest {
 protected:
  /// Names and contents of every file of a folder.
  static std::map<std::string, std::string> Contents(const Path& folder) {
    std::map<std::string, std::string> contents;
    for (const std::string& name : FilesOf(folder)) {
      if (std::filesystem::is_regular_file(folder / name)) contents[name] = Content(folder / name);
    }
    return contents;
  }

  /// Number of a process that is no longer.
  static pid_t EndedProcess() {
    const pid_t child = fork();
    if (child == 0) _exit(0);
    int status = 0;
    waitpid(child, &status, 0);
    return child;
  }
};

TEST_F(OutputsTest, AnotherBlockIsNotOverwrittenByAResult) {
  const Path block = Simulated("leberl-aircraft", "block");
  const Path other = Simulated("opposite-side", "other", {"--set", "points.count=12"});
  const auto before = Contents(other);
  for (const char* command : {"adjust", "intersect", "predict"}) {
    const test::ProgramRun run = Run(command, block, "other");
    EXPECT_EQ(run.exit_code, 3) << command;
    EXPECT_THAT(run.err, HasSubstr("is a block, whose tables a result would overwrite"));
    EXPECT_TRUE(Contents(other) == before) << command;
  }
  EXPECT_EQ(Run("adjust", block, "other", {"--force"}).exit_code, 0);
  EXPECT_TRUE(FilesOf(other).contains("summary.json"));
}

TEST_F(OutputsTest, FilesOfOthersAreKept) {
  const Path block = Simulated("leberl-aircraft", "block");
  std::filesystem::create_directories(folder_ / "foreign");
  for (const char* name : {"points.csv", "pairs.csv", "montecarlo.csv", "selection.csv", "notes"}) {
    Put(std::string("foreign/") + name, "years of work\n");
  }
  Put("foreign/summary.json", "{\"format\": \"mine\"}\n");
  const auto before = Contents(folder_ / "foreign");
  const std::vector<std::vector<std::string>> commands = {
      {"adjust", block, "-o", folder_ / "foreign"},
      {"predict", block, "-o", folder_ / "foreign", "--gzip"},
      {"simulate",
       std::string(SARBLOCK_DATASETS) + "/scenes/leberl-aircraft.toml",
       "-o",
       folder_ / "foreign"}};
  for (const auto& command : commands) {
    const test::ProgramRun run = test::RunProgram(command);
    EXPECT_EQ(run.exit_code, 3) << command[0];
    EXPECT_THAT(run.err, HasSubstr("foreign: is not empty and no ")) << command[0];
    EXPECT_TRUE(Contents(folder_ / "foreign") == before) << command[0];
  }
}

TEST_F(OutputsTest, AHandMadeBlockIsNotReplacedByASimulatedOne) {
  const Path block = Simulated("leberl-aircraft", "block");
  std::string toml = Content(block / "block.toml");
  Put("block/block.toml", toml.substr(toml.find("format = ")));  // as one writes it by hand
  const auto before = Contents(block);
  const std::string scene = std::string(SARBLOCK_DATASETS) + "/scenes/opposite-side.toml";
  EXPECT_EQ(test::RunProgram({"simulate", scene, "-o", block}).exit_code, 3);
  EXPECT_TRUE(Contents(block) == before);
  EXPECT_EQ(test::RunProgram({"simulate", scene, "-o", block, "--force"}).exit_code, 0);
  EXPECT_EQ(test::RunProgram({"simulate", scene, "-o", block}).exit_code, 0);  // now one of ours
}

TEST_F(OutputsTest, NothingOfAnEarlierResultStaysBesideTheNewOne) {
  const Path block = Simulated("leberl-aircraft", "block");
  ASSERT_EQ(Run("adjust", block, "result", {"--set", "pairs=neighbours", "--report"}).exit_code, 0);
  const std::string left = ".points.csv.tmp-" + std::to_string(EndedProcess());
  Put("result/" + left, "half a table");
  Put("result/notes.txt", "mine\n");
  ASSERT_TRUE(FilesOf(folder_ / "result").contains("report.html"));
  ASSERT_EQ(Run("adjust", block, "result", {"--gzip"}).exit_code, 0);
  const auto files = FilesOf(folder_ / "result");
  for (const std::string& name :
       {std::string("report.html"), std::string("pairs.csv"), std::string("points.csv"), left}) {
    EXPECT_FALSE(files.contains(name)) << name;
  }
  EXPECT_TRUE(files.contains("points.csv.gz"));
  EXPECT_TRUE(files.contains("notes.txt"));
}

TEST_F(OutputsTest, AKilledRunLeavesTheOldResultTheNewOneOrNone) {
  const Path block = Simulated("block-12-strips", "block", {"--set", "points.count=3000"});
  ASSERT_EQ(Run("adjust", block, "old", {"--set", "covariance=none"}).exit_code, 0);
  const auto old = Contents(folder_ / "old");
  ASSERT_EQ(Run("adjust", block, "new", {"--set", "robust=cauchy"}).exit_code, 0);
  const auto expected = Contents(folder_ / "new");
  constexpr std::size_t kKills = 12;
  for (std::size_t k = 1; k <= kKills; ++k) {
    std::filesystem::remove_all(folder_ / "result");
    std::filesystem::copy(folder_ / "old", folder_ / "result");
    test::Program program(folder_,
                          {"adjust", block, "-o", folder_ / "result", "--set", "robust=cauchy"});
    // While it writes: where its k-th file is begun, beside those of the older result, or at its
    // end.
    const auto files = [&] {
      std::size_t count = 0;
      std::error_code gone;  // a folder that goes away meanwhile ends the count
      auto entry = std::filesystem::recursive_directory_iterator(folder_ / "result", gone);
      for (; !gone && entry != std::filesystem::recursive_directory_iterator(); ++count) {
        entry.increment(gone);
      }
      return count;
    };
    while (program.Running() && files() < old.size() + k) std::this_thread::yield();
    program.Signal(SIGKILL);
    static_cast<void>(program.Wait());
    auto left = Contents(folder_ / "result");
    left.erase(".sarblock-lock");  // which nobody holds any more
    if (!left.contains("summary.json")) continue;
    const json summary = json::parse(left.at("summary.json"));
    const bool is_old = summary["configuration"]["robust"] == "none";
    const auto& same = is_old ? old : expected;
    for (const auto& [name, text] : same) {
      if (name == "summary.json") continue;  // has times
      EXPECT_TRUE(left.contains(name) && left.at(name) == text) << name << " of kill " << k;
    }
    EXPECT_EQ(left.size(), same.size());
  }
  // Whatever the last kill left is no reason to refuse the folder, and is cleared.
  ASSERT_EQ(Run("adjust", block, "result", {"--set", "robust=cauchy"}).exit_code, 0);
  for (const std::string& name : FilesOf(folder_ / "result")) EXPECT_FALSE(name.starts_with("."));
}

// A limit on the size of files meets the writer as a full disk does: the write fails.
TEST_F(OutputsTest, AWriteThatFailsLeavesTheOldResultWhole) {
  const Path block = Simulated("leberl-aircraft", "block");
  ASSERT_EQ(Run("adjust", block, "result").exit_code, 0);
  const auto before = Contents(folder_ / "result");
  struct rlimit limit {};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);  // inherited: the write fails instead
  for (const rlim_t bytes : {rlim_t{0}, rlim_t{3000}, rlim_t{20000}}) {
    const struct rlimit small { bytes, limit.rlim_max };
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    const test::ProgramRun run = Run("adjust", block, "result", {"--set", "robust=huber"});
    setrlimit(RLIMIT_FSIZE, &limit);
    EXPECT_EQ(run.exit_code, 3) << bytes;
    EXPECT_TRUE(Contents(folder_ / "result") == before) << bytes;
    EXPECT_EQ(FilesOf(folder_ / "result").size(), before.size()) << bytes;
  }
  std::signal(SIGXFSZ, old_handler);
}

}  // namespace
}  // namespace sarblock
