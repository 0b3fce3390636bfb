// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <csignal>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using test::Program;
using test::ProgramRun;
using test::RunProgram;
using ::testing::HasSubstr;

class StudyCommandTest : public test::CliTest {
 protected:
  /// A study of `cases` numbers of control points on a small block.
  [[nodiscard]] std::string Study(const std::string& counts, int runs) const {
    return Put("study.toml",
               "format = \"sarblock-study 1\"\nstudy = \"densification\"\nscene = \"" +
                   std::string(SARBLOCK_DATASETS) +
                   "/scenes/cross-wise.toml\"\nset = [\"points.count=60\"]\n"
                   "[[axis]]\nkey = \"control.layout\"\nvalues = [\"perimeter\"]\n"
                   "[[axis]]\nkey = \"control.count\"\nvalues = [" +
                   counts + "]\n[verify]\nruns = " + std::to_string(runs) +
                   "\n[goal]\nsigma_u_m = 100\n");
  }
  [[nodiscard]] ProgramRun Run(const std::string& study,
                               const std::string& out,
                               const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"study", "densification", study, "-o", folder_ / out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }
  [[nodiscard]] std::string Table(const std::string& out) const {
    return Content(folder_ / out / "densification.csv");
  }
};

TEST_F(StudyCommandTest, WritesTableWordsAndPlotsAndResumesThem) {
  const std::string study = Study("0, 3, 5", 2);
  const ProgramRun first = Run(study, "a", {"--json", "--threads", "2"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const nlohmann::json summary = nlohmann::json::parse(first.out);
  EXPECT_EQ(summary["rows"], 3);
  EXPECT_EQ(summary["tasks_kept"], 0);
  EXPECT_THAT(
      std::string(summary["words"][0]),
      HasSubstr("sigma_u 100 m everywhere is reached with 3 control points (perimeter): sigma_h "));
  for (const std::string name : summary["files"]) {
    EXPECT_FALSE(Content(folder_ / "a" / name).empty()) << name;
  }
  const auto rows = test::RowsOf(Table("a"));
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0][0], "layout");
  EXPECT_EQ(rows[0][12], "nees");
  EXPECT_EQ(rows[3][test::ColumnOf(rows, "control_points")], "5");

  const ProgramRun again = Run(study, "a");
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_THAT(again.err, HasSubstr("3 of 3 tasks of the study are there already"));
  EXPECT_EQ(Run(study, "b", {"--threads", "1"}).exit_code, 0);
  EXPECT_EQ(Table("a"), Table("b"));

  const ProgramRun changed = Run(study, "a", {"--set", "verify.runs=3"});
  EXPECT_EQ(changed.exit_code, 3);
  EXPECT_THAT(changed.err, HasSubstr("belongs to another study"));
  EXPECT_EQ(Run(study, "a", {"--set", "verify.runs=3", "--restart"}).exit_code, 0);
  EXPECT_NE(Table("a"), Table("b"));
  EXPECT_THAT(Run(study, "c", {"--set", "seed=7", "--dump-config"}).out, HasSubstr("seed = 7"));
}

TEST_F(StudyCommandTest, AnInterruptedStudyHoldsWholeRowsAndGoesOnToTheSameBytes) {
  const std::string study = Study("0, 3, 5, 6, 7, 8, 9, 10, 11, 12", 150);
  {
    Program program(folder_, {"study", "densification", study, "-o", folder_ / "cut"});
    const auto stop = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (program.Running() && std::chrono::steady_clock::now() < stop) {
      const auto file = folder_ / "cut" / "densification.csv";
      if (std::filesystem::exists(file) && test::RowsOf(Content(file)).size() >= 2) break;
      std::this_thread::yield();
    }
    program.Signal(SIGINT);
    const ProgramRun run = program.Wait();
    EXPECT_EQ(run.exit_code, 1) << run.err;
  }
  const std::string cut = Table("cut");
  EXPECT_EQ(cut.back(), '\n');
  ASSERT_EQ(Run(study, "whole").exit_code, 0);
  EXPECT_EQ(Table("whole").substr(0, cut.size()), cut);
  EXPECT_LT(cut.size(), Table("whole").size());
  const ProgramRun resumed = Run(study, "cut");
  EXPECT_EQ(resumed.exit_code, 0);
  EXPECT_THAT(resumed.err, HasSubstr("of 10 tasks of the study are there already"));
  EXPECT_EQ(Table("cut"), Table("whole"));
}

