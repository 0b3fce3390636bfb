// SPDX-License-Identifier: Apache-2.0
// `study tradeoff` as a user runs it, on a tiny study. Nothing is timed: the files hold what they
// should, and an interrupted study goes on.
#include <string>
#include <vector>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

class StudyTradeoffTest : public test::CliTest {
 protected:
  test::ProgramRun Study(const std::vector<std::string>& more = {}) {
    const std::string scene = std::string(SARBLOCK_DATASETS) + "/scenes/block-12-strips.toml";
    const std::string text = "format = \"sarblock-study 1\"\nstudy = \"tradeoff\"\nscene = \"" +
                             scene + "\"\nrepeats = 2\n" + R"(
[[size]]
points = 60
set = ["points.count=60"]

[[size]]
points = 70
longest_s = 1e-9
set = ["points.count=70"]

[[size.skip]]
rows = ["solver", "covariance.block-ceres"]
reason = "seventy are too many"

[[choice]]
stage = "model"
name = "given"
reference = true

[[choice]]
stage = "model"
name = "leberl"
threads = 1
most_points = 60
reason = "sixty are enough"
set = ["corrections=none", "covariance=leberl"]

[[choice]]
stage = "covariance"
name = "block"
reference = true

[[choice]]
stage = "covariance"
name = "block-ceres"
set = ["covariance_method=ceres"]

[[choice]]
stage = "solver"
name = "reduced"
reference = true
threads = 1

[[choice]]
stage = "solver"
name = "ceres"
set = ["engine=ceres"]
)";
    std::vector<std::string> arguments = {
        "study", "tradeoff", Put("study.toml", text), "-o", folder_ / "out", "--threads", "2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return test::RunProgram(arguments);
  }

  std::string Cell(const std::string& choice,
                   const std::string& column,
                   const std::string& points = "60") {
    const auto rows = test::RowsOf(Content(folder_ / "out" / "tradeoff.csv"));
    const std::size_t at = test::ColumnOf(rows, column);
    for (const auto& row : rows) {
      if (row[1] == choice && row[2] == points) return row[at];
    }
    ADD_FAILURE() << "no row " << choice;
    return "";
  }
};

TEST_F(StudyTradeoffTest, ComparesEveryChoiceWithItsReference) {
  const test::ProgramRun run = Study();
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("60 points: "));
  EXPECT_EQ(Cell("given", "speed_ratio"), "1");
  EXPECT_LT(std::stod(Cell("given", "position_error_sigma")), 1e-6);
  EXPECT_LT(std::stod(Cell("given", "covariance_error")), 1e-6);
  EXPECT_EQ(Cell("block-ceres", "accepted"), "1");
  EXPECT_LT(std::stod(Cell("block-ceres", "covariance_error")), 1e-9);
  EXPECT_GT(std::stod(Cell("leberl", "position_error_sigma")), 1.0);
  EXPECT_LT(std::stod(Cell("ceres", "position_error_sigma")), 1e-6);
  EXPECT_GT(std::stod(Cell("given", "nees")), 0.1);
  EXPECT_LT(std::stod(Cell("given", "nees")), 10.0);
  EXPECT_THAT(FilesOf(folder_ / "out"),
              testing::IsSupersetOf({"tradeoff.csv",
                                     "tradeoff.md",
                                     "tradeoff.txt",
                                     "tradeoff_error.svg",
                                     "tradeoff_time.svg"}));
}

TEST_F(StudyTradeoffTest, SaysWhichRowsASizeDoesWithoutAndWhy) {
  ASSERT_EQ(Study().exit_code, 0);
  EXPECT_EQ(Cell("given", "threads", "70"), "2");
  EXPECT_EQ(Cell("leberl", "threads"), "1");
  EXPECT_EQ(Cell("reduced", "threads"), "1");
  EXPECT_EQ(Cell("given", "note", "70"), "");
  EXPECT_EQ(Cell("given", "repeats"), "2");
  EXPECT_EQ(Cell("given", "repeats", "70"), "1");  // no time for more
  EXPECT_EQ(Cell("leberl", "note", "70"), "not run: sixty are enough");
  for (const std::string choice : {"reduced", "ceres", "block-ceres"}) {
    EXPECT_EQ(Cell(choice, "repeats"), "2");
    EXPECT_EQ(Cell(choice, "repeats", "70"), "0");
    EXPECT_EQ(Cell(choice, "wall_s", "70"), "");
    EXPECT_EQ(Cell(choice, "note", "70"), "not run: seventy are too many");
  }
  EXPECT_THAT(Content(folder_ / "out" / "tradeoff.md"), HasSubstr("not run: sixty are enough"));
}

TEST_F(StudyTradeoffTest, GoesOnAfterAnInterruptionWithTheRowsItHas) {
  ASSERT_EQ(Study().exit_code, 0);
  const Path progress = folder_ / "out" / "tradeoff.progress";
  const std::string whole = Content(folder_ / "out" / "tradeoff.csv");
  const std::string wall = Cell("given", "wall_s");
  // As a killed run leaves it: the last record is half there.
  const std::string record = Content(progress);
  Put("out/tradeoff.progress", record.substr(0, record.rfind("end ")));
  const test::ProgramRun run = Study();
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("11 of 12 tasks of the study are there already"));
  EXPECT_EQ(Cell("given", "wall_s"), wall);
  EXPECT_NE(Cell("ceres", "wall_s"), "");
  ASSERT_EQ(Study().exit_code, 0);
  EXPECT_EQ(Cell("given", "pareto"), "1");
}

TEST_F(StudyTradeoffTest, MeasuresTheRowsThatAreAskedForByTheClockThatIs) {
  ASSERT_EQ(Study({"--set", "only=[\"model.leberl\", \"speed\"]"}).exit_code, 3);
  const test::ProgramRun run =
      Study({"--set", "only=[\"model\"]", "--set", "only_points=[60]", "--set", "clock=cpu"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(test::RowsOf(Content(folder_ / "out" / "tradeoff.csv")).size(), 3U);
  EXPECT_EQ(Cell("leberl", "clock"), "cpu");
  EXPECT_THAT(Content(folder_ / "out" / "tradeoff.md"), HasSubstr("speed by CPU time"));
}

TEST_F(StudyTradeoffTest, RefusesAFolderOfOtherSettings) {
  ASSERT_EQ(Study({"--set", "only=[\"model\"]"}).exit_code, 0);
  const test::ProgramRun run = Study({"--set", "repeats=1"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("belongs to another study"));
}

// The shipped study of an orbit with a state a minute: auto is one of the ways, the cubics through
// its states are not even near.
TEST_F(StudyTradeoffTest, ComparesTheWaysToReadARecordedFlight) {
  const test::ProgramRun run =
      test::RunProgram({"study",
                        "tradeoff",
                        std::string(SARBLOCK_DATASETS) + "/studies/recorded-orbit.toml",
                        "-o",
                        folder_ / "out",
                        "--set",
                        "only_points=[300]",
                        "--set",
                        "repeats=1"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LT(std::stod(Cell("orbit", "position_error_sigma", "300")), 1e-6);
  EXPECT_LT(std::stod(Cell("positions", "position_error_sigma", "300")), 0.5);
  EXPECT_GT(std::stod(Cell("states", "position_error_sigma", "300")), 1.0);
  EXPECT_GT(std::stod(Cell("states", "nees", "300")), 2.0 * std::stod(Cell("auto", "nees", "300")));
}

}  // namespace
}  // namespace sarblock
