// SPDX-License-Identifier: Apache-2.0
// One verdict: terminal, summary.json, report and exit code say the same of a result.
#include <string>
#include <vector>

#include "cli/cli_fixture.h"
#include "cli/terminal.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

class VerdictTest : public test::CliTest {
 protected:
  /// Adjusts a block and expects the verdict in its four places; its reasons.
  std::vector<std::string> ExpectVerdict(const Path& block,
                                         const std::string& word,
                                         const std::string& headline,
                                         int exit_code,
                                         int strict_exit_code) const {
    const test::ProgramRun run = Run("adjust", block, "result", {"--report"});
    EXPECT_EQ(run.exit_code, exit_code) << run.out << run.err;
    EXPECT_THAT(run.out, HasSubstr(": " + word + "\n"));
    const json summary = json::parse(Content(folder_ / "result/summary.json"));
    EXPECT_EQ(summary["verdict"], word);
    EXPECT_EQ(summary["accepted"], word != "not accepted");
    EXPECT_THAT(Content(folder_ / "result/report.html"), HasSubstr("<h2>" + headline));
    std::vector<std::string> reasons = summary["verdict_reasons"];
    for (const std::string& reason : reasons)
      EXPECT_THAT(run.out, HasSubstr(cli::FitColumns("  - " + reason)));
    const test::ProgramRun strict = Run("adjust", block, "strict", {"--strict"});
    EXPECT_EQ(strict.exit_code, strict_exit_code);
    const json same = json::parse(Content(folder_ / "strict/summary.json"));
    EXPECT_EQ(same["verdict"], word);
    return reasons;
  }

  /// Writes a table anew with the cells of some rows changed.
  template <typename Change>
  void ChangeRows(const Path& file, const Change& change) const {
    auto rows = test::RowsOf(Content(file));
    std::string text;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (i > 0) change(rows[0], &rows[i]);
      for (std::size_t k = 0; k < rows[i].size(); ++k) text += (k > 0 ? "," : "") + rows[i][k];
      text += "\n";
    }
    std::ofstream(file, std::ios::binary) << text;
  }

  static std::size_t Column(const std::vector<std::string>& header, const std::string& name) {
    return test::ColumnOf({header}, name);
  }
};

TEST_F(VerdictTest, AGoodBlockIsAccepted) {
  const Path block = Simulated("leberl-aircraft", "block");
  EXPECT_THAT(ExpectVerdict(block, "accepted", "Accepted", 0, 0), IsEmpty());
}

TEST_F(VerdictTest, AControlPointWithItsCoordinatesExchangedIsNotAccepted) {
  const Path block = Simulated("leberl-aircraft", "block");
  bool first = true;
  ChangeRows(block / "points.csv", [&](const auto& header, auto* row) {
    if (!first || (*row)[Column(header, "role")] != "control") return;
    std::swap((*row)[Column(header, "x_m")], (*row)[Column(header, "y_m")]);
    first = false;
  });
  const std::vector<std::string> reasons =
      ExpectVerdict(block, "not accepted", "Not accepted", 1, 1);
  EXPECT_THAT(reasons, Contains(HasSubstr(", above 10: ")));
}

// Standard deviations stated at half of what the looks have: s0^2 near 4.
TEST_F(VerdictTest, NoiseOfTwiceTheStatedSizeFailsTheGlobalTest) {
  const Path block = Simulated("leberl-aircraft", "block");
  Edit(block / "block.toml", "range_m = 1\nazimuth_m = 1\n", "range_m = 0.5\nazimuth_m = 0.5\n");
  const std::vector<std::string> reasons =
      ExpectVerdict(block, "converged, tests failed", "Converged, tests failed", 0, 1);
  ASSERT_GE(reasons.size(), 2U);
  EXPECT_THAT(reasons[0], StartsWith("most likely: the standard deviations of the "));
  EXPECT_THAT(reasons, Contains(StartsWith("global test: s0^2 is ")));
}

TEST_F(VerdictTest, CheckPointsOfAnotherPlaceFailTheirTestAlone) {
  const Path block = Simulated("leberl-aircraft", "block");
  ChangeRows(block / "points.csv", [](const auto& header, auto* row) {
    if ((*row)[Column(header, "role")] != "check") return;
    std::string& x = (*row)[Column(header, "x_m")];
    x = std::to_string(std::stod(x) + 300.0);
  });
  const std::vector<std::string> reasons =
      ExpectVerdict(block, "converged, tests failed", "Converged, tests failed", 0, 1);
  EXPECT_THAT(reasons, Contains(StartsWith("check points: errors are ")));
  EXPECT_THAT(reasons, Not(Contains(StartsWith("global test: "))));
}

// One range 8 sigma too long moves s0^2 of hundreds of observations little; the largest test names
// it.
TEST_F(VerdictTest, OneBlunderFailsTheTestsOfObservationsAndIsNamed) {
  const Path block = Simulated("leberl-aircraft", "block");
  std::string pass, point;
  ChangeRows(block / "observations.csv", [&](const auto& header, auto* row) {
    if (!pass.empty()) return;
    pass = (*row)[Column(header, "pass")];
    point = (*row)[Column(header, "point")];
    std::string& range = (*row)[Column(header, "range_m")];
    range = std::to_string(std::stod(range) + 8.0);
  });
  const std::vector<std::string> reasons =
      ExpectVerdict(block, "converged, tests failed", "Converged, tests failed", 0, 1);
  EXPECT_THAT(reasons,
              Contains(AllOf(StartsWith("tests of observations: "),
                             HasSubstr("range of " + pass + " at point " + point))));
}

TEST_F(VerdictTest, APredictionHasNothingToFail) {
  const Path block = Simulated("leberl-aircraft", "block");
  EXPECT_EQ(Run("predict", block, "plan", {"--strict"}).exit_code, 0);
  const json plan = json::parse(Content(folder_ / "plan/summary.json"));
  EXPECT_EQ(plan["verdict"], "accepted");
  EXPECT_THAT(plan["verdict_reasons"], IsEmpty());
}

}  // namespace
}  // namespace sarblock
