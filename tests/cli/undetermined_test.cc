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
using testing::MatchesRegex;
using testing::Not;
using testing::StartsWith;

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
  // Residuals say nothing of what is missing.
  EXPECT_THAT(adjust.err, Not(HasSubstr("most likely")));
  EXPECT_THAT(adjust.err, MatchesRegex("sarblock: [^\n]*\n"));
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

class RefusalTest : public test::CliTest {};

TEST_F(RefusalTest, IsNotExplainedByNoiseWhereADatumIsMissing) {
  const Path block = Simulated("defective/no-control", "noisy", {"--set", "looks.noise_scale=4"});
  const test::ProgramRun adjust = Run("adjust", block, "result");
  EXPECT_EQ(adjust.exit_code, 4);
  EXPECT_THAT(adjust.err, StartsWith("sarblock: the block does not determine its corrections"));
  EXPECT_THAT(adjust.err, Not(HasSubstr("most likely")));
}

TEST_F(RefusalTest, ComesBeforeTheMistakeThatExplainsIt) {
  const Path block = Simulated("cross-wise", "side");
  Edit(block / "block.toml", "look = \"left\"", "look = \"right\"");
  const test::ProgramRun adjust = Run("adjust", block, "result");
  EXPECT_EQ(adjust.exit_code, 4);
  EXPECT_THAT(adjust.err, StartsWith("sarblock: no tie or check point of the block can be"));
  EXPECT_THAT(adjust.err,
              HasSubstr("\nsarblock: most likely: pass E looks to the other side of the flight"));
}

}  // namespace
}  // namespace sarblock
