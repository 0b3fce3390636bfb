// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"

#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "files/result_fixture.h"
#include "quality/assess.h"
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

using test::kLooks;
using test::kPoints;
using test::kToml;

class ResultFilesTest : public test::ResultFolderTest {};

TEST_F(ResultFilesTest, WritesEveryFileOfTheContract) {
  files::WriteResult(folder_, block_, options_, result_, context_);
  for (const char* name : {"summary.json",
                           "points.csv",
                           "passes.csv",
                           "passes_covariance.csv",
                           "residuals.csv",
                           "pairs.csv",
                           "trajectories.csv",
                           "strips.csv",
                           "points.geojson"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / name)) << name;
  }
  EXPECT_EQ(FileCount(), 9u);
}

TEST_F(ResultFilesTest, ASelectionHasATableAndAPartOfTheSummary) {
  CandidateResult kept;
  kept.name = "range.bias";
  kept.passes = "A B";
  kept.parameters = 2;
  kept.test = SelectionTest::kWald;
  kept.statistic = 12.5;
  kept.f = 6.25;
  kept.probability = 0.03125;
  kept.delta_bic = -4.5;
  kept.condition = 8.0;
  kept.kept = true;
  kept.step = 3;
  kept.reason = "determinable, significant and pays";
  CandidateResult dropped;
  dropped.name = "time.bias";
  dropped.passes = "all";
  dropped.condition = std::numeric_limits<double>::infinity();
  dropped.reason = "not determinable";
  result_.selection.candidates = {kept, dropped};
  result_.selection.rounds = 2;
  result_.selection.simplifications = {{.name = "flat-frame",
                                        .bound_m = 0.5,
                                        .sigma_m = 4.0,
                                        .fraction = 0.125,
                                        .taken = true,
                                        .gain = 1.5,
                                        .verdict = "taken"}};
  result_.parameters[0].kept = "pays";
  files::WriteResult(folder_, block_, options_, result_, context_);
  const std::vector<TableColumn> columns{{"candidate"},
                                         {"passes"},
                                         {"parameters"},
                                         {"test"},
                                         {"statistic"},
                                         {"f"},
                                         {"p"},
                                         {"delta_bic"},
                                         {"condition"},
                                         {"posterior_prior"},
                                         {"verdict"},
                                         {"reason"},
                                         {"step"}};
  EXPECT_THAT(Row("selection.csv", 0, columns),
              ElementsAre("range.bias",
                          "A B",
                          "2",
                          "wald",
                          "12.5",
                          "6.25",
                          "0.03125",
                          "-4.5",
                          "8",
                          "",
                          "kept",
                          "determinable, significant and pays",
                          "3"));
  EXPECT_THAT(
      Row("selection.csv", 1, columns),
      ElementsAre(
          "time.bias", "all", "0", "", "", "", "", "", "", "", "dropped", "not determinable", ""));
  EXPECT_THAT(Row("simplifications.csv",
                  0,
                  {{"simplification"},
                   {"bound_m"},
                   {"sigma_m"},
                   {"fraction"},
                   {"allowed"},
                   {"taken"},
                   {"verdict"}}),
              ElementsAre("flat-frame", "0.5", "4", "0.125", "0", "1", "taken"));
  EXPECT_THAT(Row("passes.csv", 0, {{"parameter"}, {"kept"}}), ElementsAre("range.bias", "pays"));
  EXPECT_THAT(files::SummaryJson(block_, options_, result_, context_),
              testing::HasSubstr("\"rounds\": 2"));
  // An earlier selection leaves nothing behind.
  result_.selection = {};
  files::WriteResult(folder_, block_, options_, result_, context_);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "selection.csv"));
}

