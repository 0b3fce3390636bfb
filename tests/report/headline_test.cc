// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "report/made_result.h"
#include "report/shown_result.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

Headline Judge(const ResultFolder& result) { return HeadlineOf(result, DescribeAccuracy(result)); }

std::string Words(const Headline& headline) {
  std::string text;
  for (const std::string& sentence : headline.sentences) text += sentence + " ";
  return text;
}

TEST(AccuracyTest, GivesMediansTheWeakestPointAndWhatLimitsIt) {  // hand values of MadeResult
  const AccuracyFigures a = DescribeAccuracy(test::MadeResult());
  EXPECT_EQ(a.points, 100u);
  EXPECT_EQ(a.median_m[0], 1.0);
  EXPECT_EQ(a.median_m[1], 1.25);
  EXPECT_NEAR(a.median_m[2], 3.495, 1e-6);
  EXPECT_EQ(a.largest_m[2], 108.0);
  EXPECT_EQ(a.largest_point[2], "P99");
  EXPECT_EQ(a.weakest, 2);
  EXPECT_NEAR(a.path_part, 0.75, 1e-6);  // held is half the sigma
  EXPECT_EQ(a.free_points, 97u);         // three are control
  EXPECT_EQ(a.weak.points, 4u);
  EXPECT_NEAR(a.weak.median_intersection_deg, 4.0, 1e-14);
  EXPECT_EQ(a.weak.median_looks, 2.0);
  EXPECT_EQ(a.weak.outside_control, 1.0);
  EXPECT_EQ(a.all.median_looks, 3.0);
}

TEST(HeadlineTest, AnAcceptedBlockSaysSoWithItsAccuracyAndItsLimit) {
  const Headline headline = Judge(test::MadeResult());
  EXPECT_EQ(headline.state, HeadlineState::kAccepted);
  EXPECT_EQ(headline.word, "Accepted");
  const std::string text = Words(headline);
  EXPECT_EQ(headline.sentences.size(), 3u);
  EXPECT_THAT(text, HasSubstr("converged in 5 iterations and every test is passed; without check"));
  EXPECT_THAT(text, HasSubstr("Half of the 100 points are known to 1.00 m in x"));
  EXPECT_THAT(text, HasSubstr("the weakest is P99 with 108 m in z"));
  EXPECT_THAT(text,
              HasSubstr("The weakest component is z: 75 % of its variance comes from the flight"));
  EXPECT_THAT(text, HasSubstr("so control points or better flight paths would help most"));
  EXPECT_EQ(headline.would_help, "control, better paths");
  EXPECT_THAT(headline.attention, IsEmpty());
}

TEST(HeadlineTest, AFailedGlobalTestSaysHowMuchAndItsReasonHeadsTheList) {
  ResultFolder result = test::MadeResult();
  result.file.summary.chi_square = {{4.0, 200.0, {162.0, 240.0}, false}, 0.95};
  result.file.summary.verdict = Verdict::kTestsFailed;
  result.file.summary.verdict_reasons = {"global test: s0^2 is 4"};
  result.file.summary.warnings = {"a warning"};
  const Headline worse = Judge(result);
  EXPECT_EQ(worse.state, HeadlineState::kTestsFailed);
  EXPECT_EQ(worse.word, "Converged, tests failed");
  EXPECT_THAT(Words(worse), HasSubstr("residuals are 2.00 times as large as stated"));
  EXPECT_THAT(Words(worse), HasSubstr("too small by about this factor"));
  EXPECT_EQ(worse.attention.front(), "global test: s0^2 is 4.");
  result.file.summary.chi_square->sigma0_squared = 0.25;
  EXPECT_THAT(Words(Judge(result)), HasSubstr("standard deviations may be too large"));
}

TEST(HeadlineTest, NotConvergedIsNotAccepted) {
  ResultFolder result = test::MadeResult();
  result.file.summary.status = "not_converged";
  result.file.summary.verdict = Verdict::kNotAccepted;
  result.file.summary.remaining_step = 2.5;
  const Headline headline = Judge(result);
  EXPECT_EQ(headline.state, HeadlineState::kNotAccepted);
  EXPECT_EQ(headline.word, "Not accepted: not converged");
  EXPECT_THAT(Words(headline), HasSubstr("the Newton decrement was 2.50 sigma"));
}

