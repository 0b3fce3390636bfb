// SPDX-License-Identifier: Apache-2.0
#include "sarblock/block/image_grid.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/geometry/path.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

ImageGrid SlantGrid() {
  ImageGrid grid;
  grid.first_line_s = 3.25;
  grid.line_interval_s = 0.0021;
  grid.near_range_m = 812345.5;
  grid.range_spacing_m = 2.3295;
  return grid;
}

// Ground range counted from the nadir of a flat scene with the antenna 700 km above: R^2 = H^2 +
// y^2 expanded at y0 = 400 km to the fourth power of y - y0 by hand.
ImageGrid GroundGrid() {
  ImageGrid grid = SlantGrid();
  grid.presentation = Presentation::kGround;
  grid.near_range_m = 0.0;
  grid.range_spacing_m = 10.0;
  const double h = 700e3, y = 400e3, r = std::sqrt(h * h + y * y);
  grid.ground_range = {{0.0,
                        0.0,
                        {r,
                         y / r,
                         h * h / (2.0 * r * r * r),
                         -h * h * y / (2.0 * std::pow(r, 5)),
                         h * h * (4.0 * y * y - h * h) / (8.0 * std::pow(r, 7))}}};
  return grid;
}

TEST(ImageGridTest, SlantPresentationIsLinear) {  // hand arithmetic
  const auto radar = RadarFromImage(SlantGrid(), {1000.5, 200.25});
  ASSERT_TRUE(radar);
  EXPECT_NEAR(radar->time_s, 3.25 + 1000.5 * 0.0021, 1e-12);
  EXPECT_NEAR(radar->range_m, 812345.5 + 200.25 * 2.3295, 1e-9);
  EXPECT_EQ(SlantRangePerPixel_m(SlantGrid(), *radar), 2.3295);
}

// Closed form: Pythagoras on a flat scene; the fifth term of the expansion is 4e-7 m at
// 5 km: h^2 y (3 h^2 - 4 y^2) / (8 r^9) g^5.
TEST(ImageGridTest, GroundPresentationOfAFlatSceneFollowsPythagoras) {
  const ImageGrid grid = GroundGrid();
  for (const double ground_m : {-5000.0, 0.0, 1234.5, 5000.0}) {
    const auto radar = RadarFromImage(grid, {0.0, ground_m / 10.0});
    ASSERT_TRUE(radar);
    EXPECT_NEAR(radar->range_m, std::hypot(700e3, 400e3 + ground_m), 1e-6) << ground_m;
    EXPECT_NEAR(*SlantRangePerPixel_m(grid, *radar),
                10.0 * (400e3 + ground_m) / std::hypot(700e3, 400e3 + ground_m),
                1e-8);
  }
}

TEST(ImageGridTest, RangeIsLinearInTimeBetweenPolynomials) {  // hand arithmetic
  ImageGrid grid = GroundGrid();
  grid.first_line_s = 0.0;
  grid.line_interval_s = 0.5;
  grid.ground_range = {{1.0, 0.0, {8e5, 0.5}}, {3.0, 100.0, {8.1e5, 0.7}}};
  const auto range_m = [&grid](double line) { return RadarFromImage(grid, {line, 20.0})->range_m; };
  EXPECT_DOUBLE_EQ(range_m(0.0), 800100.0);                 // before the first: the first
  EXPECT_DOUBLE_EQ(range_m(2.0), 800100.0);                 // t = 1
  EXPECT_DOUBLE_EQ(range_m(3.0), 800100.0 + 9970.0 / 4.0);  // t = 1.5, of 800100 and 810070
  EXPECT_DOUBLE_EQ(range_m(9.0), 810070.0);                 // after the last: the last
}

