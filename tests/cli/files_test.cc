// SPDX-License-Identifier: Apache-2.0
// Files in and out: the same bytes for the same input, gzip, results as input, blocks without
// measured values, and nothing half-written after an interruption or on a full disk.
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/mount.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

class FilesTest : public test::CliTest {
 protected:
  static std::vector<std::vector<std::string>> Table(const Path& file) {
    return test::RowsOf(Content(file));
  }
  static double Number(const std::string& cell) { return std::strtod(cell.c_str(), nullptr); }

  // No temporary file, every table ends with a whole row of as many cells as its header.
  static void ExpectWhole(const Path& folder) {
    for (const std::string& name : FilesOf(folder)) {
      EXPECT_THAT(name, testing::Not(HasSubstr(".tmp"))) << folder;
      const std::string text = Content(folder / name);
      ASSERT_NE(text, "") << name;
      EXPECT_EQ(text.back(), '\n') << name;
      if (!name.ends_with(".csv")) continue;
      const auto rows = test::RowsOf(text);
      EXPECT_EQ(rows.back().size(), rows.front().size()) << name;
    }
  }
};

TEST_F(FilesTest, TheSameSeedGivesTheSameBytesWithAnyNumberOfThreads) {
  const Path one = Simulated("venus-magellan", "one", {"--threads", "1"});
  const Path two = Simulated("venus-magellan", "two", {"--threads", "2"});
  const Path other = Simulated("venus-magellan", "other", {"--set", "seed=4711"});
  for (const std::string& name : FilesOf(one)) {
    EXPECT_TRUE(Content(one / name) == Content(two / name)) << name;
  }
  EXPECT_EQ(FilesOf(one), FilesOf(two));
  EXPECT_NE(Content(one / "observations.csv"), Content(other / "observations.csv"));
}

TEST_F(FilesTest, AResultHasTheSameBytesWithAnyNumberOfThreads) {
  for (const char* scene : {"block-12-strips", "moon-alse"}) {
    const Path block = Simulated(scene, scene);
    for (const char* engine : {"auto", "reduced"}) {
      const std::string set = std::string("engine=") + engine;
      const std::vector<std::string> more = {"--set", set};
      std::vector<std::string> one = more, two = more;
      one.insert(one.end(), {"--threads", "1"});
      two.insert(two.end(), {"--threads", "2"});
      ASSERT_EQ(Run("adjust", block, "one", one).exit_code, 0);
      ASSERT_EQ(Run("adjust", block, "two", two).exit_code, 0);
      for (const char* name : {"points.csv",
                               "passes.csv",
                               "passes_covariance.csv",
                               "residuals.csv",
                               "trajectories.csv"}) {
        EXPECT_TRUE(Content(folder_ / "one" / name) == Content(folder_ / "two" / name))
            << scene << ' ' << engine << ' ' << name;
      }
    }
  }
}

TEST_F(FilesTest, GzipInAndOutHoldsTheSame) {
  const Path plain = Simulated("convergent-squint", "plain");
  const Path packed = Simulated("convergent-squint", "packed", {"--gzip"});
  EXPECT_TRUE(std::filesystem::exists(packed / "observations.csv.gz"));
  EXPECT_FALSE(std::filesystem::exists(packed / "observations.csv"));
  EXPECT_EQ(Content(packed / "observations.csv.gz").substr(0, 2), "\x1f\x8b");
  ASSERT_EQ(Run("adjust", plain, "from-plain").exit_code, 0);
  ASSERT_EQ(Run("adjust", packed, "from-packed").exit_code, 0);
  EXPECT_EQ(Content(folder_ / "from-plain/points.csv"),
            Content(folder_ / "from-packed/points.csv"));
  ASSERT_EQ(Run("adjust", packed, "to-packed", {"--gzip"}).exit_code, 0);
  EXPECT_THAT(FilesOf(folder_ / "to-packed"),
              testing::IsSupersetOf({"points.csv.gz", "residuals.csv.gz", "summary.json"}));
}

// With the corrected paths in place of the nominal ones nothing is left to correct: plain
// intersections then give the adjusted positions within what the noise of two looks leaves.
TEST_F(FilesTest, CorrectedTrajectoriesServeAsInput) {
  const Path block = Simulated("opposite-side", "block");
  ASSERT_EQ(Run("adjust", block, "result").exit_code, 0);
  const std::vector<std::string> fixed = {"--set", "corrections=none"};
  // Circles of paths that are metres off do not meet within noise: places, but not accepted.
  EXPECT_EQ(Run("intersect", block, "nominal", fixed).exit_code, 1);
  std::filesystem::copy_file(folder_ / "result/trajectories.csv",
                             block / "trajectories.csv",
                             std::filesystem::copy_options::overwrite_existing);
  ASSERT_EQ(Run("intersect", block, "corrected", fixed).exit_code, 0);
  const auto truth = Table(block / "truth.csv");
  // Root mean square of the errors of all coordinates.
  const auto rms_m = [&](const std::string& name) {
    const auto points = Table(folder_ / name / "points.csv");
    const std::size_t x = test::ColumnOf(points, "x_m");
    double sum = 0.0, count = 0.0;
    for (std::size_t i = 1; i < points.size(); ++i) {
      EXPECT_EQ(points[i][0], truth[i][0]);
      for (std::size_t k = 0; k < 3; ++k) {
        const double error_m = Number(points[i][x + k]) - Number(truth[i][1 + k]);
        sum += error_m * error_m;
        count += 1.0;
      }
    }
    EXPECT_GT(count, 900.0) << name;
    return std::sqrt(sum / count);
  };
  EXPECT_GT(rms_m("nominal"), 3.0);    // path errors of metres
  EXPECT_LT(rms_m("corrected"), 1.5);  // looks of 1 m

  // Against the adjustment, in its own sigmas.
  const auto adjusted = Table(folder_ / "result/points.csv");
  const auto points = Table(folder_ / "corrected/points.csv");
  ASSERT_EQ(points.size(), adjusted.size());
  const std::size_t sigma = test::ColumnOf(points, "sigma_e_m");
  const std::size_t status = test::ColumnOf(points, "status");
  const std::size_t x = test::ColumnOf(points, "x_m");
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i][status] != "intersected" || points[i][1] == "control") continue;
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LT(std::abs(Number(points[i][x + k]) - Number(adjusted[i][x + k])),
                Number(points[i][sigma + k]))
          << points[i][0];
    }
  }
}

