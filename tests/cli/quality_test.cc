// SPDX-License-Identifier: Apache-2.0
// Search for blunders and re-run from its rejections, as a user does it.
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::vector<std::string> Lines(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

class QualityCommandTest : public test::CliTest {};

// Round trip: what a search left out, left out from the start, gives the same adjustment.
TEST_F(QualityCommandTest, ARunStartsFromTheRejectionsOfAnother) {
  const Path block = Simulated("different-altitudes",
                               "block",
                               {"--set",
                                "points.count=60",
                                "--set",
                                "looks.blunder_fraction=0.05",
                                "--set",
                                "looks.blunder_size=60",
                                "--set",
                                "looks.blunder_kind=azimuth"});
  const test::ProgramRun run =
      Run("adjust", block, "found", {"--set", "quality.snooping=iterative"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("search for blunders:"));
  const json found = json::parse(Content(folder_ / "found/summary.json"));
  ASSERT_FALSE(found["snooping"]["findings"].empty());
  EXPECT_EQ(
      Run("adjust", block, "again", {"--rejections", folder_ / "found/residuals.csv"}).exit_code,
      0);
  const json again = json::parse(Content(folder_ / "again/summary.json"));
  EXPECT_EQ(again["counts"]["looks_used"], found["counts"]["looks_used"]);
  EXPECT_LT(again["counts"]["looks_used"], again["counts"]["looks"]);
  EXPECT_EQ(again["counts"]["redundancy"], found["counts"]["redundancy"]);
  EXPECT_NEAR(again["sigma0_squared"].get<double>(), found["sigma0_squared"].get<double>(), 1e-6);
  EXPECT_THAT(Content(folder_ / "again/residuals.csv"), HasSubstr(",1,given,"));
  // Without either the blunders are in the variance factor, and nothing is accepted above 10.
  EXPECT_EQ(Run("adjust", block, "plain", {"--set", "quality.consensus=false"}).exit_code, 1);
  const json plain = json::parse(Content(folder_ / "plain/summary.json"));
  EXPECT_GT(plain["sigma0_squared"].get<double>(), 10.0);
  EXPECT_EQ(plain["accepted"], false);
}

// The same image twice under two names adds no information.
TEST_F(QualityCommandTest, TheLooksOfACopiedPassCountOnce) {
  const Path block = Simulated("leberl-aircraft", "block", {"--set", "points.count=60"});
  ASSERT_EQ(Run("adjust", block, "once").exit_code, 0);
  const std::string text = Content(block / "block.toml");
  std::string pass = text.substr(text.find("[[pass]]"));
  pass = pass.substr(0, pass.find("[[pass]]", 1));
  pass.replace(pass.find("\"A1\""), 4, "\"COPY\"");
  Put("block/block.toml", text + "\n" + pass);
  for (const char* table : {"block/trajectories.csv", "block/observations.csv"}) {
    std::istringstream lines(Content(folder_ / table));
    std::string copied = lines.str();
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("A1,")) copied += "COPY" + line.substr(2) + "\n";
    }
    Put(table, copied);
  }
  const test::ProgramRun run = Run("adjust", block, "twice");
  EXPECT_EQ(run.exit_code, 0);
  // 60 tie, 4 control and 40 check points.
  EXPECT_THAT(run.err, HasSubstr("pass COPY: 104 of its 104 looks equal those of pass A1"));
  const json once = json::parse(Content(folder_ / "once/summary.json"));
  const json twice = json::parse(Content(folder_ / "twice/summary.json"));
  EXPECT_EQ(once["counts"]["redundancy"], twice["counts"]["redundancy"]);
  EXPECT_EQ(once["counts"]["looks_used"], twice["counts"]["looks_used"]);
  const auto a = test::RowsOf(Content(folder_ / "once/points.csv"));
  const auto b = test::RowsOf(Content(folder_ / "twice/points.csv"));
  ASSERT_EQ(a.size(), b.size());
  for (const char* name : {"x_m", "y_m", "z_m", "sigma_e_m", "sigma_n_m", "sigma_u_m"}) {
    const std::size_t column = test::ColumnOf(a, name);
    for (std::size_t row = 1; row < a.size(); ++row) {
      EXPECT_NEAR(std::stod(a[row][column]), std::stod(b[row][column]), 1e-6) << name;
    }
  }
}

// The trajectories of two passes exchanged: the looks follow, the priors do not.
TEST_F(QualityCommandTest, ExchangedTrajectoriesAreSaidOfThePriors) {
  const Path block = Simulated("leberl-aircraft", "block");
  std::string exchanged;
  for (const std::string& line : Lines(Content(block / "trajectories.csv"))) {
    const bool first = line.starts_with("A1,"), second = line.starts_with("A2,");
    exchanged += (first ? "A2," : second ? "A1," : line.substr(0, 3)) + line.substr(3) + "\n";
  }
  Put("block/trajectories.csv", exchanged);
  const test::ProgramRun run = Run("adjust", block, "result");
  EXPECT_THAT(run.out, HasSubstr("priors: the observations contradict those of "));
  EXPECT_THAT(run.out, HasSubstr("  tests of "));
  const json quality = json::parse(Content(folder_ / "result/summary.json"))["quality"];
  EXPECT_GT(quality["priors"]["above_critical"].get<int>(), 0);
  EXPECT_GT(std::abs(quality["priors"]["worst"]["w"].get<double>()), 10.0);
  EXPECT_EQ(quality["passes"].size(), 2U);
  const auto rows = test::RowsOf(Content(folder_ / "result/passes.csv"));
  for (std::size_t i = 1; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i][test::ColumnOf(rows, "prior_w")].empty(),
              rows[i][test::ColumnOf(rows, "prior_sigma")].empty());
  }
}

TEST_F(QualityCommandTest, LevelsThatMakeNoTestAreRefused) {
  const Path block = Simulated("opposite-side", "block", {"--set", "points.count=12"});
  const test::ProgramRun run = Run("adjust", block, "result", {"--set", "quality.alpha=0.9"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("adjust.quality.alpha: must be below 0.8, got 0.9"));
  EXPECT_EQ(Run("adjust", block, "result", {"--rejections", folder_ / "nowhere.csv"}).exit_code, 3);
}

}  // namespace
}  // namespace sarblock