TEST(HeadlineTest, GrossContradictionsAreNotAcceptedForTheReasonThatTheResultGives) {
  ResultFolder result = test::MadeResult();
  result.file.summary.verdict = Verdict::kNotAccepted;
  result.file.summary.verdict_reasons = {"s0^2 is 1.4e7 where 1 is expected"};
  const Headline headline = Judge(result);
  EXPECT_EQ(headline.word, "Not accepted");
  EXPECT_THAT(Words(headline), HasSubstr("standard deviations mean nothing"));
  EXPECT_EQ(headline.would_help, "");
  EXPECT_THAT(headline.attention, Contains(HasSubstr("1.4e7")));
}

TEST(HeadlineTest, AnIntersectionRepeatsTheVerdictOfItsResult) {
  ResultFolder result = test::MadeResult();
  result.file.summary.command = "intersect";
  result.file.summary.status = "intersected";
  result.file.summary.verdict = Verdict::kTestsFailed;
  const Headline headline = Judge(result);
  EXPECT_EQ(headline.word, "Intersected, tests failed");
  EXPECT_EQ(headline.state, HeadlineState::kTestsFailed);
}

TEST(HeadlineTest, CheckPointsThatAgreeAreNamedWithTheVerdict) {
  ResultFolder result = test::MadeResult();
  result.file.summary.checks =
      files::ResultChecks{12, 36, 1.02, true, "the predicted accuracy holds"};
  EXPECT_THAT(Words(Judge(result)), HasSubstr("; 12 check points agree with the predicted"));
  result.file.summary.checks->realistic = false;
  EXPECT_THAT(Words(Judge(result)), Not(HasSubstr("check points")));
}

TEST(HeadlineTest, MissingPointsAreCounted) {
  ResultFolder missing = test::MadeResult();
  test::AddPoint({.id = "lost", .solved = false}, &missing.file.points);
  missing = Arrange("made", missing.file);
  EXPECT_EQ(Judge(missing).state, HeadlineState::kAccepted);
  EXPECT_THAT(Judge(missing).attention, Contains(HasSubstr("1 point could not be determined")));
}

TEST(HeadlineTest, APredictionHasNothingToAccept) {
  ResultFolder result = test::MadeResult();
  result.file.summary.command = "predict";
  result.file.summary.status = "predicted";
  result.file.summary.chi_square.reset();
  const Headline headline = Judge(result);
  EXPECT_EQ(headline.state, HeadlineState::kNeutral);
  EXPECT_EQ(headline.word, "Predicted");
  EXPECT_THAT(Words(headline), Not(HasSubstr("variance factor")));
}

TEST(HeadlineTest, WithoutACovarianceNothingIsClaimed) {
  ResultFolder result = test::MadeResult();
  result.file.points.results.covariance_m2.clear();
  EXPECT_THAT(Words(Judge(result)), HasSubstr("nothing can be said of the accuracy"));
}

TEST(MapPlaneTest, PlacesGeocentricPointsEastAndNorthOfTheirMiddle) {
  // Two points on the equator of a sphere of 1000 m, 0.02 rad apart: 20 m by the arc, by the chord
  // from the tangent plane 1000 sin(0.01) to each side.
  std::vector<test::MadePoint> points;
  for (const double lon_rad : {0.39, 0.41}) {
    points.push_back({.id = "P" + std::to_string(lon_rad),
                      .position_m = {1000.0 * std::cos(lon_rad), 1000.0 * std::sin(lon_rad), 0.0}});
  }
  ResultFolder result = test::MadeOf(points);
  result.file.frame = Frame::Geocentric({"", 1000.0, 0.0});
  const MapPlane plane(result);
  const auto west = plane.Place(result.file.points.results.position_m[0]);
  const auto east = plane.Place(result.file.points.results.position_m[1]);
  EXPECT_NEAR(west[0], -1000.0 * std::sin(0.01), 1e-9);
  EXPECT_NEAR(east[0], 1000.0 * std::sin(0.01), 1e-9);
  EXPECT_NEAR(east[1], 0.0, 1e-9);
  EXPECT_EQ(plane.middle(), "0.0000, 22.9183");  // 0.4 rad
}

}  // namespace
}  // namespace sarblock
