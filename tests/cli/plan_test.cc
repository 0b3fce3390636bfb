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
  EXPECT_EQ(check["looks"], 2 * (40 + 4 + 40));  // two passes; tie, control and check points
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
  EXPECT_EQ(count, 2 * (40 + 4 + 40));
  const auto report = test::RunProgram({"report", folder_ / "result"});
  EXPECT_EQ(report.exit_code, 0) << report.err;
}

TEST_F(PlanTest, PredictionSaysWhatNothingChecksAndHowDifferencesAreKnown) {
  const Path block = Simulated("block-12-strips", "strips", {"--set", "points.count=150"});
  const auto run = Run("predict", block, "strips-result", {"--set", "pairs=distances"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("checked by others"));
  EXPECT_THAT(run.out, HasSubstr("across the track"));
  const json summary = json::parse(Content(folder_ / "strips-result/summary.json"));
  const json checked = summary["quality"]["checked"];
  EXPECT_EQ(checked["control"]["observations"], 3 * 12);
  EXPECT_GT(checked["range"]["hardly_checked"].get<int>(), 10);  // of points with two looks
  EXPECT_TRUE(checked["range"]["weakest"]["mdb_m"].is_null());
  EXPECT_GT(checked["azimuth"]["weakest"]["influence_m"].get<double>(), 0.5);
  ASSERT_GE(summary["differences"].size(), 4U);
  for (const json& of : summary["differences"]) EXPECT_GT(of["sigma_up_m"].get<double>(), 0.1);
  EXPECT_EQ(test::RunProgram({"report", folder_ / "strips-result"}).exit_code, 0);
  EXPECT_THAT(Content(folder_ / "strips-result/report.html"), HasSubstr("differences-2"));
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

std::vector<std::string> Pair(const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"plan", "pair"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

// Hand arithmetic: sin i = (6378.137 + 700)/6378.137 sin(look) gives 33.70 and 45.51 degrees; 3 m
// of range then give 3 m sqrt(sin^2 + sin^2)/sin(11.80) = 13.25 m up, 3 m sqrt(cos^2 + cos^2)/sin =
// 15.95 m across.
TEST(PlanPairTest, AnswersAPairFromOrbit) {
  const std::vector<std::string> orbit = {"--look",
                                          "30",
                                          "--look",
                                          "40",
                                          "--orbit-height-km",
                                          "700",
                                          "--body",
                                          "Earth",
                                          "--range-sigma-m",
                                          "3"};
  auto arguments = Pair(orbit);
  arguments.insert(arguments.end(), {"--json", "--goal-up-m", "10"});
  const auto run = test::RunProgram(arguments);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json pair = json::parse(run.out);
  EXPECT_NEAR(pair["incidence_deg"][0].get<double>(), 33.702, 0.01);
  EXPECT_NEAR(pair["incidence_deg"][1].get<double>(), 45.507, 0.01);
  EXPECT_NEAR(pair["intersection_deg"].get<double>(), 11.805, 0.01);
  EXPECT_NEAR(pair["sigma"]["up_m"].get<double>(), 13.253, 0.01);
  EXPECT_NEAR(pair["sigma"]["across_m"].get<double>(), 15.952, 0.01);
  EXPECT_TRUE(pair["sigma"]["along_m"].is_null());  // no standard deviation of azimuth is given
  EXPECT_FALSE(pair["goal_reached"].get<bool>());
  EXPECT_LT(pair["second_look_below_deg"].get<double>(), 30.0);
  EXPECT_GT(pair["second_look_above_deg"].get<double>(), 40.0);
  EXPECT_NEAR(pair["slope_facing_first_deg"].get<double>(), 33.702, 0.01);
  EXPECT_NEAR(pair["slope_facing_away_deg"].get<double>(), 90.0 - 45.507, 0.01);

  arguments = Pair(orbit);
  arguments.insert(arguments.end(),
                   {"--azimuth-sigma-m", "2", "--path-sigma-m", "5", "--goal-up-m", "20.2"});
  const auto text = test::RunProgram(arguments);
  ASSERT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("by the flight paths"));
  EXPECT_THAT(text.out, HasSubstr("goal 20.2 m: missed; reached by a second look of"));
  std::istringstream lines(text.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
}

// Hand arithmetic: reflectors of 30 dB are read to 0.39 of a resolution over the root of 1000.
TEST(PlanPairTest, TakesImagesInPlaceOfStandardDeviations) {
  std::vector<std::string> image{"--look",
                                 "30",
                                 "--look",
                                 "40",
                                 "--height-m",
                                 "5000",
                                 "--bandwidth-mhz",
                                 "149.896229",
                                 "--azimuth-resolution-m",
                                 "3",
                                 "--snr-db",
                                 "30"};
  const auto run = test::RunProgram(Pair(image));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("0.0123 and 0.0123 m, azimuths 0.037 and 0.037 m"));
  EXPECT_THAT(run.out,
              testing::Not(HasSubstr("best second look")));  // reflectors: the wider the better
  std::vector<std::string> ground = image;
  ground.insert(ground.end(), {"--window-m", "30", "--slope-rms", "0.1", "--goal-up-m", "0.001"});
  const auto matched = test::RunProgram(Pair(ground));
  EXPECT_THAT(matched.out, HasSubstr("best second look"));
  EXPECT_THAT(matched.out, HasSubstr("missed; no second look reaches it"));
}

}  // namespace
}  // namespace sarblock
