// SPDX-License-Identifier: Apache-2.0
// Defective blocks through the program: `check` warns, `adjust` refuses with exit code 4 in the
// same words and writes nothing.
#include <string>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using testing::HasSubstr;

class UndeterminedCommandTest : public test::CliTest,
                                public testing::WithParamInterface<const char*> {};

TEST_P(UndeterminedCommandTest, IsWarnedOfByCheckAndRefusedByAdjust) {
  const std::string scene = GetParam();
  const Path block = Simulated("defective/" + scene, scene);
  const test::ProgramRun check = test::RunProgram({"check", block, "--json"});
  EXPECT_EQ(check.exit_code, 0);
  const auto warnings = nlohmann::json::parse(check.out)["warnings"];
  ASSERT_FALSE(warnings.empty());
  const test::ProgramRun adjust = Run("adjust", block, "result");
  EXPECT_EQ(adjust.exit_code, 4);
  EXPECT_TRUE(FilesOf(folder_ / "result").empty());
  // Words about the structure are the same; those about points share the reason.
  for (const std::string warning : warnings) {
    const std::size_t reason = warning.find(": ");
    EXPECT_THAT(
        adjust.err,
        HasSubstr(warning.substr(warning.find("left out") == std::string::npos ? 0 : reason + 2)));
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         UndeterminedCommandTest,
                         testing::Values("no-control",
                                         "one-point",
                                         "collinear-control",
                                         "single-flight-free",
                                         "zero-base",
                                         "time-and-along",
                                         "narrow-swath",
                                         "two-islands",
                                         "pass-of-one-point",
                                         "mirror-ambiguity"),
                         [](const auto& scene) {
                           std::string name = scene.param;
                           for (char& c : name) c = c == '-' ? '_' : c;
                           return name;
                         });

}  // namespace
}  // namespace sarblock