TEST_F(FilesTest, PredictNeedsNoMeasuredValues) {
  const Path block = Simulated("leberl-aircraft", "block");
  ASSERT_EQ(Run("adjust", block, "adjusted").exit_code, 0);
  ASSERT_EQ(Run("predict", block, "measured").exit_code, 0);

  // Looks without time and range: columns left out.
  const auto looks = Table(block / "observations.csv");
  std::string names_only;
  for (const auto& row : looks) names_only += row[0] + "," + row[1] + "\n";
  Put("block/observations.csv", names_only);
  const test::ProgramRun no_columns = Run("predict", block, "no-columns");
  ASSERT_EQ(no_columns.exit_code, 0) << no_columns.err;
  EXPECT_EQ(Run("adjust", block, "impossible").exit_code, 3);

  // Columns with empty cells.
  std::string empty_cells = "pass,point,time_s,range_m\n";
  for (std::size_t i = 1; i < looks.size(); ++i) {
    empty_cells += looks[i][0] + "," + looks[i][1] + ",,\n";
  }
  Put("block/observations.csv", empty_cells);
  ASSERT_EQ(Run("predict", block, "no-values").exit_code, 0);

  // No looks at all: those that the passes have.
  Put("block/observations.csv", "pass,point\n");
  const test::ProgramRun no_looks = Run("predict", block, "no-looks");
  ASSERT_EQ(no_looks.exit_code, 0) << no_looks.err;

  const auto adjusted = Table(folder_ / "adjusted/points.csv");
  const std::size_t sigma = test::ColumnOf(adjusted, "sigma_e_m");
  for (const char* name : {"measured", "no-columns", "no-values", "no-looks"}) {
    const auto predicted = Table(folder_ / name / "points.csv");
    ASSERT_EQ(predicted.size(), adjusted.size()) << name;
    for (std::size_t i = 1; i < adjusted.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        // Second route: the adjustment's own. Its geometry is off by path errors of 100 m over
        // 10 km and noise, which moves a sigma by about a percent.
        EXPECT_NEAR(Number(predicted[i][sigma + k]) / Number(adjusted[i][sigma + k]), 1.0, 0.05)
            << name << ' ' << predicted[i][0];
      }
    }
  }
}

TEST_F(FilesTest, AnInterruptionLeavesNothingHalfWritten) {
  const Path block = Simulated(
      "block-12-strips", "block", {"--set", "points.count=30000", "--set", "check.count=1000"});
  const Path result = folder_ / "result";
  test::Program program(folder_, {"adjust", block, "-o", result, "--threads", "1"});
  // As it begins to write.
  while (program.Running() && !std::filesystem::exists(result)) std::this_thread::yield();
  program.Signal(SIGINT);
  const test::ProgramRun run = program.Wait();
  const auto files = FilesOf(result);
  if (run.exit_code == 0) {  // it had nothing more to interrupt
    EXPECT_TRUE(files.contains("summary.json"));
  } else {
    EXPECT_TRUE(run.exit_code == 1 || run.exit_code == -1) << run.exit_code << run.err;
    EXPECT_FALSE(files.contains("summary.json"));  // the file written last
    if (run.exit_code == 1) {
      EXPECT_THAT(run.err, HasSubstr("interrupted"));
    }
  }
  ExpectWhole(result);
  EXPECT_EQ(FilesOf(block).size(), 6u);
}

TEST_F(FilesTest, AFullDiskLeavesNothingHalfWritten) {
  const Path block = Simulated("leberl-aircraft", "block");
  const Path disk = folder_ / "disk";
  std::filesystem::create_directories(disk);
  if (mount("none", disk.c_str(), "tmpfs", 0, "size=96k") != 0) {
    GTEST_SKIP() << "a small disk cannot be mounted here";
  }
  const test::ProgramRun run = Run("adjust", block, "disk/result");
  const auto files = FilesOf(disk / "result");
  ExpectWhole(disk / "result");
  EXPECT_EQ(umount(disk.c_str()), 0);
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("No space left"));
  EXPECT_FALSE(files.contains("summary.json"));
}

}  // namespace
}  // namespace sarblock
