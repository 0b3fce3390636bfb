// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <initializer_list>
#include <sstream>
#include <utility>

#include "report/result_page.h"
#include "report/shown_result.h"
#include "support/folder_test.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr std::string_view kSummary = R"({
  "format": "sarblock-result 1", "version": "0.1.0", "command": "adjust", "block": "a <b>block</b>",
  "frame": {"kind": "local"}, "status": "converged", "verdict": "converged, tests failed", "accepted": true,
  "passes": [{"id": "A", "look": "left", "start_s": 0, "end_s": 40},
    {"id": "B", "look": "right", "start_s": 0, "end_s": 40}],
  "counts": {"passes": 2, "points": 3, "looks": 3, "redundancy": 7.0, "point_status": {"adjusted": 2}},
  "iterations": 4, "initial_cost": 9.5, "final_cost": 5.25, "gradient": 1e-9, "sigma0_squared": 1.5,
  "sigma_scaled_by_posterior": false, "covariance": "block", "condition": null,
  "chi_square": {"value": 10.5, "lower": 2.5, "upper": 17.5, "level": 0.975, "passed": true},
  "quality": {"alpha_one": 0.001, "critical_w": 3.29, "tests": 10, "expected_above": 0.01,
    "above_critical": {"range": 1, "azimuth": 0, "control": 0}},
  "stages": {"solve": {"wall_s": 0.25, "peak_mib": 80.5}},
  "warnings": ["</script><script>alert(1)</script>"],
  "inputs": [{"file": "block.toml", "bytes": 120, "sha256": "00ff"}],
  "configuration": {"robust": "none", "correction": {"range": {"bias": true}}}
})";

constexpr std::string_view kPointHeader =
    "point,role,status,looks,x_m,y_m,z_m,sigma_e_m,sigma_n_m,sigma_u_m,cov_en_m2,cov_eu_m2,"
    "cov_nu_m2,intersection_deg\n";

class ReportFileTest : public test::FolderTest {
 protected:
  std::string Page(const std::string& name = "report.html") const {
    return Content(folder_ / name);
  }
  void PutResult() const {
    Put("summary.json", kSummary);
    Put("points.csv",
        "point,role,status,looks,x_m,y_m,z_m,sigma_e_m,sigma_n_m,sigma_u_m,cov_en_m2,cov_eu_m2,"
        "cov_nu_m2,intersection_deg,error_e_m,error_n_m,error_u_m,chi_square_3,error_sigma_e_m,"
        "error_sigma_n_m,error_sigma_u_m,sigma_held_e_m,sigma_held_n_m,sigma_held_u_m,"
        "cov_held_en_m2,redundancy,reason\n"
        "P1,tie,adjusted,2,0,0,5,1.5,2.5,3.5,0,0,0,12,,,,,,,,0.75,1.25,2.125,0,1.75,\n"
        "\"</td><i>P2\",check,adjusted,3,4000,3000,5,1,2,3,0,0,0,15,0.5,-0.25,1.5,1.25,2,2.5,3,"
        "0.5,1,1.5,0,2.5,\n"
        "P3,tie,too-few-looks,1,,,,,,,,,,,,,,,,,,,,,,,one look\n");
    Put("passes.csv",
        "pass,parameter,unit,value,sigma,prior_sigma,significance,kept\n"
        "A,range.bias,m,5,0.5,10,10,\nB,range.bias,m,2,0.25,,8,\n");
    Put("passes_covariance.csv",
        "pass_a,parameter_a,pass_b,parameter_b,covariance\nA,range.bias,A,range.bias,0.25\n"
        "A,range.bias,B,range.bias,0.12\nB,range.bias,B,range.bias,0.0625\n");
    Put("residuals.csv",
        "pass,point,range_residual_m,azimuth_residual_m,range_redundancy,azimuth_redundancy,"
        "range_w,azimuth_w,range_mdb_m,azimuth_mdb_m,range_influence_m,azimuth_influence_m,weight,"
        "rejected,reason\n"
        "A,P1,0.5,-0.25,0.5,0.25,1.5,-0.75,4,5,6,7,1,0,\n"
        "B,P1,1,1,0.75,0.5,-4.25,2,4.5,5.5,6.5,7.5,1,0,\nB,P3,77.5,1,,,,,,,,,0,1,given\n");
    Put("control_quality.csv",
        "point,component,residual_m,sigma_m,redundancy,w,tau,mdb_m,influence_m\n"
        "P1,n,-0.625,1.375,0.0625,-3.5,-3.25,8.75,2.25\n");
    Put("pairs.csv",
        "point_a,point_b,de_m,dn_m,du_m,cov_ee_m2,cov_nn_m2,cov_uu_m2,cov_en_m2,cov_eu_m2,cov_nu_"
        "m2,"
        "sigma_leberl_across_m,sigma_leberl_up_m\n"
        "P1,\"</td><i>P2\",4000,3000,0,0.0625,0.5625,1.5625,0,0,0,0.375,0.875\n");
    Put("strips.csv",
        "pass,look,time_s,strip_time,x_m,y_m,z_m,near_x_m,near_y_m,near_z_m,far_x_m,far_y_m,far_z_"
        "m,"
        "correction_along_m,correction_across_m,correction_up_m,sigma_along_m,sigma_across_m,"
        "sigma_up_m\n"
        "A,left,0,-1,0,0,9000,0,1000,0,0,4500,0,,,,,,\n"
        "A,left,40,1,3000,4000,9000,3000,5000,0,3000,8500,0,,,,,,\n");
  }
  // A row of a table of the page; numbers are set to the right.
  static std::string Row(std::initializer_list<const char*> cells) {
    std::string row;
    for (const std::string cell : cells) {
      const bool number = cell.starts_with('#');
      row += (number ? "<td class=\"n\">" + cell.substr(1) : "<td>" + cell) + "</td>";
    }
    return row;
  }
};

