// SPDX-License-Identifier: Apache-2.0
// `check` keeps to the width of a terminal where passes have long names and times are large.
#include <sstream>
#include <string>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>

namespace sarblock {
namespace {

class CheckWidthTest : public test::CliTest {
 protected:
  static std::string Checked(const Path& block) {
    const test::ProgramRun run = test::RunProgram({"check", block});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    std::istringstream lines(run.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
    return run.out;
  }
};

TEST_F(CheckWidthTest, ALongNameOfAPassIsAboveItsRowInBothTables) {
  const Path block = Simulated(
      "recorded/uav",
      "block",
      {"--set", "points.count=20", "--set", "flight.1.id=southern-flight-of-the-second-campaign"});
  const std::string text = Checked(block);
  EXPECT_THAT(text,
              testing::HasSubstr("\n  southern-flight-of-the-second-campaign\n      right  "));
  EXPECT_THAT(text,
              testing::HasSubstr("\n  southern-flight-of-the-second-campaign\n      smooth  "));
}

TEST_F(CheckWidthTest, SecondsSinceTheEpochOfGpsFit) {
  const Path block = Simulated("leberl-aircraft", "block");
  for (const char* table : {"trajectories.csv", "observations.csv"}) {
    auto rows = test::RowsOf(Content(block / table));
    const std::size_t time = test::ColumnOf(rows, "time_s");
    std::string text;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (i > 0) rows[i][time] = std::to_string(1.4e9 + std::stod(rows[i][time]));
      for (std::size_t k = 0; k < rows[i].size(); ++k) text += (k > 0 ? "," : "") + rows[i][k];
      text += "\n";
    }
    Put(std::string("block/") + table, text);
  }
  for (int pass = 0; pass < 2; ++pass) {
    Edit(block / "block.toml", "\nstart_s = 0\n", "\nstart_s = 1.4e9\n");
    Edit(block / "block.toml", "end_s = 111.11111111111111", "end_s = 1400000111.1111");
  }
  EXPECT_THAT(Checked(block), testing::HasSubstr("1400000000.000000"));
}

}  // namespace
}  // namespace sarblock
