// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "report/made_result.h"
#include "report/shown_result.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// Points whose y is weakest, `path_part` of its variance from the paths, seen by one pass that
/// flies `east_m`, `north_m` from its first to its last station.
ResultFolder WeakNorth(double path_part, double east_m, double north_m, double angle_deg) {
  std::vector<test::MadePoint> points;
  for (int i = 0; i < 9; ++i) {
    const double sigma_m = 2.0 + 0.03125 * i;
    const double control_m = sigma_m * std::sqrt(1.0 - path_part);
    points.push_back({.id = "P" + std::to_string(i),
                      .position_m = {137.0 * i, 29.0 * i, 3.0},
                      .sigma_m = {1.0, sigma_m, 0.75},
                      .fixed_path_sigma_m = {0.5, control_m, 0.5},
                      .angle_deg = angle_deg});
  }
  files::ResultFile file;
  for (const test::MadePoint& point : points) test::AddPoint(point, &file.points);
  file.passes.emplace_back().id = "A";
  for (const double part : {0.0, 0.5, 1.0}) {
    StripStation station;
    station.antenna_m = {part * east_m - 4000.0, part * north_m - 300.0, 9000.0};
    station.time_s = 40.0 * part;
    file.strips.push_back(station);
  }
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    file.looks.pass.push_back(0);
    file.looks.point.push_back(i);
    file.looks.range_residual_m.push_back(0.0);
    file.looks.azimuth_residual_m.push_back(0.0);
    file.looks.rejected.push_back(0);
  }
  return Arrange("made", std::move(file));
}

Advice Given(const ResultFolder& result) {
  return AdviceOf(DescribeAccuracy(result), result.file.frame);
}

TEST(AdviceTest, AnAlongTrackWeaknessAsksForAzimuthAccuracyAndNotForAngles) {
  // 300 m east on 5000 m north: cos^2 = 0.996.
  const ResultFolder result = WeakNorth(0.25, 300.0, 5000.0, 77.0);
  EXPECT_NEAR(DescribeAccuracy(result).along_track, 25.0 / 25.09, 1e-12);
  const Advice advice = Given(result);
  EXPECT_THAT(advice.sentence,
              AllOf(HasSubstr("y (along track): 25 % of its variance comes from the flight paths"),
                    HasSubstr("more accurate azimuths"),
                    Not(HasSubstr("angle"))));
  EXPECT_EQ(advice.would_help, "azimuth accuracy, more looks");
}

TEST(AdviceTest, AnAcrossTrackWeaknessAsksForAnglesWhereTheyAreSmall) {
  const Advice narrow = Given(WeakNorth(0.25, 5000.0, 300.0, 12.5));
  EXPECT_THAT(narrow.sentence,
              AllOf(HasSubstr("y (across track)"),
                    HasSubstr("larger intersection angles (the median is 12.5 degrees), more looks "
                              "per point or more accurate ranges"),
                    Not(HasSubstr("azimuth"))));
  const Advice wide = Given(WeakNorth(0.25, 5000.0, 300.0, 77.0));
  EXPECT_THAT(wide.sentence, Not(HasSubstr("angle")));
  EXPECT_EQ(wide.would_help, "more and better ranges");
}

TEST(AdviceTest, CrossingTracksAskForBoth) {
  EXPECT_EQ(Given(WeakNorth(0.25, 3000.0, 3000.0, 30.0)).would_help,
            "azimuth and range accuracy, more looks");
}

TEST(AdviceTest, PartsOfThePathsAskForControl) {
  EXPECT_EQ(Given(WeakNorth(0.75, 300.0, 5000.0, 30.0)).would_help, "control, better paths");
  EXPECT_EQ(Given(WeakNorth(0.5, 300.0, 5000.0, 30.0)).would_help,
            "control, and azimuth accuracy, more looks");
}

TEST(AdviceTest, PointsThatControlOrOneLookDecideAdviseNothing) {
  ResultFolder result = WeakNorth(0.25, 300.0, 5000.0, 30.0);
  for (std::size_t i = 0; i < result.file.points.size(); ++i) {
    if (i % 2 == 0) result.file.points.role[i] = PointRole::kControl;
    if (i % 2 == 1) result.file.points.results.looks[i] = 1;
  }
  const Advice advice = Given(result);
  EXPECT_EQ(advice.would_help, "");
  EXPECT_EQ(advice.sentence, "");
  EXPECT_THAT(HeadlineOf(result, DescribeAccuracy(result)).sentences,
              testing::Contains(HasSubstr("Control or a single look decides every point, so the "
                                          "standard deviations (in the median 1.00 m in x")));
  // One point that geometry decides is advised for.
  result.file.points.results.looks[3] = 2;
  EXPECT_EQ(Given(result).would_help, "azimuth accuracy, more looks");
  EXPECT_EQ(DescribeAccuracy(result).free_points, 1u);
}

TEST(AdviceTest, WithoutFlightPathsTheDirectionIsNotClaimed) {
  ResultFolder result = WeakNorth(0.25, 300.0, 5000.0, 30.0);
  result.file.strips.clear();
  EXPECT_THAT(Given(result).sentence, Not(HasSubstr("track")));
}

}  // namespace
}  // namespace sarblock
