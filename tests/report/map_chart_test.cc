// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "report/made_result.h"
#include "report/result_page.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

std::vector<std::string> NamesOf(const std::vector<MapChart::Line>& lines) {
  std::vector<std::string> names;
  for (const MapChart::Line& line : lines) names.push_back(line.name);
  return names;
}

TEST(BlockMapTest, ColoursRunFromThe2ndToThe98thPercentileOfPointsThatAreNotControl) {
  // 101 tie points with sigmas 1.00 to 2.00 m up, and control held at a micrometre.
  std::vector<test::MadePoint> points;
  for (int i = 0; i <= 100; ++i) {
    points.push_back({.id = "T" + std::to_string(i),
                      .position_m = {41.0 * i, 17.0 * (i % 7), 0.0},
                      .sigma_m = {0.25, 0.5, 1.0 + 0.01 * i}});
  }
  for (int i = 0; i < 40; ++i) {
    points.push_back({.id = "C" + std::to_string(i),
                      .position_m = {43.0 * i, 55.0, 0.0},
                      .sigma_m = {1e-6, 1e-6, 1e-6},
                      .role = PointRole::kControl});
  }
  const ResultFolder result = test::MadeOf(points);
  const BlockMap map = MapOf(result, DescribeAccuracy(result));
  ASSERT_THAT(map.chart.values, SizeIs(4));
  EXPECT_EQ(map.chart.shown, 2u);
  const MapChart::Value& up = map.chart.values[2];
  EXPECT_EQ(up.label, "sigma z [m]");
  EXPECT_NEAR(up.low, 1.02, 1e-9);
  EXPECT_NEAR(up.high, 1.98, 1e-9);
  EXPECT_NEAR(up.least, 1.0, 1e-9);
  EXPECT_NEAR(up.most, 2.0, 1e-9);
  EXPECT_THAT(map.chart.points, SizeIs(141));
  EXPECT_THAT(map.chart.ellipses, SizeIs(101));  // none of control
  EXPECT_THAT(map.chart.graticule, IsEmpty());   // a local frame
}

TEST(BlockMapTest, PointsThatAreAllFixedHaveNoEllipses) {
  std::vector<test::MadePoint> points;
  for (int i = 0; i < 5; ++i) {
    points.push_back({.id = "H" + std::to_string(i),
                      .position_m = {7000.0 * i, 900.0 * (i % 2), 0.0},
                      .sigma_m = {1e-6, 1e-6, 1e-6},
                      .role = PointRole::kControl});
  }
  const ResultFolder result = test::MadeOf(points);
  const BlockMap map = MapOf(result, DescribeAccuracy(result));
  EXPECT_THAT(map.chart.ellipses, IsEmpty());
  EXPECT_THAT(map.chart.points, SizeIs(5));
  EXPECT_EQ(map.chart.unit, "km");
}

TEST(GraticuleTest, NamesRoundDegreesAcrossTheBlock) {
  // A sphere of 6371 km: a degree of latitude is 111.2 km, of longitude at 45 degrees 78.6 km.
  std::vector<test::MadePoint> points;
  const Frame frame = Frame::Geocentric({"", 6371000.0, 0.0});
  for (const double lat_deg : {45.1, 45.9}) {
    for (const double lon_deg : {-0.3, 0.9}) {
      const Geodetic place{lat_deg * kRadPerDeg, lon_deg * kRadPerDeg, 20.0};
      points.push_back({.id = "P" + std::to_string(points.size()),
                        .position_m = frame.FrameFromGeodetic(place)});
    }
  }
  ResultFolder result = test::MadeOf(points);
  result.file.frame = frame;
  const MapPlane plane(result);
  const auto lines = GraticuleOf(frame,
                                 plane,
                                 {{-45000.0, -45000.0}, {45000.0, 45000.0}},
                                 {{-145000.0, -145000.0}, {145000.0, 145000.0}});
  EXPECT_THAT(NamesOf(lines), Contains("45.4\xc2\xb0 N"));
  EXPECT_THAT(NamesOf(lines), Contains("0.2\xc2\xb0 W"));
  EXPECT_THAT(NamesOf(lines), Contains("0\xc2\xb0"));
  // The point of a line at its degrees: half a millidegree is 55 m.
  const auto parallel = std::find_if(lines.begin(), lines.end(), [](const MapChart::Line& line) {
    return line.name == "45.4\xc2\xb0 N";
  });
  for (const auto& place_m : parallel->places) {
    const Geodetic at = frame.GeodeticFromFrame(plane.PositionAt(place_m));
    EXPECT_NEAR(at.lat_rad * kDegPerRad, 45.4, 5e-4);
  }
}

/// Lines of one family that enter a box.
std::size_t CountIn(const std::vector<MapChart::Line>& lines,
                    const MapBox& box,
                    const std::string& directions) {
  return static_cast<std::size_t>(
      std::count_if(lines.begin(), lines.end(), [&](const MapChart::Line& line) {
        return directions.find(line.name.back()) != std::string::npos &&
               std::any_of(line.places.begin(), line.places.end(), [&](const auto& at_m) {
                 return at_m[0] >= box.low_m[0] && at_m[0] <= box.high_m[0] &&
                        at_m[1] >= box.low_m[1] && at_m[1] <= box.high_m[1];
               });
      }));
}