TEST(ImageGridTest, ImageToRadarAndBackIsTheSamePixel) {  // round trip; 1e-9 pixel is the promise
  ImageGrid several = GroundGrid();
  several.ground_range.push_back(several.ground_range.front());
  several.ground_range.back().time_s = 20.0;
  several.ground_range.back().coefficients[0] += 137.5;
  for (const ImageGrid& grid : {SlantGrid(), GroundGrid(), several}) {
    for (const double line : {-12.5, 0.0, 3456.75, 9000.0}) {
      for (const double pixel : {0.0, 17.25, 24999.5}) {
        const auto radar = RadarFromImage(grid, {line, pixel});
        ASSERT_TRUE(radar);
        const auto image = ImageFromRadar(grid, *radar);
        ASSERT_TRUE(image);
        EXPECT_NEAR(image->line_px, line, 1e-9);
        EXPECT_NEAR(image->pixel_px, pixel, 1e-9);
      }
    }
  }
}

// Round trip through the ground: a pixel is put on the surface at a height and seen again from the
// path. 1e-6 pixel is 2e-9 s and 2e-6 m, coordinates of 7e6 m round at 1e-9 m.
void ExpectRoundTripThroughGround(const Frame& frame,
                                  const FlightPath& path,
                                  const ImageGrid& grid) {
  for (const ImageCoordinates image : {ImageCoordinates{0.25, 3.5}, {15000.5, 20123.75}}) {
    const auto radar = RadarFromImage(grid, image);
    ASSERT_TRUE(radar);
    const auto motion = path.At(radar->time_s);
    ASSERT_TRUE(motion);
    FixedPathLook observation;
    observation.antenna_m = motion->position_m;
    observation.velocity_mps = motion->velocity_mps;
    observation.acceleration_mps2 = motion->acceleration_mps2;
    observation.range_m = radar->range_m;
    observation.side = -1;
    const Intersection place = IntersectWithHeight(observation, frame, 812.5);
    ASSERT_EQ(place.outcome, IntersectionOutcome::kDetermined);
    const auto time_s = FindConeTime(path, place.position_m, Cone{}, 0.0, 60.0);
    ASSERT_TRUE(time_s);
    const double range_m = (place.position_m - path.At(*time_s)->position_m).norm();
    const auto again = ImageFromRadar(grid, {*time_s, range_m});
    ASSERT_TRUE(again);
    EXPECT_NEAR(again->line_px, image.line_px, 1e-6);
    EXPECT_NEAR(again->pixel_px, image.pixel_px, 1e-6);
  }
}

// A circular orbit 693 km above the Earth, states 10 s apart; slant and ground presentation.
TEST(ImageGridTest, ImageToGroundAndBackIsTheSamePixelFromAnOrbit) {
  constexpr double kRadius_m = 7071e3, kRate = 1.0618e-3;  // [rad/s]
  std::vector<StateVector> states;
  for (int k = 0; k <= 6; ++k) {
    const double angle = kRate * 10.0 * k + 0.3;
    const Eigen::Vector3d out(std::cos(angle), 0.1, std::sin(angle));
    const Eigen::Vector3d ahead(-std::sin(angle), 0.0, std::cos(angle));
    states.push_back({10.0 * k, kRadius_m * out, kRadius_m * kRate * ahead});
  }
  ImageGrid ground = GroundGrid();
  ground.ground_range[0].coefficients[0] += 12345.5;
  const Frame frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  for (const ImageGrid& grid : {SlantGrid(), ground}) {
    ExpectRoundTripThroughGround(frame, FlightPath(states), grid);
  }
}

// The flat scene of GroundGrid(): 700 km above the plane, in a slight climb and turn.
TEST(ImageGridTest, ImageToGroundAndBackIsTheSamePixelInALocalFrame) {
  const FlightPath path({{0.0, {0.0, 12.5, 700e3}, {7480.5, 3.25, -2.5}},
                         {60.0, {448821.5, 160.25, 699870.5}, {7480.25, 1.75, -1.5}}});
  for (const ImageGrid& grid : {SlantGrid(), GroundGrid()}) {
    ExpectRoundTripThroughGround(Frame::Local(), path, grid);
  }
}

