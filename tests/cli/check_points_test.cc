// SPDX-License-Identifier: Apache-2.0
// The verdict of check points, as the program prints it.
#include <string>

#include "cli/cli_fixture.h"
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using nlohmann::json;

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
                {"--set", "covariance=montecarlo", "--set", "montecarlo_runs=30"})
                .exit_code,
            0);
  const json one = Summary("block-level")["check_points"], other = Summary("runs")["check_points"];
  EXPECT_NEAR(other["freedom"].get<double>(), one["freedom"].get<double>(), 1e-6);
  EXPECT_LT(one["freedom"].get<double>(), 0.5 * one["components"].get<double>());
  EXPECT_EQ(other["realistic"], one["realistic"]);
}

}  // namespace
}  // namespace sarblock
