// SPDX-License-Identifier: Apache-2.0
// Invariance: the same bytes on any number of threads, on blocks of several chunks of points.
#include <string>
#include <vector>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>

namespace sarblock {
namespace {

class ThreadsTest : public test::CliTest {
 protected:
  /// Every file of two folders but the summary, which holds times and memory.
  static void ExpectSameBytes(const Path& a, const Path& b) {
    ASSERT_EQ(FilesOf(a), FilesOf(b));
    for (const std::string& name : FilesOf(a)) {
      if (name == "summary.json") continue;
      EXPECT_EQ(Content(a / name), Content(b / name)) << name;
    }
  }

  void ExpectIndependentOfThreads(const std::string& scene, const std::vector<std::string>& sets) {
    std::vector<Path> blocks;
    for (const std::string threads : {"1", "2", "3"}) {
      std::vector<std::string> more = {"--threads", threads};
      for (const std::string& set : sets) more.insert(more.end(), {"--set", set});
      const std::string file = std::string(SARBLOCK_DATASETS) + "/" + scene + ".toml";
      std::vector<std::string> simulate = {"simulate", file, "-o", folder_ / ("block" + threads)};
      simulate.insert(simulate.end(), more.begin(), more.end());
      ASSERT_EQ(test::RunProgram(simulate).exit_code, 0);
      blocks.push_back(folder_ / ("block" + threads));
      ASSERT_EQ(Run("adjust", blocks.front(), "result" + threads, {"--threads", threads}).exit_code,
                0);
    }
    for (const std::string threads : {"2", "3"}) {
      ExpectSameBytes(blocks.front(), folder_ / ("block" + threads));
      ExpectSameBytes(folder_ / "result1", folder_ / ("result" + threads));
    }
  }
};

TEST_F(ThreadsTest, StripsGiveTheSameBytes) {
  ExpectIndependentOfThreads("benchmarks/strips", {"points.count=5000"});
}

// A net whose elimination tree has branches, pairs among the results.
TEST_F(ThreadsTest, ANetGivesTheSameBytes) {
  ExpectIndependentOfThreads("benchmarks/network",
                             {"points.count=4500",
                              "flight.0.count=6",
                              "flight.0.segments=5",
                              "flight.1.count=6",
                              "flight.1.segments=5",
                              "points.east_m=[500, 25500]",
                              "points.north_m=[13500, 61000]",
                              "control.count=20",
                              "adjust.pairs=neighbours"});
}

}  // namespace
}  // namespace sarblock
