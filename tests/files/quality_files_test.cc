// SPDX-License-Identifier: Apache-2.0
// Quality figures in the files of a result, and looks left out again by a table.
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"

#include <array>
#include <limits>

#include "quality/assess.h"
#include "support/csv_rows.h"
#include "support/folder_test.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::string_view kQualityToml =
    "format = \"sarblock-block 1\"\nname = \"tiny\"\n[frame]\nkind = \"local\"\n"
    "[sigma]\nrange_m = 1.5\nazimuth_m = 2.5\n"
    "[[pass]]\nid = \"A\"\nlook = \"left\"\n[[pass]]\nid = \"B\"\nlook = \"left\"\n";
constexpr std::string_view kQualityPaths =
    "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\n"
    "A,0,0,0,9000,200,0,0\nA,40,8000,0,9000,200,0,0\n"
    "B,0,0,3000,9000,200,0,0\nB,40,8000,3000,9000,200,0,0\n";
constexpr std::string_view kQualityLooks =
    "pass,point,time_s,range_m,rejected\nA,P,12.5,15000,0\nB,P,12.5,13000,0\nA,Q,13.5,15000,\n";
constexpr std::string_view kQualityPoints =
    "point,role,x_m,y_m,z_m,sigma_e_m,sigma_n_m,sigma_u_m\nP,control,2500,12000,0,,,0.5\n";
// Normal quantiles: the test of one observation at 0.001 from both sides, its power 0.8.
constexpr double kCriticalW = 3.2905, kDelta0 = kCriticalW + 0.8416;
constexpr float kNoFigure = std::numeric_limits<float>::quiet_NaN();

class QualityFilesTest : public test::FolderTest {
 protected:
  QualityFilesTest()
      : block_(files::ReadBlockTexts({kQualityToml, kQualityPaths, kQualityLooks, kQualityPoints})
                   .block) {
    result_.status = AdjustStatus::kConverged;
    result_.points.status = {PointStatus::kAdjusted, PointStatus::kTooFewLooks};
    result_.points.reason = {"", "one look"};
    result_.points.looks = {2, 0};
    result_.points.position_m.assign(2, Eigen::Vector3d(2500, 12000, 0));
    result_.sigma0_squared = 4.0;
    result_.test_redundancy = 4.0;
    result_.observation_count = 7;
    result_.parameter_count = 3;
    // r = 0.25 doubles delta0.
    result_.quality.redundancy = {{{0.25F, 0.25F, kNoFigure}, {0.0F, 1.0F, kNoFigure}}};
    result_.quality.w = {{{-3.5F, 2.0F, kNoFigure}, {kNoFigure, 0.5F, kNoFigure}}};
    result_.quality.shift_m = {{{0.5F, 0.25F, kNoFigure}, {1.0F, 2.0F, kNoFigure}}};
    ControlQuality control;
    control.component = 2;
    control.residual_m = 0.125;
    control.redundancy = 0.25;
    control.w = -4.0;
    control.shift_m = 0.25;
    result_.control_quality = {control};
    BlunderFinding finding;
    finding.round = 1;
    finding.w = -9.5;
    finding.looks = {1, 0};
    finding.action = BlunderFinding::Action::kPointLeftOut;
    result_.snooping = SnoopingReport{2, {finding}, {}};
    result_.looks.rejected = {1, 1, 0};
    result_.looks.reason = {RejectReason::kSuspect, RejectReason::kSuspect, RejectReason::kNone};
  }
  /// summary.json, with the verdict and its figures formed anew.
  std::string Summary() {
    result_.assessment = {};
    Assess(block_, options_, &result_);
    return files::SummaryJson(block_, options_, result_, {});
  }
  std::vector<std::string> Row(const std::string& table,
                               std::size_t row,
                               const std::vector<TableColumn>& columns) const {
    test::CsvRows reader(folder_ / "result" / table, columns);
    for (std::size_t i = 0; i <= row; ++i) EXPECT_TRUE(reader.Next());
    std::vector<std::string> cells;
    for (std::size_t i = 0; i < columns.size(); ++i) cells.emplace_back(reader.Text(i));
    return cells;
  }
  Block block_;
  AdjustOptions options_;
  AdjustResult result_;
};

TEST_F(QualityFilesTest, ResidualsHaveTheFiguresOfTheirLook) {  // hand values
  files::WriteResult(folder_ / "result", block_, options_, result_, {});
  EXPECT_THAT(Row("residuals.csv",
                  0,
                  {{"range_redundancy"},
                   {"azimuth_redundancy"},
                   {"range_w"},
                   {"azimuth_w"},
                   {"range_tau"},
                   {"azimuth_tau"},
                   {"azimuth_mdb_m"},
                   {"rejected"},
                   {"reason"},
                   {"finding"}}),
              ElementsAre("0.25", "0", "-3.5", "", "-1.75", "", "", "1", "suspect", "1"));
  const std::vector<std::string> sizes =
      Row("residuals.csv",
          1,
          {{"range_mdb_m"}, {"azimuth_mdb_m"}, {"range_influence_m"}, {"azimuth_influence_m"}});
  EXPECT_NEAR(std::stod(sizes[0]), 2.0 * 1.5 * kDelta0, 2e-4);
  EXPECT_NEAR(std::stod(sizes[1]), 2.5 * kDelta0, 2e-4);
  EXPECT_NEAR(std::stod(sizes[2]), 2.0 * 0.25 * kDelta0, 2e-4);
  EXPECT_NEAR(std::stod(sizes[3]), 2.0 * kDelta0, 2e-4);
  EXPECT_THAT(Row("residuals.csv", 2, {{"range_redundancy"}, {"range_mdb_m"}, {"finding"}}),
              ElementsAre("", "", ""));
}