// Hand arithmetic for costs; the words repeat the table; the fourth corner adds to the other three.
TEST_F(StudyCommandTest, ADesignOfOneAxisIsShownAsATableAndACurve) {
  const std::string study =
      Put("design.toml",
          "format = \"sarblock-study 1\"\nstudy = \"design\"\nscene = \"" +
              std::string(SARBLOCK_DATASETS) +
              "/scenes/cross-wise.toml\"\nset = [\"points.count=60\"]\n"
              "[[axis]]\nkey = \"control.count\"\nvalues = [3, 4]\n"
              "[goal]\nmax_sigma_up_m = 3.5\n[cost]\npass = 7\ncontrol_point = 10\n");
  const ProgramRun run = RunProgram({"study", "design", study, "-o", folder_ / "out"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto rows = test::RowsOf(Content(folder_ / "out" / "design.csv"));
  ASSERT_EQ(rows.size(), 3u);
  const auto cell = [&](std::size_t row, const std::string& column) {
    return rows[row][test::ColumnOf(rows, column)];
  };
  EXPECT_EQ(cell(1, "cost"), "44");  // 2 passes, 3 points
  EXPECT_EQ(cell(2, "cost"), "54");
  std::vector<double> worst_up_m;
  for (const std::size_t row : {1u, 2u}) {
    EXPECT_EQ(cell(row, "pareto"), "1");
    const std::size_t line = run.out.find("\n" + cell(row, "value_1") + " ");
    ASSERT_NE(line, std::string::npos) << run.out;
    std::istringstream words(run.out.substr(line));
    std::string value;
    words >> value;
    for (const std::string part : {"median", "max"}) {
      for (const std::string axis : {"along", "across", "up"}) {
        double shown_m = 0.0;
        words >> shown_m;
        const double sigma_m = std::stod(cell(row, part + "_sigma_" + axis + "_m"));
        EXPECT_NEAR(shown_m, sigma_m, 0.005 * sigma_m) << part << " " << axis;
      }
    }
    words >> value;
    EXPECT_EQ(value, cell(row, "cost"));
    worst_up_m.push_back(std::stod(cell(row, "max_sigma_up_m")));
    EXPECT_EQ(cell(row, "reached"), worst_up_m.back() <= 3.5 ? "1" : "0");
    EXPECT_EQ(run.out[run.out.find('\n', line + 1) - 1], cell(row, "reached") == "1" ? '*' : '4');
  }
  EXPECT_LT(worst_up_m[1], worst_up_m[0]);
  const std::string curve = Content(folder_ / "out" / "design_curve.svg");
  EXPECT_THAT(curve, HasSubstr("Accuracy against control.count"));
  EXPECT_THAT(curve, HasSubstr("Accuracy against cost"));
}

TEST_F(StudyCommandTest, PushesBlocksToTheExtremesAndResumesThem) {
  const std::string study = Put("stability.toml",
                                "format = \"sarblock-study 1\"\nstudy = \"stability\"\n"
                                "[[family]]\nname = \"base\"\nvalues = [1e4, 1e-6]\n"
                                "[[family]]\nname = \"degree\"\nvalues = [1]\n");
  const auto run = [&](const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"study", "stability", study, "-o", folder_ / out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  };
  const ProgramRun first = run("a", {"--json", "--threads", "2"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const nlohmann::json summary = nlohmann::json::parse(first.out);
  EXPECT_EQ(summary["words"][0], "3 steps of 2 families: 2 ok, 0 warned, 1 refused, 0 wrong");
  EXPECT_EQ(
      summary["files"],
      (std::vector<std::string>{
          "stability.csv", "stability_methods.svg", "stability_errors.svg", "stability.txt"}));
  const std::string table = Content(folder_ / "a" / "stability.csv");
  const auto rows = test::RowsOf(table);
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[2][test::ColumnOf(rows, "outcome")], "refused");
  EXPECT_EQ(rows[2][test::ColumnOf(rows, "condition")], "");
  EXPECT_THAT(table, HasSubstr("\",4,,,,,\n"));  // the exit code behind the message, no digits
  EXPECT_THAT(Content(folder_ / "a" / "stability_methods.svg"), HasSubstr("16 - 2 log k"));

  EXPECT_THAT(run("a", {}).err, HasSubstr("3 of 3 tasks of the study are there already"));
  EXPECT_EQ(Content(folder_ / "a" / "stability.csv"), table);
  EXPECT_EQ(run("b", {"--threads", "1"}).exit_code, 0);
  EXPECT_EQ(Content(folder_ / "b" / "stability.csv"), table);
  EXPECT_EQ(run("a", {"--set", "families=[\"squint\"]"}).exit_code, 3);
  EXPECT_EQ(run("c", {"--set", "familie=[]"}).exit_code, 3);
}

}  // namespace
}  // namespace sarblock