TEST_F(ResultFilesTest, PointsHaveSigmasFromTheCovariance) {  // hand values
  files::WriteResult(folder_, block_, options_, result_, context_);
  EXPECT_THAT(Row("points.csv",
                  0,
                  {{"point"},
                   {"role"},
                   {"status"},
                   {"looks"},
                   {"x_m"},
                   {"sigma_e_m"},
                   {"sigma_n_m"},
                   {"sigma_u_m"},
                   {"cov_en_m2"},
                   {"cov_eu_m2"},
                   {"cov_nu_m2"},
                   {"error_e_m"},
                   {"error_n_m"},
                   {"error_u_m"},
                   {"chi_square_3"},
                   {"sigma_leberl_across_m"},
                   {"sigma_leberl_up_m"},
                   {"redundancy"}}),
              ElementsAre("P",
                          "check",
                          "adjusted",
                          "1",
                          "6371000.5",
                          "3",
                          "2",
                          "1.5",
                          "1.5",
                          "-0.5",
                          "0.25",
                          "0.5",
                          "",
                          "-1.5",
                          "3.75",
                          "",
                          "",
                          ""));
  test::CsvRows reader(
      folder_ / "points.csv",
      std::vector<TableColumn>{{"lat_deg"}, {"lon_deg"}, {"h_m"}, {"intersection_deg"}});
  ASSERT_TRUE(reader.Next());
  const Eigen::Vector3d back_m = block_.frame.FrameFromGeodetic(
      {reader.Number(0) * kRadPerDeg, reader.Number(1) * kRadPerDeg, reader.Number(2)});
  // Two roundings of degrees at 6.4e6 m: 2e-9 m each.
  EXPECT_LE((back_m - result_.points.position_m[0]).norm(), 1e-8);
  EXPECT_DOUBLE_EQ(reader.Number(3), 0.375 * kDegPerRad);
}

TEST_F(ResultFilesTest, PointsNotSolvedHaveEmptyCellsAndAReason) {
  files::WriteResult(folder_, block_, options_, result_, context_);
  EXPECT_THAT(Row("points.csv",
                  1,
                  {{"point"},
                   {"role"},
                   {"x_m"},
                   {"lat_deg"},
                   {"sigma_e_m"},
                   {"cov_nu_m2"},
                   {"intersection_deg"},
                   {"chi_square_3"},
                   {"reason"}}),
              ElementsAre("Q,1", "tie", "", "", "", "", "", "", "one look"));
}

// Hand values: redundancy 1 - (0.5 / 20)^2 = 0.999375, w = -3.5 / (20 sqrt(0.999375)).
TEST_F(ResultFilesTest, ParametersHaveSignificance) {
  files::WriteResult(folder_, block_, options_, result_, context_);
  EXPECT_EQ(
      Content(folder_ / "passes.csv"),
      "pass,parameter,unit,value,sigma,prior_sigma,significance,kept,prior_redundancy,prior_w\n"
      "A,range.bias,m,-3.5,0.5,20,7,,0.999375,-0.17505471314812435\n"
      "B,range.bias,m,1.25,,,,,,\n");
  EXPECT_EQ(Content(folder_ / "passes_covariance.csv"),
            "pass_a,parameter_a,pass_b,parameter_b,covariance\n"
            "A,range.bias,A,range.bias,0.25\nA,range.bias,B,range.bias,-0.125\n");
}

TEST_F(ResultFilesTest, ThePosteriorFactorScalesEveryCovarianceAndNoPrior) {  // sigma0 = 2
  options_.scale_by_posterior = true;
  ScaleByPosterior(options_, &result_);
  files::WriteResult(folder_, block_, options_, result_, context_);
  EXPECT_THAT(Row("points.csv", 0, {{"sigma_e_m"}, {"cov_en_m2"}, {"chi_square_3"}}),
              ElementsAre("6", "6", "3.75"));
  EXPECT_THAT(Row("passes.csv", 0, {{"sigma"}, {"prior_sigma"}, {"significance"}}),
              ElementsAre("1", "20", "3.5"));
  EXPECT_THAT(Row("passes_covariance.csv", 1, {{"covariance"}}), ElementsAre("-0.5"));
  EXPECT_THAT(Row("pairs.csv", 0, {{"cov_ee_m2"}, {"cov_nu_m2"}, {"de_m"}}),
              ElementsAre("4", "1.2", "1.5"));
  result_.sigma0_squared = kNaN;
  EXPECT_EQ(PosteriorFactor(options_, result_), 1.0);
}

