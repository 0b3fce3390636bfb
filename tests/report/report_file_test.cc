// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/report/report.h"

#include <cmath>
#include <sstream>

#include "io/io_fixture.h"
#include "report/result_folder.h"
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
  "frame": {"kind": "local"}, "status": "converged", "accepted": true,
  "counts": {"passes": 2, "points": 3, "looks": 5, "redundancy": 7.0, "point_status": {"adjusted": 2}},
  "iterations": 4, "sigma0_squared": 1.5, "condition": null,
  "chi_square": {"value": 10.5, "lower": 2.5, "upper": 17.5, "level": 0.975, "passed": true},
  "quality": {"alpha_one": 0.001, "critical_w": 3.29, "tests": 10, "expected_above": 0.01,
    "above_critical": {"range": 1, "azimuth": 0, "control": 0}},
  "stages": {"solve": {"wall_s": 0.25, "peak_mib": 80.5}},
  "warnings": ["</script><script>alert(1)</script>"],
  "inputs": [{"file": "block.toml", "bytes": 120, "sha256": "00ff"}],
  "configuration": {"robust": "none", "correction": {"range": {"bias": true}}}
})";

class ReportFileTest : public test::FolderTest {
 protected:
  std::string Page(const std::string& name = "report.html") const {
    return Content(folder_ / name);
  }
  void PutResult() const {
    Put("summary.json", kSummary);
    Put("points.csv",
        "point,role,status,looks,x_m,y_m,z_m,sigma_e_m,sigma_n_m,sigma_u_m,cov_en_m2,intersection_"
        "deg,"
        "error_e_m,error_n_m,error_u_m,chi_square_3,error_sigma_e_m,error_sigma_n_m,error_sigma_u_"
        "m,"
        "reason\n"
        "P1,tie,adjusted,2,0,0,5,1.5,2.5,3.5,0,12,,,,,,,,\n"
        "\"</td><i>P2\",check,adjusted,3,4000,3000,5,1,2,3,0,15,0.5,-0.25,1.5,1.25,2,2,3,\n"
        "P3,tie,too-few-looks,1,,,,,,,,,,,,,,,,one look\n");
    Put("passes.csv",
        "pass,parameter,unit,value,sigma,prior_sigma,significance,kept\n"
        "A,range.bias,m,5,0.5,10,10,\nB,range.bias,m,2,0.25,,8,\n");
    Put("passes_covariance.csv",
        "pass_a,parameter_a,pass_b,parameter_b,covariance\nA,range.bias,A,range.bias,0.25\n"
        "A,range.bias,B,range.bias,0.12\nB,range.bias,B,range.bias,0.0625\n");
    Put("residuals.csv",
        "pass,point,range_residual_m,azimuth_residual_m,range_redundancy,azimuth_redundancy,range_"
        "w,"
        "azimuth_w,range_mdb_m,azimuth_mdb_m,range_influence_m,azimuth_influence_m,weight,rejected,"
        "reason\n"
        "A,P1,0.5,-0.25,0.5,0.25,1.5,-0.75,4,5,6,7,1,0,\nB,P1,1,1,0.5,0.5,-4.25,2,4,5,6,7,1,0,\n"
        "B,P3,77.5,1,,,,,,,,,0,1,given\n");
  }
};

TEST_F(ReportFileTest, ReadsWhatAResultFolderHolds) {
  PutResult();
  const ResultFolder result = ReadResultFolder(folder_);
  EXPECT_EQ(result.summary.block, "a <b>block</b>");
  EXPECT_EQ(result.summary.Count("looks"), 5.0);
  EXPECT_EQ(result.summary.test.upper, 17.5);
  EXPECT_TRUE(std::isnan(result.summary.condition));
  EXPECT_EQ(result.summary.configuration.back().first, "correction.range.bias");
  ASSERT_EQ(result.points.size(), 3u);
  EXPECT_EQ(result.points.sigma_m[0][2], 3.5F);
  EXPECT_EQ(result.points.unsolved_count, 1u);
  EXPECT_EQ(result.points.unsolved[0].reason, "one look");
  ASSERT_EQ(result.points.checks.size(), 1u);
  EXPECT_THAT(result.points.checks[0].error_m, ElementsAre(0.5, -0.25, 1.5));
  // 0.12 / (0.5 0.25)
  ASSERT_EQ(result.correlation_count, 1u);
  EXPECT_NEAR(result.correlations[0].correlation_1, 0.96, 1e-15);
  EXPECT_EQ(result.looks.count, 3u);
  EXPECT_EQ(result.looks.rejected, 1u);
  ASSERT_EQ(result.looks.worst.size(), 4u);
  EXPECT_EQ(result.looks.worst[0].w_1, -4.25);
  EXPECT_EQ(result.looks.worst[1].w_1, 2.0);
  EXPECT_TRUE(result.looks.worst[1].azimuth);
  EXPECT_EQ(result.looks.left_out[0].residual_m, 77.5);
}