TEST_F(QualityFilesTest, DetectableBlundersTakeTheStandardDeviationsEstimated) {  // hand values
  VarianceComponent range;
  range.passes = {0, 1};
  range.factor = 0.25;
  VarianceComponent azimuth;
  azimuth.passes = {1};
  azimuth.component = 1;
  azimuth.factor = 9.0;
  result_.variance_components = VarianceComponentReport{{range, azimuth}, {}, 1, true};
  files::WriteResult(folder_ / "result", block_, options_, result_, {});
  const std::vector<std::string> sizes =
      Row("residuals.csv",
          1,
          {{"range_mdb_m"}, {"azimuth_mdb_m"}, {"range_influence_m"}, {"azimuth_influence_m"}});
  EXPECT_NEAR(std::stod(sizes[0]), 2.0 * 0.5 * 1.5 * kDelta0, 2e-4);
  EXPECT_NEAR(std::stod(sizes[1]), 3.0 * 2.5 * kDelta0, 4e-4);
  // The shift of the point by one sigma is of the weights reached already.
  EXPECT_NEAR(std::stod(sizes[2]), 2.0 * 0.25 * kDelta0, 2e-4);
  EXPECT_NEAR(std::stod(sizes[3]), 2.0 * kDelta0, 2e-4);
}

TEST_F(QualityFilesTest, ControlHasATableOfItsOwn) {
  files::WriteResult(folder_ / "result", block_, options_, result_, {});
  EXPECT_THAT(Row("control_quality.csv",
                  0,
                  {{"point"}, {"component"}, {"residual_m"}, {"redundancy"}, {"w"}, {"tau"}}),
              ElementsAre("P", "u", "0.125", "0.25", "-4", "-2"));
  const std::vector<std::string> sizes =
      Row("control_quality.csv", 0, {{"mdb_m"}, {"influence_m"}});
  EXPECT_NEAR(std::stod(sizes[0]), 2.0 * 0.5 * kDelta0, 2e-4);
  EXPECT_NEAR(std::stod(sizes[1]), 2.0 * 0.25 * kDelta0, 2e-4);
  result_.control_quality.clear();
  files::WriteResult(folder_ / "result", block_, options_, result_, {});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "result/control_quality.csv"));
}

TEST_F(QualityFilesTest, TheSummarySaysWhatWasTestedAndFound) {
  const json summary = json::parse(Summary());
  const json& quality = summary["quality"];
  EXPECT_EQ(quality["tests"], 4);  // three of looks, one of control
  EXPECT_NEAR(quality["critical_w"].get<double>(), kCriticalW, 5e-5);
  EXPECT_EQ(quality["above_critical"], json({{"range", 1}, {"azimuth", 0}, {"control", 1}}));
  EXPECT_EQ(quality["worst"][0]["w"], -3.5);
  EXPECT_EQ(quality["worst"][0]["pass"], "A");
  const json& finding = summary["snooping"]["findings"][0];
  EXPECT_EQ(finding["passes"], json({"B", "A"}));
  EXPECT_EQ(finding["located"], false);
  EXPECT_EQ(finding["action"], "point left out");
  // tau = w / 2 of 4 redundant observations: critical is 2 t / sqrt(3 + t^2) = 1.982 with
  // t = 12.92, Student's 0.9995 quantile of 3 degrees of freedom.
  options_.quality.test = BlunderTest::kTau;
  EXPECT_EQ(json::parse(Summary())["quality"]["above_critical"],
            json({{"range", 0}, {"azimuth", 0}, {"control", 1}}));
}

TEST_F(QualityFilesTest, CheckPointsJudgeThePredictedAccuracy) {  // hand values
  result_.checks = {{0, Eigen::Vector3d(1, 1, 1), 9.0, 3}, {1, Eigen::Vector3d(1, 1, 1), 3.0, 3}};
  result_.points.status[1] = PointStatus::kAdjusted;
  options_.test_level = 0.55;  // of nine tests together: 0.95 of one
  json checks = json::parse(Summary())["check_points"];
  EXPECT_EQ(checks["chi_square"], 12.0);
  EXPECT_NEAR(checks["lower"].get<double>(), 1.237, 5e-4);  // tables, 6 degrees of freedom
  EXPECT_NEAR(checks["upper"].get<double>(), 14.449, 5e-4);
  EXPECT_EQ(checks["points_outside"], 1);  // 9.0 above 7.815
  EXPECT_EQ(checks["realistic"], true);
  EXPECT_THAT(checks["says"].get<std::string>(), HasSubstr("is realistic: errors of check points"));
  EXPECT_THAT(checks["says"].get<std::string>(), HasSubstr("1.41 times as large as predicted"));
  result_.checks[0].chi_square = 12.0;
  checks = json::parse(Summary())["check_points"];
  EXPECT_EQ(checks["realistic"], false);
  EXPECT_THAT(checks["says"].get<std::string>(), HasSubstr("TOO OPTIMISTIC"));
}

TEST_F(QualityFilesTest, ATableOfRejectionsLeavesLooksOut) {
  Put("out.csv", "point,reason,pass,rejected\nP,blunder,B,1\nQ,,A,0\n");
  EXPECT_EQ(files::ApplyRejections(folder_, "out.csv", &block_), 1U);
  EXPECT_FALSE(block_.looks.rejected(0));
  EXPECT_TRUE(block_.looks.rejected(1));
  EXPECT_FALSE(block_.looks.rejected(2));
  EXPECT_EQ(files::ApplyRejections(folder_, "out.csv", &block_), 0U);  // it was out already
}

}  // namespace
}  // namespace sarblock