TEST_F(ResultFilesTest, The1979PredictionIsInPointsAndPairsAndNeverScaled) {
  options_.scale_by_posterior = true;  // sigma0 = 2
  ScaleByPosterior(options_, &result_);
  PointResults& points = result_.points;
  points.sigma_leberl_across_m = {3.5, kNaN};
  points.sigma_leberl_up_m = {4.5, kNaN};
  points.sigma_leberl_path_across_m = {5.5, kNaN};
  points.sigma_leberl_path_up_m = {kNaN, kNaN};
  points.leberl_across_azimuth_rad = {0.375, kNaN};
  result_.pairs[0].sigma_leberl_across_m = 6.5;
  result_.pairs[0].sigma_leberl_path_up_m = 7.5;
  files::WriteResult(folder_, block_, options_, result_, context_);
  const std::vector<TableColumn> columns{{"sigma_leberl_across_m"},
                                         {"sigma_leberl_up_m"},
                                         {"sigma_leberl_path_across_m"},
                                         {"sigma_leberl_path_up_m"}};
  EXPECT_THAT(Row("points.csv", 0, columns), ElementsAre("3.5", "4.5", "5.5", ""));
  EXPECT_THAT(Row("points.csv", 1, columns), ElementsAre("", "", "", ""));
  EXPECT_THAT(Row("pairs.csv", 0, columns), ElementsAre("6.5", "", "", "7.5"));
  test::CsvRows reader(folder_ / "points.csv",
                       std::vector<TableColumn>{{"leberl_across_azimuth_deg"}});
  ASSERT_TRUE(reader.Next());
  EXPECT_DOUBLE_EQ(reader.Number(0), 0.375 * kDegPerRad);
}

TEST_F(ResultFilesTest, ResidualsAreByLook) {
  files::WriteResult(folder_, block_, options_, result_, context_);
  const std::vector<TableColumn> columns{{"pass"},
                                         {"point"},
                                         {"range_residual_m"},
                                         {"azimuth_residual_m"},
                                         {"range_w"},
                                         {"weight"},
                                         {"rejected"}};
  EXPECT_THAT(Row("residuals.csv", 0, columns),
              ElementsAre("A", "P", "0.75", "-1.75", "", "0.5", "0"));
  EXPECT_THAT(Row("residuals.csv", 1, columns), ElementsAre("B", "P", "", "", "", "0", "1"));
  EXPECT_THAT(Row("residuals.csv", 2, columns),
              ElementsAre("A", "Q,1", "-0.25", "0.5", "", "1", "0"));
}

TEST_F(ResultFilesTest, TrajectoriesCanBeUsedAsInput) {  // round trip
  for (const Pass& pass : block_.passes) {
    std::vector<StateVector> states = pass.path.states();
    for (StateVector& state : states) state.position_m.z() += 1.0 / 3.0;
    result_.corrected_paths.emplace_back(std::move(states));
  }
  files::WriteResult(folder_, block_, options_, result_, context_);
  const std::string paths = Content(folder_ / "trajectories.csv");
  // Pass A has a range bias that no state can hold: the block has to ask for one.
  EXPECT_THAT(test::MessageOf<InputError>([&] {
                static_cast<void>(files::ReadBlockTexts({kToml, paths, kLooks, kPoints}));
              }),
              testing::HasSubstr("states of pass 'A' also corrected range.bias"));
  const std::string asking = std::string(kToml) + "[adjust.correction.range]\nbias = true\n";
  const Block again = files::ReadBlockTexts({asking, paths, kLooks, kPoints}).block;
  EXPECT_EQ(again.passes[1].path.states()[1].position_m,
            Eigen::Vector3d(7000000, 300000, 9000.0 + 1.0 / 3.0));
}

