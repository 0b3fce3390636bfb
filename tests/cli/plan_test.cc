// SPDX-License-Identifier: Apache-2.0
// Plans: blocks without measured values, as `check` and `predict` take them.
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "cli/cli_fixture.h"
#include "support/csv_rows.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class PlanTest : public test::CliTest {
 protected:
  /// A block of 40 points, all seen by both passes, with this table of looks in place of its own.
  Path Planned(const std::string& name, const std::string& observations) {
    Path block = Simulated("leberl-aircraft", name, {"--set", "points.count=40"});
    std::filesystem::remove(block / "observations.csv");
    Put(name + "/observations.csv", observations);
    return block;
  }
  json Checked(const Path& block) {
    const auto run = test::RunProgram({"check", block, "--json"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(run.out);
  }
};

TEST_F(PlanTest, CheckCountsTheLooksThatPredictTakes) {
  const Path block = Planned("header", "pass,point\n");
  const json check = Checked(block);
  EXPECT_TRUE(check["plan"].get<bool>());
  ASSERT_EQ(Run("predict", block, "result", {}).exit_code, 0);
  const json summary = json::parse(Content(folder_ / "result/summary.json"));
  EXPECT_EQ(check["looks"], summary["counts"]["looks_used"]);
  EXPECT_GE(check["looks"].get<int>(), 2 * 80);  // two passes; tie, control and check points
  EXPECT_TRUE(check["warnings"].empty()) << check["warnings"];
  EXPECT_THAT(test::RunProgram({"check", block}).out, HasSubstr("a plan: no look is measured"));
  // with the columns, and with rows that have no values
  EXPECT_EQ(Checked(Planned("columns", "pass,point,time_s,range_m\n"))["looks"], check["looks"]);
  const json rows = Checked(Planned("rows", "pass,point\nA1,C1\nA2,C1\nA1,T1\nA2,T1\n"));
  EXPECT_TRUE(rows["plan"].get<bool>());
  EXPECT_EQ(rows["looks"], 4);
}

TEST_F(PlanTest, CheckNamesTheFaultOfABlockThatIsMeasuredInPart) {
  const Path block = Planned("part", "pass,point,time_s,range_m\nA1,C1,11.5,20000\nA2,C1,,\n");
  const auto run = test::RunProgram({"check", block});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("observations.csv:3: time_s"));
  EXPECT_FALSE(Checked(Simulated("leberl-aircraft", "measured"))["plan"].get<bool>());
}

// A prediction is of geometry and weights, whether or not the block has been measured.
TEST_F(PlanTest, PredictionOfAMeasuredBlockHasNoTests) {
  const Path block = Simulated("leberl-aircraft", "measured", {"--set", "points.count=40"});
  ASSERT_EQ(Run("predict", block, "result", {}).exit_code, 0);
  const json quality = json::parse(Content(folder_ / "result/summary.json"))["quality"];
  EXPECT_FALSE(quality.contains("above_critical"));
  EXPECT_GT(quality["tests"].get<int>(), 80);
  for (const json& pass : quality["passes"]) {
    EXPECT_TRUE(pass["square_sum"].is_null());
    EXPECT_GT(pass["redundancy"].get<double>(), 0.0);
  }
  test::CsvRows rows(
      folder_ / "result/residuals.csv",
      std::vector<TableColumn>{
          {"range_w"}, {"azimuth_w"}, {"azimuth_tau"}, {"azimuth_redundancy"}, {"azimuth_mdb_m"}});
  int count = 0;
  while (rows.Next()) {
    ++count;
    for (const std::size_t column : {0u, 1u, 2u}) EXPECT_FALSE(rows.Given(column));
    EXPECT_GT(rows.Number(3), 0.1);
    EXPECT_GT(rows.Number(4), 1.0);
  }
  EXPECT_GT(count, 80);
  const auto report = test::RunProgram({"report", folder_ / "result"});
  EXPECT_EQ(report.exit_code, 0) << report.err;
}

TEST_F(PlanTest, PassesWithoutASwathAreSaidToSeeTheirWholeSide) {
  const Path block = Planned("open", "pass,point\n");
  const json with = Checked(block)["coverage"];
  // two strips that both see every point at (look angle of Table 1) 27 to 68 degrees
  EXPECT_EQ(with["fewest_looks"], 2);
  EXPECT_EQ(with["most_looks"], 2);
  EXPECT_GT(with["least_look_deg"].get<double>(), 25.0);
  std::string toml = Content(block / "block.toml");
  for (std::size_t at; (at = toml.find("swath_ground_m")) != std::string::npos;) {
    toml.erase(at, toml.find('\n', at) + 1 - at);
  }
  Put("open/block.toml", toml);
  const auto run = test::RunProgram({"check", block});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("2 looks per point (2 to 2) at look angles of "));
  EXPECT_THAT(run.out, HasSubstr("not every pass has a swath"));
  const auto predicted = Run("predict", block, "open-result", {"--json"});
  EXPECT_THAT(predicted.out, HasSubstr("not every pass has a swath"));
  toml.replace(toml.find("look = "), 0, "swath_look_deg = [40, 20]\n");
  Put("open/block.toml", toml);
  const auto bad = test::RunProgram({"check", block});
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_THAT(bad.err,
              HasSubstr("pass[0].swath_look_deg: must be near and far, 0 <= near < far < "
                        "90, got 40 and 20"));
}

}  // namespace
}  // namespace sarblock