TEST_F(ReportFileTest, ReadsWhatAResultFolderHolds) {
  PutResult();
  const ResultFolder result = ReadResultFolder(folder_);
  EXPECT_EQ(result.file.summary.configuration.back().first, "correction.range.bias");
  EXPECT_THAT(result.unsolved, ElementsAre(2u));
  EXPECT_EQ(SigmaOf(result.file.points, 0, 2), 3.5);
  EXPECT_EQ(FixedPathSigmaOf(result.file.points, 0, 2), 2.125);
  // 0.12 / (0.5 0.25)
  ASSERT_EQ(result.correlation_count, 1u);
  EXPECT_NEAR(result.correlations[0].correlation, 0.96, 1e-15);
  EXPECT_EQ(result.looks.rejected, 1u);
  ASSERT_EQ(result.looks.worst.size(), 4u);
  EXPECT_EQ(result.looks.worst[0].look, 1u);
  EXPECT_EQ(result.looks.worst[0].component, 0u);
  EXPECT_EQ(result.looks.worst[1].component, 1u);
  EXPECT_EQ(result.looks.left_out[0].look, 2u);
}

// Hand arithmetic from the tables above. Numbers have three or four significant digits.
TEST_F(ReportFileTest, ShowsTheNumbersOfTheTables) {
  PutResult();
  WriteReport(folder_);
  const std::string page = Page();
  for (const std::string& row :
       {// 2.5 / 7 and 17.5 / 7
        Row({"looks and control", "#1.500", "#0.3571", "#2.500", "#97.5 %", "#7", "passed"}),
        // mean, root mean square, predicted, their ratio
        Row({"x", "#1", "#0.500", "#0.500", "#2.00", "#0.250"}),
        Row({"z", "#1", "#1.50", "#1.50", "#3.00", "#0.500"}),
        // a component of a control point
        Row({"P1", "y", "#-0.625", "#1.38", "#0.0625", "#-3.50", "#8.75", "#2.25"}),
        // the weakest point
        Row({"P1", "tie", "#1.50", "#2.50", "#3.50", "#2.12", "#2", "#12.0", "#1.75"}),
        // heading atan(3/4), 3.5 km from near to far
        Row({"A", "left", "#36.87", "#0", "#40.0000", "#3.50"}),
        // sqrt((0.25 + 1) / 2), mean and deviation of 1.5 and -4.25, medians of two
        Row({"range", "#2", "#0.791", "#-1.4", "#2.88", "#4.25", "#0.625", "#4.25", "#6.25"}),
        // the worst look
        Row({"P1",
             "#-4.25",
             "B range",
             "#1.00",
             "#0.750",
             "#4.50",
             "#6.50",
             "B azimuth 2.00, A range 1.50, A azimuth -0.750"}),
        Row({"B", "P3", "given", "#77.5 range"}),
        Row({"A", "range.bias", "#5.000", "#0.500", "m", "#10.0", "#10.0 sigma"}),
        Row({"A range.bias", "B range.bias", "#+0.9600"}),
        Row({"solve", "#0.250", "#80.5"})}) {
    EXPECT_THAT(page, HasSubstr(row));
  }
  EXPECT_THAT(page,
              AllOf(HasSubstr("1.25, 2.25, 3.25 m"),  // medians of two points
                    HasSubstr("differences of 1 pairs of points have median sigmas of 0.250 m x, "
                              "0.750 m y and 1.25 m z; the 1979 paper gives 0.375 m across and "
                              "0.875 m in height")));
}

