// SPDX-License-Identifier: Apache-2.0
// What `simulate` says of points and looks that are left out.
#include <sstream>
#include <string>
#include <vector>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

class SimulateProgramTest : public test::CliTest {
 protected:
  /// The pair of the paper over strong relief, its tie points in a grid.
  test::ProgramRun Rugged(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {
        "simulate",
        std::string(SARBLOCK_DATASETS) + "/scenes/leberl-aircraft.toml",
        "-o",
        folder_ / "rugged",
        "--force",
        "--set",
        "terrain.kind=rugged",
        "--set",
        "terrain.relief_m=600",
        "--set",
        "terrain.correlation_m=3000"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    test::ProgramRun run = test::RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run;
  }
};

// Invariants of the counts, and the words of the same numbers.
TEST_F(SimulateProgramTest, SaysWhatTheTerrainHides) {
  const std::vector<std::string> hides = {"--set", "terrain.visibility=terrain"};
  const std::string text = Rugged(hides).out;
  std::vector<std::string> with_json = hides;
  with_json.emplace_back("--json");
  const json all = json::parse(Rugged(with_json).out);
  const json& coverage = all["coverage"];
  const json &tie = coverage["tie"], &lost = coverage["lost"];
  EXPECT_EQ(all["points"].get<int>(),
            tie["placed"].get<int>() - tie["left_out"].get<int>() +
                coverage["control"]["placed"].get<int>() + coverage["check"]["placed"].get<int>() -
                coverage["check"]["left_out"].get<int>());
  int placed = 0, shown = 0, shadow = 0, layover = 0;
  for (const json& points : coverage["points_by_looks"]) placed += points.get<int>();
  for (const json& pass : coverage["passes"]) {
    int sum = pass["shown"].get<int>();
    shown += sum;
    for (const json& by_cause : pass["lost"]) sum += by_cause.get<int>();
    EXPECT_EQ(sum, placed) << pass["id"];
    shadow += pass["lost"]["shadow"].get<int>();
    layover += pass["lost"]["layover"].get<int>();
  }
  EXPECT_EQ(lost["shadow"], shadow);
  EXPECT_EQ(lost["layover"], layover);
  EXPECT_GT(shadow, 0);
  EXPECT_GT(layover, 0);
  EXPECT_EQ(
      coverage["points_by_looks"][1].get<int>() + 2 * coverage["points_by_looks"][2].get<int>(),
      shown);
  const json& of_left_out = coverage["lost_of_left_out"];
  EXPECT_THAT(text,
              HasSubstr(std::to_string(tie["left_out"].get<int>()) + " of " +
                        std::to_string(tie["placed"].get<int>()) + " tie points"));
  EXPECT_THAT(text, HasSubstr(std::to_string(of_left_out["shadow"].get<int>()) + " in shadow"));
  EXPECT_THAT(text, HasSubstr("looks per point: "));
  EXPECT_THAT(text, HasSubstr("in layover   lost %\n"));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
}

TEST_F(SimulateProgramTest, SaysNothingMoreWhereNothingIsLost) {
  const auto run = test::RunProgram({"simulate",
                                     std::string(SARBLOCK_DATASETS) + "/scenes/cross-wise.toml",
                                     "-o",
                                     folder_ / "all"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, Not(HasSubstr("left out")));
  EXPECT_THAT(run.out, Not(HasSubstr("looks per point")));
  // Without the key the terrain hides nothing.
  EXPECT_THAT(Rugged({}).out, Not(HasSubstr("in shadow")));
}

TEST_F(SimulateProgramTest, PredictPrintsTheLooksPerPointOfAPlan) {
  const Path block = Simulated("leberl-aircraft", "plan", {"--set", "points.count=40"});
  std::filesystem::remove(block / "observations.csv");
  Put("plan/observations.csv", "pass,point\n");
  const json check = json::parse(test::RunProgram({"check", block, "--json"}).out);
  const json& by_looks = check["coverage"]["points_by_looks"];
  ASSERT_EQ(by_looks.size(), 3U);  // both passes see every point
  EXPECT_EQ(by_looks[2], check["points"]);
  const std::string line =
      "looks per point: " + std::to_string(by_looks[2].get<int>()) + " with 2\n";
  EXPECT_THAT(test::RunProgram({"check", block}).out, HasSubstr(line));
  EXPECT_THAT(Run("predict", block, "result").out, HasSubstr(line));
}

}  // namespace
}  // namespace sarblock