TEST_F(ResultFilesTest, AdjustedPathsNameTheCorrectionsOfTheirPassAlone) {
  for (const Pass& pass : block_.passes) result_.corrected_paths.push_back(pass.path);
  const std::string second = block_.passes[1].id;
  options_.groups.push_back({"radar", TimeCorrection{}, {second}, true});
  result_.parameters.push_back({"radar", "time.bias", "s", 1e-3, 1e-4, 1e-2});
  files::WriteResult(folder_, block_, options_, result_, context_);
  std::istringstream rows(Content(folder_ / "trajectories.csv"));
  std::string row;
  std::getline(rows, row);
  EXPECT_THAT(row, testing::EndsWith(",adjusted"));
  std::size_t seen = 0;
  while (std::getline(rows, row)) {
    const bool of_second = row.starts_with(second + ",");
    EXPECT_THAT(row, testing::EndsWith(of_second ? ",range.bias time.bias" : ",7500,0,range.bias"));
    seen += of_second ? 1U : 0U;
  }
  EXPECT_EQ(seen, 2U);  // both states of the pass
}

TEST_F(ResultFilesTest, TheSummaryIsReturnedAndSaysWhatWasAdjusted) {
  const std::string text = files::WriteResult(folder_, block_, options_, result_, context_);
  EXPECT_EQ(text, Content(folder_ / "summary.json"));
  const json summary = json::parse(text);
  EXPECT_EQ(summary["block"], "tiny");
  EXPECT_EQ(summary["status"], "converged");
  const json& counts = summary["counts"];
  EXPECT_EQ(counts["passes"], 2);
  EXPECT_EQ(counts["points"], 2);
  EXPECT_EQ(counts["looks"], 3);
  EXPECT_EQ(counts["parameters"], 9);
  EXPECT_EQ(counts["observations"], 17);
  EXPECT_EQ(counts["redundancy"], 8);
  EXPECT_EQ(counts["point_status"]["adjusted"], 1);
  EXPECT_EQ(summary["chi_square"]["value"], 32.0);
  EXPECT_EQ(summary["chi_square"]["redundancy"], 8.0);
  const json& ranges = summary["groups"][0];
  EXPECT_EQ(ranges["group"], "ranges");
  EXPECT_EQ(ranges["square_sum"], 24.0);
  EXPECT_EQ(ranges["redundancy"], 6.0);
  EXPECT_EQ(ranges["factor"], 4.0);
  EXPECT_NEAR(ranges["sigma"].get<double>(), 4.0 * std::sqrt(2.0 / 6.0), 1e-12);
  EXPECT_EQ(ranges["lower"], 0.5);
  EXPECT_EQ(ranges["upper"], 2.5);
  EXPECT_EQ(summary["chi_square"]["level"], 0.975);
  EXPECT_EQ(summary["chi_square"]["lower"], 2.5);
  EXPECT_TRUE(summary["condition"].is_null());
  EXPECT_EQ(summary["stages"]["read"]["wall_s"], 0.125);
  EXPECT_EQ(summary["stages"]["solve"]["wall_s"], 0.75);
  EXPECT_EQ(summary["stages"]["solve"]["peak_mib"], 90.0);
  EXPECT_TRUE(summary["stages"].contains("write"));
  EXPECT_EQ(summary["warnings"], json::array({"of reading", "of the result"}));
  EXPECT_EQ(summary["configuration"]["pairs"], "all");
  EXPECT_EQ(summary["configuration"]["test_level"], 0.975);
}