TEST_F(ReportFileTest, HoldsTheVerdictTheTablesAndTheChartLibraryAndNothingFromElsewhere) {
  PutResult();
  const ReportFile report = WriteReport(folder_);
  EXPECT_EQ(report.kind, "result");
  EXPECT_EQ(report.verdict, "Converged, tests failed");
  const std::string page = Page();
  EXPECT_EQ(page.size(), report.bytes);
  EXPECT_THAT(page,
              AllOf(HasSubstr("Chart.js v3"),
                    HasSubstr("The MIT License"),
                    HasSubstr("00ff"),
                    HasSubstr("one look"),
                    Not(HasSubstr("src=\"http")),
                    Not(HasSubstr("<link")),
                    Not(HasSubstr("{{"))));
}

TEST_F(ReportFileTest, EscapesTextOfTheFiles) {
  PutResult();
  WriteReport(folder_);
  const std::string page = Page();
  EXPECT_THAT(page,
              AllOf(HasSubstr("a &lt;b&gt;block&lt;/b&gt;"),
                    HasSubstr("&lt;/script&gt;&lt;script&gt;alert(1)"),
                    Not(HasSubstr("<script>alert")),
                    Not(HasSubstr("</td><i>")),
                    HasSubstr("\\u003c/td\\u003e\\u003ci\\u003eP2")));
}

TEST_F(ReportFileTest, TheSameFolderGivesTheSameBytes) {
  PutResult();
  WriteReport(folder_, folder_ / "one.html");
  WriteReport(folder_, folder_ / "two.html");
  EXPECT_EQ(Page("one.html"), Page("two.html"));
}

TEST_F(ReportFileTest, SaysWhatAPredictionLacks) {
  std::string predicted(kSummary);
  for (const auto& [from, to] : std::initializer_list<std::pair<std::string, std::string>>{
           {"\"adjust\"", "\"predict\""},
           {"\"converged\"", "\"predicted\""},
           {"\"points\": 3", "\"points\": 0"},
           {"\"looks\": 3", "\"looks\": 0"}}) {
    predicted.replace(predicted.find(from), from.size(), to);
  }
  Put("summary.json", predicted);
  Put("points.csv", kPointHeader);
  Put("passes.csv", "pass,parameter,unit,value,sigma,prior_sigma\n");
  Put("residuals.csv", "pass,point,range_residual_m,azimuth_residual_m,rejected\n");
  EXPECT_EQ(WriteReport(folder_).verdict, "Predicted");
  EXPECT_THAT(Page(),
              AllOf(HasSubstr("A prediction has no residuals"),
                    HasSubstr("No point has a position"),
                    HasSubstr("No corrections were estimated"),
                    HasSubstr("There are no control points")));
}