TEST_F(ReportFileTest, HoldsTheVerdictTheTablesAndTheChartLibraryAndNothingFromElsewhere) {
  PutResult();
  const ReportFile report = WriteReport(folder_);
  EXPECT_EQ(report.kind, "result");
  EXPECT_EQ(report.verdict, "Accepted, with reservations");  // a point is missing
  const std::string page = Page();
  EXPECT_EQ(page.size(), report.bytes);
  EXPECT_THAT(
      page,
      AllOf(HasSubstr("Chart.js v3"),
            HasSubstr("The MIT License"),
            HasSubstr("<td>A range.bias</td><td>B range.bias</td><td class=\"n\">+0.9600</td>"),
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

TEST_F(ReportFileTest, SaysWhatAResultWithoutTablesLacks) {
  Put("summary.json",
      R"({"format": "sarblock-result 1", "command": "predict", "status": "predicted"})");
  EXPECT_EQ(WriteReport(folder_).verdict, "Predicted");
  EXPECT_THAT(Page(),
              AllOf(HasSubstr("A prediction has no residuals"),
                    HasSubstr("No point has a position"),
                    HasSubstr("No corrections were estimated"),
                    HasSubstr("There are no control points")));
}

TEST_F(ReportFileTest, AHundredThousandPointsStayBelowFiveMegabytesWithANote) {
  Put("summary.json", kSummary);
  std::ostringstream points, looks;
  points << "point,role,status,looks,x_m,y_m,z_m,sigma_e_m,sigma_n_m,sigma_u_m,cov_en_m2,"
            "intersection_deg\n";
  looks << "pass,point,range_residual_m,azimuth_residual_m,range_w,azimuth_w\n";
  for (int i = 0; i < 100000; ++i) {
    const double x = 0.137 * i, y = 0.731 * (i % 1009);
    points << "POINT-" << i << ",tie,adjusted,3," << x << ',' << y << ",1,0." << 100 + i % 777
           << ",0.5,1." << i % 991 << ",0.01,11.25\n";
    looks << "PASS-" << i % 40 << ",POINT-" << i << ",0.5,0.25," << 0.001 * (i % 3001) << ",-1.5\n";
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
  EXPECT_THAT(test::MessageOf<InputError>(report), HasSubstr("'sarblock-scene 1' is not allowed"));
  Put("summary.json", "{");
  EXPECT_THAT(test::MessageOf<InputError>(report), HasSubstr("is no JSON"));
  EXPECT_THAT(test::MessageOf<InputError>([&] { return WriteReport(folder_ / "none").bytes; }),
              HasSubstr("is no folder"));
}

TEST_F(ReportFileTest, SetsTwoResultsSideBySide) {
  PutResult();
  std::filesystem::create_directory(folder_ / "b");
  for (const char* name : {"points.csv", "passes.csv"}) {
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
                    HasSubstr("1 settings and 0 input files differ")));
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
            HasSubstr("\"id\":\"densification-u\"")));
  std::filesystem::remove(folder_ / "densification.csv");
  Put("tradeoff.csv",
      "stage,choice,looks,wall_s,speed_ratio,position_error_sigma,covariance_error,pareto\n"
      "covariance,montecarlo,,,,,,0\n"
      "covariance,block,900,2.5,1,0,0,1\ncovariance,leberl,900,0.01,250,0,0.5,1\n");
  EXPECT_EQ(WriteReport(folder_).kind, "tradeoff");
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

}  // namespace
}  // namespace sarblock
