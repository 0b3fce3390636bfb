// SPDX-License-Identifier: Apache-2.0
// `check` predicts what an adjustment needs; `adjust` refuses what does not fit, before it writes.
#include <string>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using testing::HasSubstr;
using testing::Not;
using MemoryCommandTest = test::CliTest;

TEST_F(MemoryCommandTest, CheckPredictsAndAdjustRefusesBeforeItWrites) {
  const Path block = Simulated("leberl-aircraft", "block");
  const test::ProgramRun check = test::RunProgram({"check", block, "--json"});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  const auto needs = nlohmann::json::parse(check.out)["needs"];
  const double mib = needs["memory_bytes"].get<double>() / (1 << 20);
  EXPECT_GT(mib, 0.0);
  EXPECT_GT(needs["factor_operations"].get<double>(), 0.0);
  EXPECT_LE(needs["looks_bytes"].get<double>(), needs["memory_bytes"].get<double>());
  EXPECT_THAT(test::RunProgram({"check", block}).out, HasSubstr("\n  memory "));

  const std::string less = std::to_string(0.5 * mib);
  const test::ProgramRun refused = Run("adjust", block, "result", {"--memory", less});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, HasSubstr("block: the adjustment needs "));
  EXPECT_THAT(refused.err, HasSubstr("--memory sets another limit"));
  EXPECT_TRUE(FilesOf(folder_ / "result").empty());
  const test::ProgramRun warned = test::RunProgram({"check", block, "--memory", less});
  EXPECT_EQ(warned.exit_code, 0);
  EXPECT_THAT(warned.out, HasSubstr("warning: the adjustment needs "));
  EXPECT_EQ(Run("adjust", block, "result", {"--memory", std::to_string(2.0 * mib)}).exit_code, 0);
}

TEST_F(MemoryCommandTest, RefusesALimitThatIsNone) {
  const Path block = Simulated("leberl-aircraft", "block");
  for (const char* limit : {"0", "-3", "much"}) {
    EXPECT_EQ(Run("adjust", block, "result", {"--memory", limit}).exit_code, 2) << limit;
  }
}

}  // namespace
}  // namespace sarblock