TEST_F(ReportFileTest, AHundredThousandPointsStayBelowFiveMegabytesWithANote) {
  std::string summary(kSummary);
  for (const char* count : {"\"points\": 3", "\"looks\": 3"}) {
    summary.replace(summary.find(count) + std::string_view(count).size() - 1, 1, "100000");
  }
  Put("summary.json", summary);
  Put("passes.csv", "pass,parameter,unit,value,sigma,prior_sigma\n");
  std::ostringstream points, looks;
  points << kPointHeader;
  looks << "pass,point,range_residual_m,azimuth_residual_m,range_w,azimuth_w,rejected\n";
  for (int i = 0; i < 100000; ++i) {
    const double x = 0.137 * i, y = 0.731 * (i % 1009);
    points << "POINT-" << i << ",tie,adjusted,3," << x << ',' << y << ",1,0." << 100 + i % 777
           << ",0.5,1." << i % 991 << ",0.01,0,0,11.25\n";
    looks << (i % 2 == 0 ? "A" : "B") << ",POINT-" << i << ",0.5,0.25," << 0.001 * (i % 3001)
          << ",-1.5,0\n";
  }
  Put("points.csv", points.str());
  Put("residuals.csv", looks.str());
  EXPECT_LT(WriteReport(folder_).bytes, 5000000u);
  EXPECT_THAT(Page(),
              HasSubstr("100\xe2\x80\xaf"
                        "000 points are shown, drawn at random"));
}

TEST_F(ReportFileTest, RefusesWhatIsNoResultAndNoStudy) {
  const auto report = [&] { return WriteReport(folder_).bytes; };
  EXPECT_THAT(test::MessageOf<InputError>(report), HasSubstr("no summary.json"));
  Put("summary.json", "{\"format\": \"sarblock-scene 1\"}");
  EXPECT_THAT(test::MessageOf<InputError>(report), HasSubstr("'sarblock-scene 1' is not known"));
  Put("summary.json", "{");
  EXPECT_THAT(test::MessageOf<InputError>(report), HasSubstr("is not valid JSON"));
}

TEST_F(ReportFileTest, SaysOfAFolderWhetherItIsMissingAFileOrABlock) {
  const auto message = [&](const char* name) {
    return test::MessageOf<InputError>([&] { return WriteReport(folder_ / name).bytes; });
  };
  Put("file", "text\n");
  std::filesystem::create_directory(folder_ / "block");
  Put("block/block.toml", "format = \"sarblock-block 1\"\n");
  EXPECT_THAT(message("none"), HasSubstr("none: does not exist; a result or a study is a folder"));
  EXPECT_THAT(message("file"),
              HasSubstr("file: is a file that is no HDF5 file; a result or a study is a folder"));
  EXPECT_THAT(message("block"), HasSubstr("block: is a block, not a result or a study; a result"));
}

TEST_F(ReportFileTest, SetsTwoResultsSideBySide) {
  PutResult();
  std::filesystem::create_directory(folder_ / "b");
  for (const char* name : {"points.csv", "passes.csv", "residuals.csv"}) {
    std::filesystem::copy(folder_ / name, folder_ / "b" / name);
  }
  std::string changed(kSummary);
  changed.replace(changed.find("\"none\""), 6, "\"huber\"");
  Put("b/summary.json", changed);
  const ReportFile report = WriteComparison(folder_, folder_ / "b");
  EXPECT_EQ(report.file, folder_ / "b" / "comparison.html");
  EXPECT_THAT(Page("b/comparison.html"),
              AllOf(HasSubstr("<td>robust</td><td>&quot;none&quot;</td><td>&quot;huber&quot;</td>"),
                    HasSubstr("2 points are solved in both"),
                    HasSubstr("1 setting and 0 input files differ")));
}

