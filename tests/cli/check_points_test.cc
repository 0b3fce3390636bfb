// SPDX-License-Identifier: Apache-2.0
// The verdict of check points, as the program prints it.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class CheckPointsTest : public test::CliTest {
 protected:
  json Summary(const std::string& result) const {
    return json::parse(Content(folder_ / result / "summary.json"));
  }
};

// Two routes: `montecarlo` states the same covariances as `block` and adds runs that test them, so
// the check points are worth as many independent components.
TEST_F(CheckPointsTest, AreWorthAsManyComponentsUnderMonteCarloAsUnderBlock) {
  const Path block = Simulated("leberl-aircraft", "block", {"--set", "points.count=40"});
  ASSERT_EQ(Run("adjust", block, "block-level", {"--set", "covariance=block"}).exit_code, 0);
  ASSERT_EQ(Run("adjust",
                block,
                "runs",
                {"--set", "covariance=montecarlo", "--set", "montecarlo_runs=10"})
                .exit_code,
            0);
  const json one = Summary("block-level")["check_points"], other = Summary("runs")["check_points"];
  EXPECT_NEAR(other["freedom"].get<double>(), one["freedom"].get<double>(), 1e-6);
  EXPECT_LT(one["freedom"].get<double>(), 0.5 * one["components"].get<double>());
  EXPECT_EQ(other["realistic"], one["realistic"]);
}

// The id of two points exchanged in one pass: the search leaves out what it cannot attribute, and
// those points keep a position without a covariance.
TEST_F(CheckPointsTest, WithoutAStandardDeviationTheyAreInNoFigure) {
  const Path block = Simulated("block-12-strips", "block", {"--set", "points.count=300"});
  auto points = test::RowsOf(Content(block / "points.csv"));
  const std::size_t role = test::ColumnOf(points, "role");
  std::vector<std::string> checks;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i][role] == "check") checks.push_back(points[i][0]);
  }
  std::string looks = Content(block / "observations.csv");
  bool found = false;
  // Exchanges of check points with their neighbours in the file until one is left out so.
  for (std::size_t i = 0; i + 1 < checks.size() && !found; ++i) {
    std::string exchanged = looks;
    const std::string a = "S1," + checks[i] + ",", b = "S1," + checks[i + 1] + ",";
    const std::size_t at_a = exchanged.find("\n" + a), at_b = exchanged.find("\n" + b);
    if (at_a == std::string::npos || at_b == std::string::npos) continue;
    exchanged.replace(at_b + 1, b.size(), a);
    exchanged.replace(at_a + 1, a.size(), b);
    Put("block/observations.csv", exchanged);
    const test::ProgramRun run =
        Run("adjust", block, "result", {"--set", "quality.snooping=robust"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const json summary = Summary("result")["check_points"];
    if (summary["points_without_sigma"] == 0) continue;
    found = true;
    double square_m2 = 0.0, count = 0.0;
    const auto rows = test::RowsOf(Content(folder_ / "result/points.csv"));
    for (const auto& row : rows) {
      if (row[test::ColumnOf(rows, "role")] != "check") continue;
      if (row[test::ColumnOf(rows, "sigma_u_m")].empty()) continue;
      const double error_m = std::stod(row[test::ColumnOf(rows, "error_u_m")]);
      square_m2 += error_m * error_m;
      count += 1.0;
    }
    EXPECT_EQ(summary["points"], count);
    EXPECT_NEAR(summary["rms_u_m"].get<double>(), std::sqrt(square_m2 / count), 1e-9);
    EXPECT_THAT(run.out, HasSubstr("have no standard deviation and are not compared"));
  }
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace sarblock
