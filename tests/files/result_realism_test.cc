// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"

#include <string>

#include "support/folder_test.h"
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using nlohmann::json;

/// Two points of two passes, the second without a solution; figures by hand.
class ResultRealismTest : public test::FolderTest {
 protected:
  ResultRealismTest()
      : block_(files::ReadBlockTexts(
                   {"format = \"sarblock-block 1\"\nname = \"tiny\"\n[frame]\nkind = \"local\"\n"
                    "[sigma]\nrange_m = 1.5\nazimuth_m = 2.5\n"
                    "[[pass]]\nid = \"A\"\nlook = \"left\"\n[[pass]]\nid = \"B\"\nlook = "
                    "\"left\"\n",
                    "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\n"
                    "A,0,0,0,9000,100,0,0\nA,40,4000,0,9000,100,0,0\n"
                    "B,0,0,5000,9000,100,0,0\nB,40,4000,5000,9000,100,0,0\n",
                    "pass,point,time_s,range_m\nA,P,12.5,15000\nB,P,12.5,12000\nA,Q,13,15100\n",
                    {}})
                   .block) {
    result_.status = AdjustStatus::kConverged;
    PointResults& points = result_.points;
    points.status = {PointStatus::kAdjusted, PointStatus::kTooFewLooks};
    points.looks = {2, 1};
    points.position_m = {Eigen::Vector3d(1250, 12000, 100), Eigen::Vector3d::Constant(kNaN)};
    points.covariance_m2 = {SymmetricEnu{4.0, 9.0, 16.0, 0, 0, 0},
                            SymmetricEnu{kNaN, kNaN, kNaN, kNaN, kNaN, kNaN}};
    result_.observation_count = 12;
    result_.parameter_count = 2;
    result_.sigma0_squared = 1.5;
    result_.test_redundancy = 10.0;
    result_.chi_square = {3.25, 20.5};
    result_.chi_square_passed = true;
  }
  [[nodiscard]] json Summary() const {
    return json::parse(files::SummaryJson(block_, options_, result_, context_));
  }

  Block block_;
  AdjustOptions options_;
  AdjustResult result_;
  files::ResultContext context_;
};

TEST_F(ResultRealismTest, WithoutThemThereAreNoSections) {
  Put("montecarlo.csv", "of an earlier run\n");
  files::WriteResult(folder_, block_, options_, result_, context_);
  EXPECT_FALSE(Summary().contains("variance_components"));
  EXPECT_FALSE(Summary().contains("montecarlo"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "montecarlo.csv"));
}

TEST_F(ResultRealismTest, VarianceComponentsHaveBothTests) {  // hand values
  VarianceComponentReport report;
  report.iterations = 7;
  report.converged = true;
  report.before = {6.0, 10.0, {3.25, 20.5}, false};
  VarianceComponent range;
  range.group = "A+B";
  range.looks = 3;
  range.redundancy = 4.5;
  range.factor = 9.0;
  range.factor_deviation = 3.0;
  range.sigma_before = 1.5;
  range.unit = "m";
  range.estimated = true;
  VarianceComponent azimuth;
  azimuth.group = "A";
  azimuth.component = 1;
  azimuth.sigma_before = 2.5;
  azimuth.note = "held: no redundancy";
  report.components = {range, azimuth};
  result_.variance_components = report;
  const json section = Summary()["variance_components"];
  EXPECT_EQ(section["iterations"], 7);
  EXPECT_EQ(section["before"]["sigma0_squared"], 6.0);
  EXPECT_EQ(section["before"]["value"], 60.0);
  EXPECT_EQ(section["before"]["passed"], false);
  EXPECT_EQ(section["after"]["sigma0_squared"], 1.5);
  EXPECT_EQ(section["after"]["redundancy"], 10.0);
  EXPECT_EQ(section["after"]["upper"], 20.5);
  EXPECT_EQ(section["after"]["passed"], true);
  const json& first = section["components"][0];
  EXPECT_EQ(first["group"], "A+B");
  EXPECT_EQ(first["component"], "range");
  EXPECT_EQ(first["looks"], 3);
  EXPECT_EQ(first["redundancy"], 4.5);
  EXPECT_EQ(first["sigma_after"], 4.5);         // sqrt(9) 1.5
  EXPECT_EQ(first["sigma_after_sigma"], 0.75);  // 4.5 (3 / 9) / 2
  const json& second = section["components"][1];
  EXPECT_EQ(second["component"], "azimuth");
  EXPECT_EQ(second["estimated"], false);
  EXPECT_EQ(second["factor"], 1.0);
  EXPECT_EQ(second["sigma_after"], 2.5);
  EXPECT_TRUE(second["factor_sigma"].is_null());
  EXPECT_EQ(second["note"], "held: no redundancy");
}

TEST_F(ResultRealismTest, MonteCarloHasASectionAndATable) {  // hand values
  MonteCarloReport report;
  report.runs = 40;
  report.failed = 1;
  report.seed = 5;
  report.points = 1;
  report.sample_m2 = {{4.0, 36.0, 4.0, 0, 0, 0}, {kNaN, kNaN, kNaN, kNaN, kNaN, kNaN}};
  report.square = {1.25, kNaN};
  report.inside = {{{20, 0}, {35, 0}, {40, 0}}};
  report.square_ratio = {1.0, 1.25, 0.0};
  report.coverage[1] = {0.9, 0.875, 0.05};
  report.sentence = "plain";
  result_.montecarlo = report;
  files::WriteResult(folder_, block_, options_, result_, context_);
  EXPECT_EQ(Content(folder_ / "montecarlo.csv"),
            "point,sample_sigma_e_m,sample_sigma_n_m,sample_sigma_u_m,sigma_e_m,sigma_n_m,"
            "sigma_u_m,ratio_e,ratio_n,ratio_u,normalised_square,coverage_50,coverage_90,"
            "coverage_99\nP,2,6,2,2,3,4,1,2,0.5,1.25,0.5,0.875,1\n");
  const json section = Summary()["montecarlo"];
  EXPECT_EQ(section["runs"], 40);
  EXPECT_EQ(section["failed"], 1);
  EXPECT_EQ(section["seed"], 5);
  EXPECT_EQ(section["verdict"], "plain");
  EXPECT_EQ(section["normalised_square"]["mean"], 1.25);
  EXPECT_EQ(section["normalised_square"]["agrees"], false);
  EXPECT_EQ(section["coverage_90"]["agrees"], true);
  // The 99.5 percent point of the normal distribution is 2.5758.
  EXPECT_NEAR(section["coverage_90"]["upper"].get<double>(), 0.875 + 2.5758 * 0.05, 1e-5);
}

}  // namespace
}  // namespace sarblock