// Two bursts of 100 lines, 0.01 s a line, that share the times from 0.8 to 1 s: hand arithmetic.
TEST(ImageGridTest, BurstsShareTimesAndTheFartherEdgeWins) {
  ImageGrid grid = SlantGrid();
  grid.line_interval_s = 0.01;
  grid.burst_start_s = {0.0, 0.8};
  grid.lines_per_burst = 100;
  EXPECT_DOUBLE_EQ(RadarFromImage(grid, {99.0, 0.0})->time_s, 0.99);
  EXPECT_DOUBLE_EQ(RadarFromImage(grid, {100.0, 0.0})->time_s, 0.8);
  EXPECT_DOUBLE_EQ(RadarFromImage(grid, {199.5, 0.0})->time_s, 1.795);
  const auto line = [&grid](double time_s) { return ImageFromRadar(grid, {time_s, 9e5})->line_px; };
  EXPECT_NEAR(line(0.85), 85.0, 1e-9);   // 14 lines from the end of the first burst, 5 from the
  EXPECT_NEAR(line(0.95), 115.0, 1e-9);  // start of the second; 4 from the end, 15 from the start
  grid.burst_start_s[1] = 1.5;
  EXPECT_FALSE(ImageFromRadar(grid, {1.2, 9e5}));  // between the bursts
  EXPECT_TRUE(ImageFromRadar(grid, {1.6, 9e5}));
}

TEST(ImageGridTest, WhereRangeFallsWithThePixelThereIsNoAnswer) {
  ImageGrid grid = GroundGrid();
  grid.ground_range = {{0.0, 0.0, {8e5, 0.5, -1e-5}}};  // turns at g = 25 km
  EXPECT_TRUE(RadarFromImage(grid, {0.0, 2400.0}));
  EXPECT_FALSE(RadarFromImage(grid, {0.0, 2600.0}));
  EXPECT_FALSE(ImageFromRadar(grid, {3.25, 8.2e5}));       // more than the largest range, 806250 m
  EXPECT_FALSE(RadarFromImage(SlantGrid(), {0.0, -4e5}));  // a negative range
}

TEST(ImageGridTest, RefusesWhatNoImageCanHave) {
  const auto message = [](auto change) {
    ImageGrid grid = GroundGrid();
    change(&grid);
    try {
      CheckImageGrid(grid);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message([](ImageGrid*) {}), "accepted");
  EXPECT_THAT(message([](ImageGrid* g) { g->line_interval_s = 0.0; }),
              HasSubstr("line_interval_s: "));
  EXPECT_THAT(message([](ImageGrid* g) { g->range_spacing_m = -1.5; }),
              HasSubstr("range_spacing_m: "));
  EXPECT_THAT(message([](ImageGrid* g) { g->ground_range[0].coefficients = {8e5}; }),
              HasSubstr("ground_range[0].coefficients: 1 given"));
  EXPECT_THAT(message([](ImageGrid* g) { g->ground_range.clear(); }),
              HasSubstr("ground_range: is missing"));
  EXPECT_THAT(message([](ImageGrid* g) { g->ground_range.push_back(g->ground_range[0]); }),
              HasSubstr("ground_range[1].time_s: must be later"));
  EXPECT_THAT(message([](ImageGrid* g) { g->presentation = Presentation::kSlant; }),
              HasSubstr("near_range_m: "));
  EXPECT_THAT(message([](ImageGrid* g) { g->lines_per_burst = 7; }),
              HasSubstr("lines_per_burst: "));
  EXPECT_THAT(message([](ImageGrid* g) {
                g->lines_per_burst = 7;
                g->burst_start_s = {2.0, 2.0};
              }),
              HasSubstr("burst_start_s: "));
}

}  // namespace
}  // namespace sarblock
