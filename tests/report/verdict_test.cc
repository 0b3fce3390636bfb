// SPDX-License-Identifier: Apache-2.0
#include "report/verdict.h"

#include <algorithm>
#include <cmath>

#include "report/made_result.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

Verdict Judge(const ResultFolder& result) { return JudgeResult(result, DescribeAccuracy(result)); }

std::string Words(const Verdict& verdict) {
  std::string text;
  for (const std::string& sentence : verdict.sentences) text += sentence + " ";
  return text;
}

TEST(AccuracyTest, TellsMediansTheWeakestPointAndWhatLimitsIt) {  // hand values of MadeResult
  const AccuracyFigures a = DescribeAccuracy(test::MadeResult());
  EXPECT_EQ(a.points, 100u);
  EXPECT_EQ(a.median_m[0], 1.0);
  EXPECT_EQ(a.median_m[1], 1.25);
  EXPECT_NEAR(a.median_m[2], 3.495, 1e-6);
  EXPECT_EQ(a.largest_m[2], 108.0);
  EXPECT_EQ(a.largest_point[2], "P99");
  EXPECT_EQ(a.weakest, 2);
  EXPECT_NEAR(a.path_part_1, 0.75, 1e-6);  // held is half the sigma
  EXPECT_EQ(a.weak.points, 5u);
  EXPECT_NEAR(a.weak.median_intersection_deg, 4.0, 1e-14);
  EXPECT_EQ(a.weak.median_looks_1, 2.0);
  EXPECT_EQ(a.weak.outside_control_1, 1.0);
  EXPECT_EQ(a.all.median_looks_1, 3.0);
}

TEST(VerdictTest, AnAcceptedBlockSaysSoWithItsAccuracyAndItsLimit) {
  const Verdict verdict = Judge(test::MadeResult());
  EXPECT_EQ(verdict.state, VerdictState::kAccepted);
  EXPECT_EQ(verdict.word, "Accepted");
  const std::string text = Words(verdict);
  EXPECT_THAT(text, HasSubstr("converged in 5 iterations and is accepted"));
  EXPECT_THAT(text, HasSubstr("variance factor 1.10, 0.810 to 1.20 allowed at 95 %"));
  EXPECT_THAT(text, HasSubstr("the weakest is P99 with 108 m in z"));
  EXPECT_THAT(text,
              HasSubstr("in z, the weakest component, 75 % of the variance comes from the flight"));
  EXPECT_THAT(text, HasSubstr("control points or better paths"));
  EXPECT_THAT(text, HasSubstr("have 2 looks where 3 are usual"));
  EXPECT_THAT(text, HasSubstr("There are no check points"));
  EXPECT_THAT(verdict.attention, IsEmpty());
}

TEST(VerdictTest, AFailedGlobalTestIsAReservationThatSaysHowMuch) {
  ResultFolder result = test::MadeResult();
  result.file.summary.chi_square = {4.0, 200.0, 162.0, 240.0, 0.95, false};
  const Verdict worse = Judge(result);
  EXPECT_EQ(worse.state, VerdictState::kReservations);
  EXPECT_THAT(Words(worse), HasSubstr("fit worse than their standard deviations promise"));
  EXPECT_THAT(Words(worse), HasSubstr("2.00 times as large"));
  EXPECT_THAT(Words(worse), HasSubstr("too small by about this factor"));
  result.file.summary.chi_square->sigma0_squared = 0.25;
  EXPECT_THAT(Words(Judge(result)), HasSubstr("fit better than"));
}

TEST(VerdictTest, NotConvergedIsNotAccepted) {
  ResultFolder result = test::MadeResult();
  result.file.summary.status = "not_converged";
  result.file.summary.accepted = false;
  result.file.summary.remaining_step = 2.5;
  const Verdict verdict = Judge(result);
  EXPECT_EQ(verdict.state, VerdictState::kNotAccepted);
  EXPECT_THAT(verdict.word, HasSubstr("Not accepted"));
  EXPECT_THAT(Words(verdict), HasSubstr("a step of 2.50 sigma was still to go"));
}

TEST(VerdictTest, StrictRefusalNamesItsReason) {
  ResultFolder result = test::MadeResult();
  result.file.summary.accepted = false;
  EXPECT_EQ(Judge(result).word, "Not accepted");
  EXPECT_THAT(Words(Judge(result)), HasSubstr("--strict"));
}

TEST(VerdictTest, UnrealisticCheckPointsAndMissingPointsAreReservations) {
  ResultFolder checks = test::MadeResult();
  checks.file.summary.checks = ResultChecks{9, 27, 2.5, false, "The predicted accuracy is not."};
  EXPECT_EQ(Judge(checks).state, VerdictState::kReservations);
  EXPECT_THAT(Judge(checks).attention, Contains(HasSubstr("2.50 times as large as predicted")));
  EXPECT_THAT(Words(Judge(checks)), HasSubstr("9 check points: the predicted accuracy is not."));
  ResultFolder missing = test::MadeResult();
  test::AddPoint({.id = "lost", .solved = false}, &missing.file.points);
  missing = Arrange("made", missing.file);
  EXPECT_EQ(Judge(missing).state, VerdictState::kReservations);
  EXPECT_THAT(Judge(missing).attention, Contains(HasSubstr("1 point could not be determined")));
}

TEST(VerdictTest, BlundersBeyondChanceAreCalledOut) {
  ResultFolder result = test::MadeResult();
  result.file.summary.tests.emplace();
  result.file.summary.tests->expected_above_1 = 4.0;
  result.file.summary.tests->above = {6, 4, 0};  // 4 + 3 sqrt(4) = 10 is still chance
  EXPECT_THAT(Judge(result).attention, IsEmpty());
  result.file.summary.tests->above[2] = 1;
  EXPECT_THAT(Judge(result).attention, Contains(HasSubstr("11 observations stand beyond")));
}

TEST(VerdictTest, APredictionHasNothingToAccept) {
  ResultFolder result = test::MadeResult();
  result.file.summary.command = "predict";
  result.file.summary.status = "predicted";
  result.file.summary.chi_square.reset();
  const Verdict verdict = Judge(result);
  EXPECT_EQ(verdict.state, VerdictState::kNeutral);
  EXPECT_EQ(verdict.word, "Predicted");
  EXPECT_THAT(Words(verdict), Not(HasSubstr("variance factor")));
}

TEST(VerdictTest, WithoutACovarianceNothingIsClaimed) {
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
  EXPECT_EQ(plane.middle(), "0.0000, 22.9183");
}

}  // namespace
}  // namespace sarblock