TEST_F(ResultFilesTest, EllipsesAreDrawnInTrueSize) {  // closed form: area of the 36-gon
  files::WriteResult(folder_, block_, options_, result_, context_);
  const json geo = json::parse(Content(folder_ / "points.geojson"));
  EXPECT_EQ(geo["type"], "FeatureCollection");
  ASSERT_EQ(geo["features"].size(), 2u);  // the point that is not solved has none
  const json& point = geo["features"][0];
  EXPECT_EQ(point["geometry"]["type"], "Point");
  EXPECT_EQ(point["properties"]["point"], "P");
  EXPECT_EQ(point["properties"]["sigma_e_m"], 3.0);
  const json& ring = geo["features"][1]["geometry"]["coordinates"][0];
  ASSERT_EQ(ring.size(), 37u);
  EXPECT_EQ(ring.front(), ring.back());
  const Eigen::Vector3d centre_m = result_.points.position_m[0];
  const Eigen::Matrix3d enu_from_frame = block_.frame.EnuFromFrame(centre_m);
  const Geodetic centre = block_.frame.GeodeticFromFrame(centre_m);
  Eigen::Matrix2d inverse;
  inverse << 9.0, 1.5, 1.5, 4.0;
  inverse = inverse.inverse().eval();
  double twice_area_m2 = 0.0;
  std::vector<Eigen::Vector2d> corners;
  for (const json& vertex : ring) {
    const Eigen::Vector3d p_m = block_.frame.FrameFromGeodetic(
        {vertex[1].get<double>() * kRadPerDeg, vertex[0].get<double>() * kRadPerDeg, centre.h_m});
    const Eigen::Vector2d enu_m = (enu_from_frame * (p_m - centre_m)).head<2>();
    // On the 1-sigma ellipse; 1e-12 degrees are 1e-7 m of its 2 to 3 m.
    EXPECT_NEAR(enu_m.dot(inverse * enu_m), 1.0, 1e-6);
    corners.push_back(enu_m);
  }
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    twice_area_m2 += corners[i].x() * corners[i + 1].y() - corners[i].y() * corners[i + 1].x();
  }
  // 18 sin(10 deg) sqrt(det); positive: counter-clockwise.
  EXPECT_NEAR(0.5 * twice_area_m2, 18.0 * std::sin(10.0 * kRadPerDeg) * std::sqrt(33.75), 1e-5);
}

TEST_F(ResultFilesTest, ManyPointsHaveNumbersButNoPolygons) {
  context_.ellipse_limit = 1;
  const json summary =
      json::parse(files::WriteResult(folder_, block_, options_, result_, context_));
  const json geo = json::parse(Content(folder_ / "points.geojson"));
  EXPECT_EQ(geo["features"].size(), 1u);
  EXPECT_NEAR(geo["features"][0]["properties"]["ellipse_major_m"].get<double>(),
              std::sqrt(6.5 + std::hypot(2.5, 1.5)),
              1e-12);
  EXPECT_THAT(summary["warnings"][1].get<std::string>(), HasSubstr("points.geojson"));
}

TEST_F(ResultFilesTest, AResultWithoutCovarianceOrResidualsIsWrittenToo) {
  AdjustResult bare;
  bare.status = AdjustStatus::kPredicted;
  bare.points.status = {PointStatus::kNotSeen, PointStatus::kNotSeen};
  bare.points.looks = {0, 0};
  bare.points.position_m.assign(2, Eigen::Vector3d::Constant(kNaN));
  options_.pairs = PairChoice::kNone;
  const json summary = json::parse(files::WriteResult(folder_, block_, options_, bare, context_));
  EXPECT_EQ(summary["status"], "predicted");
  EXPECT_TRUE(summary["chi_square"].is_null());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "pairs.csv"));
  EXPECT_THAT(Row("residuals.csv", 1, {{"range_residual_m"}, {"rejected"}}), ElementsAre("", "1"));
  EXPECT_EQ(json::parse(Content(folder_ / "points.geojson"))["features"].size(), 0u);
}

}  // namespace
}  // namespace sarblock