TEST_F(ReportFileTest, DrawsStudiesFromTheirTables) {
  Put("densification.csv",
      "layout,control_points,median_sigma_e_m,median_sigma_n_m,median_sigma_u_m,montecarlo_rms_u_m,"
      "nees,"
      "determined\n"
      "corners,4,1,2,3.5,3.25,1.02,1\ncorners,8,1,2,2.5,,,1\nnone,0,,,,,,0\n");
  EXPECT_EQ(WriteReport(folder_).kind, "densification");
  EXPECT_THAT(
      Page(),
      AllOf(HasSubstr("The best height, a median sigma of 2.50 m, has the layout corners with 8"),
            HasSubstr("1 arrangements do not determine the block"),
            HasSubstr("the study is not finished"),
            HasSubstr("\"id\":\"densification-u\"")));
  std::filesystem::remove(folder_ / "densification.csv");
  Put("tradeoff.csv",
      "stage,choice,looks,wall_s,speed_ratio,position_error_sigma,covariance_error,pareto\n"
      "covariance,montecarlo,,,,,,0\n"
      "covariance,block,900,2.5,1,0,0,1\ncovariance,leberl,900,0.01,250,0,0.5,1\n");
  EXPECT_EQ(WriteReport(folder_).kind, "tradeoff");
  Put("tradeoff.study.toml",
      "format = 'sarblock-study 1'\nstudy = 'tradeoff'\nname = 'what <speed> costs'\n"
      "purpose = 'to know it'\n");
  Put("tradeoff.txt", "100 points: leberl is enough\n");
  WriteReport(folder_);
  EXPECT_THAT(Page(),
              AllOf(HasSubstr("<h1>what &lt;speed&gt; costs</h1>"),
                    HasSubstr("Goal: to know it"),
                    HasSubstr("<p>100 points: leberl is enough.</p>"),
                    HasSubstr("\"names\":[\"leberl\",\"block\"],\"written\":true"),
                    Not(HasSubstr("choices in 1 stages"))));
  std::filesystem::remove(folder_ / "tradeoff.txt");
  std::filesystem::remove(folder_ / "tradeoff.study.toml");
  WriteReport(folder_);
  EXPECT_THAT(Page(),
              AllOf(HasSubstr("2 choices in 1 stages were run"),
                    HasSubstr("Covariance: leberl is 250 times as fast"),
                    testing::Not(HasSubstr("montecarlo,  looks"))));
  std::filesystem::remove(folder_ / "tradeoff.csv");
  Put("stability.csv",
      "family,parameter,value,condition,outcome,covariance_digits,position_digits,message\n"
      "thin,angle_deg,0.5,1e6,ok,9.5,10,\nthin,angle_deg,1e-4,1e14,wrong,0.5,2,\n");
  Put("plot.svg", "<svg xmlns='http://www.w3.org/2000/svg'/>");
  EXPECT_EQ(WriteReport(folder_).verdict, "Wrong answers were given");
  EXPECT_THAT(Page(), HasSubstr("data:image/svg+xml;base64,PHN2ZyB4bWxucz0n"));
}

TEST_F(ReportFileTest, ShowsDesignsWithTheirGoalsAndCost) {
  const std::string head =
      "axis_1,value_1,number_1,axis_2,value_2,median_sigma_along_m,median_sigma_across_m,"
      "median_sigma_up_m,max_sigma_along_m,max_sigma_across_m,max_sigma_up_m,cost,reached,pareto,"
      "determined,message\n";
  Put("design.csv",
      head +
          "look,25,25,,,1,2,3,1.5,2.5,20.1,1000,0,1,1,\n"
          "look,30,30,,,1,2,3,1.5,2.5,9.25,1500,1,1,1,\n"
          "look,35,35,,,1,2,3,1.5,2.5,9.5,2000,1,0,1,\n"
          "look,89,89,,,,,,,,,,0,0,0,no orbit sees it\n");
  const ReportFile report = WriteReport(folder_);
  EXPECT_EQ(report.kind, "design");
  EXPECT_EQ(report.verdict, "2 of 4 designs reach the goals");
  EXPECT_THAT(Page(),
              AllOf(HasSubstr("\"id\":\"design-sweep\""),
                    HasSubstr("\"id\":\"design-cost\""),
                    HasSubstr("1 designs give no block that is determined"),
                    HasSubstr("9.25 m"),
                    HasSubstr("look 30"),
                    HasSubstr(">1500<"),
                    HasSubstr("no orbit sees it")));
  Put("design.csv", head + "look,25,25,height,700,1,2,3,1.5,2.5,20.1,,,,1,\n");
  EXPECT_EQ(WriteReport(folder_).verdict, "Designs compared");
  EXPECT_THAT(Page(),
              AllOf(Not(HasSubstr("design-sweep")),
                    Not(HasSubstr("design-cost")),
                    HasSubstr("look 25, height 700")));
}

}  // namespace
}  // namespace sarblock