TEST(GraticuleTest, ThreeToEightLinesOfEachKindCrossWhatTheMapShows) {
  const Frame frame = Frame::Geocentric({"", 6371000.0, 0.0});
  for (const double lat_deg : {5.3, 45.7, 78.2, -61.9}) {
    for (const double half_m : {930.0, 7700.0, 31000.0, 88000.0}) {
      const Geodetic place{lat_deg * kRadPerDeg, 179.9 * kRadPerDeg, 20.0};
      ResultFolder result =
          test::MadeOf({{.id = "P", .position_m = frame.FrameFromGeodetic(place)}});
      result.file.frame = frame;
      const MapBox seen{{-half_m, -0.65 * half_m}, {half_m, 0.65 * half_m}};
      const auto lines = GraticuleOf(frame, MapPlane(result), seen, seen.Widened(2.4 * half_m));
      for (const char* directions : {"NS", "EW"}) {
        const std::size_t count = CountIn(lines, seen, directions);
        EXPECT_GE(count, 3u) << directions << lat_deg << ", " << half_m;
        EXPECT_LE(count, 8u) << directions << lat_deg << ", " << half_m;
      }
    }
  }
}

/// Three stations of a squinted pass over 40 s: the line from near to far ground is turned by the
/// squint, so that a place is looked at before the antenna is beside it.
ResultFolder Squinted() {
  files::ResultFile file;
  file.passes.emplace_back().id = "A";
  for (const double time_s : {0.0, 20.0, 40.0}) {
    StripStation station;
    station.time_s = time_s;
    station.strip_time = time_s / 20.0 - 1.0;
    station.antenna_m = {100.0 * time_s, 0.0, 9000.0};
    station.near_m = {100.0 * time_s + 300.0, 3000.0, 0.0};
    station.far_m = {100.0 * time_s + 600.0, 6000.0, 0.0};
    file.strips.push_back(station);
  }
  // On the line of 30 s at 5000 m: x = 3000 + 500; on that of 5 s at 4000 m: x = 500 + 400.
  const std::array<Eigen::Vector3d, 3> places{
      Eigen::Vector3d(3500.0, 5000.0, 0.0), {900.0, 4000.0, 0.0}, {99000.0, 4000.0, 0.0}};
  for (std::uint32_t i = 0; i < 3; ++i) {
    test::AddPoint({.id = "P" + std::to_string(i), .position_m = places[i]}, &file.points);
    file.looks.pass.push_back(0);
    file.looks.point.push_back(i);
    file.looks.range_residual_m.push_back(1.25 + i);
    file.looks.azimuth_residual_m.push_back(-0.5);
    file.looks.rejected.push_back(0);
  }
  return Arrange("made", std::move(file));
}

TEST(StripResidualsTest, AreAtTheTimeAtWhichTheSwathPassesOverThePoint) {
  const ResultFolder result = Squinted();
  const std::vector<StripResiduals> strips = ResidualsAlongStrips(result);
  ASSERT_THAT(strips, SizeIs(1));
  ASSERT_THAT(strips[0].looks, ElementsAre(0, 1));  // the third is far off the strip
  EXPECT_NEAR(strips[0].time_s[0], 30.0, 1e-9);
  EXPECT_NEAR(strips[0].time_s[1], 5.0, 1e-9);
  EXPECT_THAT(strips[0].residual_m[0], ElementsAre(1.25, 2.25));
  EXPECT_THAT(strips[0].residual_m[1], ElementsAre(-0.5, -0.5));
}

TEST(StripResidualsTest, WithoutASwathTheTimeIsThatBesideTheAntenna) {
  ResultFolder result = Squinted();
  for (StripStation& station : result.file.strips) {
    station.near_m = station.far_m = Eigen::Vector3d::Constant(kNotGiven);
  }
  EXPECT_NEAR(ResidualsAlongStrips(result)[0].time_s[0], 35.0, 1e-9);
}

TEST(StripResidualsTest, ASlopeIsATrendAndScatterIsNone) {
  StripResiduals strip;
  for (int i = 0; i < 40; ++i) {
    strip.time_s.push_back(i);
    strip.residual_m[0].push_back(i % 2 == 0 ? 0.5 : -0.5);
    strip.residual_m[1].push_back(0.0);
  }
  EXPECT_LT(strip.Trend(), 1.0);
  for (int i = 0; i < 40; ++i) strip.residual_m[1][static_cast<std::size_t>(i)] = 0.01 * i;
  EXPECT_NEAR(strip.Trend(), std::sqrt(40.0), 1e-9);
}

TEST(WorstLooksTest, HoldNoneWithARedundancyBelowAHundredth) {
  ResultFolder result = Squinted();
  files::ResultFile file = result.file;
  file.looks.reason.assign(3, RejectReason::kNone);
  for (std::size_t k = 0; k < 2; ++k) {
    file.looks.quality.w[k] = {9.0F, 2.0F, 1.0F};
    file.looks.quality.redundancy[k] = {0.0099F, 0.0101F, 0.5F};
  }
  const ResultFolder arranged = Arrange("made", std::move(file));
  ASSERT_THAT(arranged.looks.worst, SizeIs(4));
  EXPECT_EQ(arranged.looks.worst[0].look, 1u);
}

}  // namespace
}  // namespace sarblock
