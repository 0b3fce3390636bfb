// SPDX-License-Identifier: Apache-2.0
// SICD images whose time is exact and whose Doppler is measured: made here from closed forms, and
// those of others where they are beside the project.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>

#include "products/import.h"
#include "products/sicd.h"
#include "products/synthetic_annotation.h"
#include "support/folder_test.h"
#include <Eigen/Geometry>
#include <fmt/core.h>
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using test::MessageOf;
using test::Replaced;
using testing::HasSubstr;

constexpr double kLight_mps = 299792458.0;
constexpr double kWavelength_m = kLight_mps / 9.6e9;   // the middle of 9.5 and 9.7 GHz
const Eigen::Vector3d kCentre_m(6378137.0, 0.0, 0.0);  // latitude 0, longitude 0, height 0

/// A straight flight to the north, 600 km above the centre's horizon and `west_m` west of it, that
/// looks to the right, with a little acceleration down.
struct Flight {
  double west_m = 500e3, north_m = 0.0;  ///< at t = 0
  [[nodiscard]] Eigen::Vector3d Position_m(double t) const {
    return {6978137.0 - 4.0 * t * t, -west_m, north_m + 7500.0 * t};
  }
  [[nodiscard]] static Eigen::Vector3d Velocity_mps(double t) { return {-8.0 * t, 0.0, 7500.0}; }
  [[nodiscard]] double Range_m(const Eigen::Vector3d& p_m, double t) const {
    return (p_m - Position_m(t)).norm();
  }
  [[nodiscard]] double Rate_mps(const Eigen::Vector3d& p_m, double t) const {
    return -(p_m - Position_m(t)).dot(Velocity_mps(t)) / Range_m(p_m, t);
  }
};

/// Text of a SICD image of 1000 by 1200 pixels of 0.5 and 0.8 m, of which the file begins at row 10
/// and column 20; the centre is row 510, column 620 of the whole image.
std::string TextOf(const Flight& flight, const std::string& grid, const std::string& rest) {
  return fmt::format(R"(<?xml version="1.0"?>
<SICD xmlns="urn:SICD:1.3.0">
 <CollectionInfo><CoreName>made</CoreName><CollectType>MONOSTATIC</CollectType></CollectionInfo>
 <ImageData><NumRows>1000</NumRows><NumCols>1200</NumCols><FirstRow>10</FirstRow><FirstCol>20</FirstCol>
  <SCPPixel><Row>510</Row><Col>620</Col></SCPPixel></ImageData>
 <GeoData><SCP><ECF><X>6378137</X><Y>0</Y><Z>0</Z></ECF></SCP></GeoData>
 <Timeline><CollectStart>2021-05-04T03:02:01.250000Z</CollectStart><CollectDuration>2</CollectDuration></Timeline>
 <Position><ARPPoly>
  <X><Coef exponent1="0">6978137</Coef><Coef exponent1="2">-4</Coef></X>
  <Y><Coef exponent1="0">{}</Coef></Y>
  <Z><Coef exponent1="0">{}</Coef><Coef exponent1="1">7500</Coef></Z>
 </ARPPoly></Position>
 <SCPCOA><SideOfTrack>R</SideOfTrack></SCPCOA>
 <Grid>{}</Grid>
 {}
</SICD>
)",
                     -flight.west_m,
                     flight.north_m,
                     grid,
                     rest);
}
std::string GridOf(const std::string& type, const std::string& time, const std::string& axes = "") {
  const auto axis = [&axes](std::size_t k) {
    return axes.empty() ? "" : axes.substr(k * axes.size() / 2, axes.size() / 2);
  };
  return "<Type>" + type + "</Type><TimeCOAPoly>" + time + "</TimeCOAPoly><Row><SS>0.5</SS>" +
         axis(0) + "</Row><Col><SS>0.8</SS>" + axis(1) + "</Col>";
}
std::string Formation(const std::string& algorithm) {
  return "<ImageFormation><TxFrequencyProc><MinProc>9.5e9</MinProc><MaxProc>9.7e9</MaxProc>"
         "</TxFrequencyProc><ImageFormAlgo>" +
         algorithm + "</ImageFormAlgo></ImageFormation>";
}
constexpr const char* kOneTime = R"(<Coef exponent1="0" exponent2="0">1.125</Coef>)";

// PFA with theta = 0.01 - 0.009 t and KSF = 1 + 0.002 theta + 0.4 theta^2, in image coordinates.
struct PolarFormat {
  static double Angle_rad(double t) { return 0.01 - 0.009 * t; }
  static double Scale(double theta) { return 1.0 + 0.002 * theta + 0.4 * theta * theta; }
  static double ScaleRate(double theta) { return 0.002 + 0.8 * theta; }
  static std::string Text(const Flight& flight, const std::string& time) {
    return TextOf(
        flight,
        GridOf("RGAZIM", time),
        Formation("PFA") +
            R"(<PFA><PolarAngPoly><Coef exponent1="0">0.01</Coef><Coef exponent1="1">-0.009</Coef></PolarAngPoly>
 <SpatialFreqSFPoly><Coef exponent1="0">1</Coef><Coef exponent1="1">0.002</Coef><Coef exponent1="2">0.4</Coef></SpatialFreqSFPoly></PFA>)");
  }
  /// Where a point is focused whose aperture has the middle t: range and rate from the centre's
  /// give u = x cos + y sin and w = y cos - x sin, dR = K u, dRdot = (K' u + K w) theta'.
  static Eigen::Vector2d Place_m(const Flight& flight, const Eigen::Vector3d& p_m, double t) {
    const double theta = Angle_rad(t), scale = Scale(theta);
    const double range = flight.Range_m(p_m, t) - flight.Range_m(kCentre_m, t);
    const double rate = flight.Rate_mps(p_m, t) - flight.Rate_mps(kCentre_m, t);
    const double u = range / scale;
    const double w = (rate / -0.009 - ScaleRate(theta) * u) / scale;
    return {u * std::cos(theta) - w * std::sin(theta), u * std::sin(theta) + w * std::cos(theta)};
  }
};

// A row of the table of matched points.
std::string MatchOf(const std::string& point,
                    const std::string& image,
                    const Eigen::Vector2d& place_m) {
  return fmt::format("{},{},{:.17g},{:.17g}\n",
                     point,
                     image,
                     place_m.x() / 0.5 + 510.0 - 10.0,
                     place_m.y() / 0.8 + 620.0 - 20.0);
}
constexpr const char* kMatchHeader = "point,image,line,sample\n";

Block BlockOf(const std::vector<std::string>& texts, const std::string& matches) {
  ImportOptions options;
  options.grid = std::nullopt;
  options.points = ParseMatchedPoints(kMatchHeader + matches, "points.csv");
  std::vector<SensorImage> images;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    images.emplace_back(ParseSicd(texts[i], std::string(1, static_cast<char>('a' + i)) + ".xml"));
  }
  return ImportProducts(images, {}, options).block;
}

// The only look is what the flight sees of the point at its exact time.
void ExpectSeen(const Block& block, const Flight& flight, const Eigen::Vector3d& p_m, double t) {
  ASSERT_EQ(block.looks.size(), 1U);
  EXPECT_TRUE(block.MeasuresDoppler(0));
  EXPECT_NEAR(block.looks.time_s[0], t + 0.25, 1e-12);  // the epoch is the whole second before
  EXPECT_NEAR(block.looks.range_m[0], flight.Range_m(p_m, t), 2e-9);
  EXPECT_NEAR(block.looks.cone[0], -2.0 * flight.Rate_mps(p_m, t) / kWavelength_m, 1e-8);
  EXPECT_DOUBLE_EQ(block.passes[0].wavelength_m, kWavelength_m);
}

TEST(SicdApertureTest, APointOfAPolarFormatImageIsALookOfExactTimeAndMeasuredDoppler) {
  for (const double north_m : {0.0, -150e3}) {  // a squint of 11 degrees
    const Flight flight{500e3, north_m};
    const Eigen::Vector3d p_m = kCentre_m + Eigen::Vector3d(12.0, 150.0, -130.0);
    const Eigen::Vector2d place_m = PolarFormat::Place_m(flight, p_m, 1.125);
    const Block block = BlockOf({PolarFormat::Text(flight, kOneTime)}, MatchOf("P", "a", place_m));
    ExpectSeen(block, flight, p_m, 1.125);
  }
}

TEST(SicdApertureTest, SigmasOfAPolarFormatImageAreThoseOfItsRowsAndColumns) {
  // At theta = 0, 10/9 s, rows are range and columns rate: K = 1, K' = 0.002.
  const std::string text =
      PolarFormat::Text({}, R"(<Coef exponent1="0" exponent2="0">1.1111111111111112</Coef>)");
  const Block plain = BlockOf({text}, "P,a,500,600\n");
  const double evenly = 1.0 / std::sqrt(12.0), hertz_per_mps = 2.0 / kWavelength_m;
  EXPECT_EQ(plain.passes[0].sigma.azimuth_unit, AzimuthUnit::kHertz);
  EXPECT_NEAR(plain.SigmaOf(0).range_m, evenly * 0.5, 1e-9);
  EXPECT_NEAR(plain.SigmaOf(0).azimuth,
              evenly * 0.009 * std::hypot(0.8, 0.002 * 0.5) * hertz_per_mps,
              1e-6);
  ImportOptions options;
  options.grid = std::nullopt;
  options.range_sigma_m = 0.25;
  options.azimuth_sigma_m = 0.125;
  options.points = ParseMatchedPoints(
      "point,image,line,sample,line_sigma_px,sample_sigma_px\nP,a,500,600,,\nQ,a,500,600,0.1,0.2\n",
      "points.csv");
  const Block given = ImportProducts({ParseSicd(text, "a.xml")}, {}, options).block;
  const double t = 10.0 / 9.0;
  EXPECT_DOUBLE_EQ(given.SigmaOf(0).range_m, 0.25);
  // A hertz is lambda R/(2 |v|) at the target; the middle of the file is row 499.5, column 599.5.
  EXPECT_NEAR(
      given.SigmaOf(0).azimuth,
      0.125 * hertz_per_mps * Flight::Velocity_mps(t).norm() / Flight{}.Range_m(kCentre_m, t),
      1e-5);
  EXPECT_NEAR(given.SigmaOf(1).range_m, 0.1 * 0.5, 1e-9);
  EXPECT_NEAR(given.SigmaOf(1).azimuth,
              0.009 * std::hypot(0.2 * 0.8, 0.1 * 0.002 * 0.5) * hertz_per_mps,
              1e-6);
  EXPECT_EQ(given.SigmaOf(1).azimuth_unit, AzimuthUnit::kHertz);
}

// Antenna and ground moved alike see the same place; what the ranges are offset by, looks are.
TEST(SicdApertureTest, OffsetsMoveTheAntennaAndTheRangesOfPolarFormat) {
  SicdImage image = ParseSicd(PolarFormat::Text({}, kOneTime), "a.xml");
  image.centre_time_s = 0.0;
  const Eigen::Vector3d offset_m(12.5, -7.25, 3.75);
  const Eigen::Vector3d p_m = kCentre_m + Eigen::Vector3d(3.0, 120.0, -250.0);
  const auto plain = PlaceInSicd(image, p_m);
  ASSERT_TRUE(plain);
  const auto look = LookOfPlace(image, plain->line_px, plain->pixel_px);
  ASSERT_TRUE(look);
  image.offsets = SicdOffsets{offset_m, Eigen::Vector3d::Zero(), 0.0};
  const auto moved = PlaceInSicd(image, p_m + offset_m);
  ASSERT_TRUE(moved);
  EXPECT_NEAR(moved->line_px, plain->line_px, 1e-6);
  EXPECT_NEAR(moved->pixel_px, plain->pixel_px, 1e-6);
  // A drift counts from the time of the scene centre, and turns the range rate.
  image.offsets->velocity_mps = Eigen::Vector3d(0.25, -0.5, 0.125);
  const SicdMotion nominal = MotionOf(image, 0.75), adjusted = AdjustedMotionOf(image, 0.75);
  EXPECT_LT(
      (adjusted.position_m - nominal.position_m - offset_m - 0.75 * image.offsets->velocity_mps)
          .norm(),
      1e-8);
  EXPECT_LT((adjusted.velocity_mps - nominal.velocity_mps - image.offsets->velocity_mps).norm(),
            1e-11);
  image.offsets->range_m = 4.5;
  const auto ranged = LookOfPlace(image, plain->line_px, plain->pixel_px);
  ASSERT_TRUE(ranged);
  EXPECT_NEAR(ranged->range_m - look->range_m, 4.5, 1e-9);
  EXPECT_EQ(ranged->range_rate_mps, look->range_rate_mps);
}

TEST(SicdApertureTest, APointOfAnImageOfAzimuthCompressionIsWhereItsScaleSays) {
  const Flight flight{500e3, -150e3};
  const double t = 1.125;
  const Eigen::Vector3d d_m = kCentre_m - flight.Position_m(t), v_mps = Flight::Velocity_mps(t);
  const double cosine = d_m.normalized().dot(v_mps.normalized());
  // Looking to the right: AzSF = sin(cone angle)/range of the centre.
  const double scale = std::sqrt(1.0 - cosine * cosine) / d_m.norm();
  const std::string text = TextOf(
      flight,
      GridOf("RGAZIM", kOneTime),
      Formation("RGAZCOMP") + fmt::format("<RgAzComp><AzSF>{:.17g}</AzSF></RgAzComp>", scale));
  // A point a metre from the centre, across the sight line and forward in the slant plane, is at
  // y = 1 m; the cosine of its cone angle differs from AzSF y by the square of 1 m/range.
  const Eigen::Vector3d across = (v_mps - v_mps.dot(d_m) / d_m.squaredNorm() * d_m).normalized();
  const Block near = BlockOf({text}, MatchOf("P", "a", {0.0, 1.0}));
  EXPECT_NEAR(near.looks.range_m[0], flight.Range_m(kCentre_m + across, t), 1e-6);
  EXPECT_NEAR(
      near.looks.cone[0], -2.0 * flight.Rate_mps(kCentre_m + across, t) / kWavelength_m, 2e-6);
  EXPECT_GT(near.looks.cone[0], -2.0 * flight.Rate_mps(kCentre_m, t) / kWavelength_m + 0.1);
  // Any point, by the inverse of the closed form.
  const Eigen::Vector3d p_m = kCentre_m + Eigen::Vector3d(12.0, 150.0, -130.0);
  const double y_m =
      (flight.Rate_mps(p_m, t) - flight.Rate_mps(kCentre_m, t)) / (-v_mps.norm() * scale);
  const double x_m = flight.Range_m(p_m, t) - d_m.norm();
  ExpectSeen(BlockOf({text}, MatchOf("P", "a", {x_m, y_m})), flight, p_m, t);
}

TEST(SicdApertureTest, APlaceInAPlaneIsSeenWhereItIs) {
  const std::string row = "<UVectECF><X>0.6</X><Y>0.8</Y><Z>0</Z></UVectECF>";
  const std::string column = "<UVectECF><X>0.0</X><Y>0.0</Y><Z>1</Z></UVectECF>";
  ASSERT_EQ(row.size(), column.size());
  const Flight flight{500e3, -150e3};
  for (const char* type : {"PLANE", "XRGYCR", "XCTYAT"}) {
    const std::string text =
        TextOf(flight, GridOf(type, kOneTime, row + column), Formation("OTHER"));
    const Eigen::Vector3d p_m =
        kCentre_m + 40.0 * Eigen::Vector3d(0.6, 0.8, 0.0) - 30.0 * Eigen::Vector3d::UnitZ();
    ExpectSeen(BlockOf({text}, MatchOf("P", "a", {40.0, -30.0})), flight, p_m, 1.125);
    EXPECT_THAT(
        MessageOf<InputError>([&] { return ParseSicd(Replaced(text, "0.8<", "0.9<"), "a"); }),
        HasSubstr("SICD.Grid.Row.UVectECF: is no vector of length 1"));
  }
}

// A straight flight: the point of a column is where the antenna passes it at TimeCAPoly, at R_CA.
TEST(SicdApertureTest, ClosestApproachAtUnevenTimesIsTheSamePlaceAtTheMiddleOfItsAperture) {
  const auto text = [](const std::string& uneven) {
    return Replaced(
        TextOf({},
               GridOf("RGZERO", kOneTime),
               "<RMA><INCA><TimeCAPoly><Coef exponent1=\"0\">1</Coef><Coef "
               "exponent1=\"1\">1e-4</Coef>" +
                   uneven +
                   "</TimeCAPoly><R_CA_SCP>780000</R_CA_SCP><FreqZero>9.6e9</FreqZero><DRateSFPoly>"
                   "<Coef exponent1=\"0\" exponent2=\"0\">1</Coef></DRateSFPoly></INCA></RMA>"),
        "exponent1=\"2\">-4<",
        "exponent1=\"2\">0<");
  };
  const double uneven_s = 1.0 - 1e-4 * 30.0 + 1e-9 * 900.0;
  const double below_m = std::sqrt(780040.0 * 780040.0 - 500e3 * 500e3);
  const Eigen::Vector3d p_m(6978137.0 - below_m, 0.0, 7500.0 * uneven_s);
  const Block block =
      BlockOf({text("<Coef exponent1=\"2\">1e-9</Coef>")}, MatchOf("P", "a", {40.0, -30.0}));
  const Eigen::Vector3d d_m = p_m - Eigen::Vector3d(6978137.0, -500e3, 7500.0 * 1.125);
  EXPECT_TRUE(block.MeasuresDoppler(0));
  EXPECT_NEAR(block.looks.time_s[0], 1.125 + 0.25, 1e-12);
  EXPECT_NEAR(block.looks.range_m[0], d_m.norm(), 1e-9);
  EXPECT_NEAR(block.looks.cone[0], 2.0 * 7500.0 * d_m.z() / d_m.norm() / kWavelength_m, 1e-8);
  // Evenly spaced columns stay zero-Doppler times, from the whole second before the first of them.
  const Block even = BlockOf({text("")}, MatchOf("P", "a", {40.0, -30.0}));
  EXPECT_FALSE(even.MeasuresDoppler(0));
  EXPECT_NEAR(even.looks.time_s[0], 1e-4 * -30.0 + 0.25, 1e-11);
  EXPECT_NEAR(even.looks.range_m[0], 780040.0, 1e-8);
}

TEST(SicdApertureTest, TwoPolarFormatImagesAdjustedGiveTheTruePoints) {
  const std::array<Flight, 2> flights{{{500e3, -5e3}, {900e3, -150e3}}};
  // The second one has times of its own in every place: 1 s + 1e-4 s/m y - 2e-5 s/m x.
  const std::string times =
      R"(<Coef exponent1="0" exponent2="0">1</Coef><Coef exponent1="0" exponent2="1">1e-4</Coef>
<Coef exponent1="1" exponent2="0">-2e-5</Coef>)";
  std::string matches;
  std::vector<Eigen::Vector3d> points_m;
  for (int k = 0; k < 12; ++k) {
    const Eigen::Vector3d p_m =
        kCentre_m + Eigen::Vector3d(7.0 * (k % 5), 40.0 * (k % 4) - 70.0, 60.0 * (k / 4) - 75.0);
    points_m.push_back(p_m);
    const std::string id = "P" + std::to_string(k);
    matches += MatchOf(id, "a", PolarFormat::Place_m(flights[0], p_m, 1.125));
    double t = 1.0;
    Eigen::Vector2d place_m = Eigen::Vector2d::Zero();
    for (int step = 0; step < 50; ++step) {
      place_m = PolarFormat::Place_m(flights[1], p_m, t);
      t = 1.0 + 1e-4 * place_m.y() - 2e-5 * place_m.x();
    }
    matches += MatchOf(id, "b", place_m);
  }
  const Block block = BlockOf(
      {PolarFormat::Text(flights[0], kOneTime), PolarFormat::Text(flights[1], times)}, matches);
  ASSERT_EQ(block.looks.size(), 24U);
  const AdjustResult result = Adjust(block, AdjustOptions{});
  for (std::size_t k = 0; k < points_m.size(); ++k) {
    EXPECT_LT((result.points.position_m[k] - points_m[k]).norm(), 1e-5) << k;
  }
}

TEST(SicdApertureTest, ReflectorsAndTheSceneCentreAreFoundInThem) {
  const SicdImage image = ParseSicd(PolarFormat::Text({}, kOneTime), "a.xml");
  const Eigen::Vector3d p_m = kCentre_m + Eigen::Vector3d(12.0, 150.0, -130.0);
  const Eigen::Vector2d place_m = PolarFormat::Place_m({}, p_m, 1.125);
  const auto place = PlaceInSicd(image, p_m);
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->line_px, place_m.x() / 0.5 + 500.0, 1e-6);
  EXPECT_NEAR(place->pixel_px, place_m.y() / 0.8 + 600.0, 1e-6);
  const ImportedBlock imported = ImportProducts({image}, {}, ImportOptions{});
  EXPECT_EQ(imported.block.points.ids[0], "a:SCP");
  EXPECT_TRUE(imported.block.MeasuresDoppler(0));
  EXPECT_LT(imported.products[0].largest_range_m, 1e-6);
  EXPECT_LT(imported.products[0].largest_along_m, 1e-6);
  EXPECT_NEAR(imported.block.looks.cone[0],
              -2.0 * Flight{}.Rate_mps(kCentre_m, 1.125) / kWavelength_m,
              1e-8);
}

TEST(SicdApertureTest, AReflectorIsShownWhereItShouldBeSeenAndItsMatchesAreComparedWithIt) {
  ImportOptions options;
  options.grid = std::nullopt;
  options.reflectors = ParseReflectors(
      "Corner reflector ID,Latitude (deg),Longitude (deg),Height above ellipsoid (m)\n"
      "R,-0.001,0.0005,5\n",
      "reflectors.csv");
  options.reflector_sigma_m = 0.01;
  constexpr double kRadPerDeg = std::numbers::pi / 180.0;
  const Eigen::Vector3d p_m =
      Frame::Geocentric(NamedEllipsoid("WGS84"))
          .FrameFromGeodetic({-0.001 * kRadPerDeg, 0.0005 * kRadPerDeg, 5.0});
  const Eigen::Vector2d place_m = PolarFormat::Place_m({}, p_m, 1.125);
  options.points = ParseMatchedPoints(
      kMatchHeader + MatchOf("R", "a", place_m + Eigen::Vector2d(0.5, -1.6)), "points.csv");
  const ImportedBlock imported =
      ImportProducts({ParseSicd(PolarFormat::Text({}, kOneTime), "a.xml")}, {}, options);
  ASSERT_EQ(imported.reflectors.size(), 1U);
  EXPECT_NEAR(imported.reflectors[0].line_px, place_m.x() / 0.5 + 500.0, 1e-6);
  EXPECT_NEAR(imported.reflectors[0].sample_px, place_m.y() / 0.8 + 600.0, 1e-6);
  EXPECT_EQ(imported.block.points.role[0], PointRole::kControl);
  EXPECT_EQ(imported.products[0].matches, 1U);
  EXPECT_NEAR(imported.products[0].offset.line_px, 1.0, 1e-6);
  EXPECT_NEAR(imported.products[0].offset.sample_px, -2.0, 1e-6);
}

TEST(SicdApertureTest, NonsenseIsRefusedWithLineAndElement) {
  const std::string text = PolarFormat::Text({}, kOneTime);
  const auto expect = [&text](const std::string& from, const std::string& to, const char* message) {
    EXPECT_THAT(
        MessageOf<InputError>([&] { return BlockOf({Replaced(text, from, to)}, "P,a,5,5\n"); }),
        HasSubstr(message))
        << from;
  };
  expect(">PFA<", ">RMA<", "ImageFormAlgo: 'RMA' is not read with the grid type RGAZIM");
  expect("PolarAngPoly><Coef", "PolarAngPoly><Coeff", "is not valid XML");
  expect("<MinProc>9.5e9</MinProc>", "", "TxFrequencyProc");
  expect("exponent2=\"0\">1.125", "exponent2=\"65\">1.125", "a.xml:14: SICD.Grid.TimeCOAPoly.Coef");
  expect(">1.125<", ">1e6<", "TimeCOAPoly: gives times more than a day from the start");
  expect(">-0.009<", ">-90000<", "gives the middle of the image no range above 0");
  expect(">-0.009<", ">0<", "range and range rate do not change in the middle of the image");
  expect("RGAZIM", "RGSTRANGE", "'RGSTRANGE' is not read: RGZERO of an RMA/INCA image is, RGAZIM");
  EXPECT_THAT(MessageOf<InputError>([&] { return BlockOf({text}, "P,a,1000,5\n"); }),
              HasSubstr("it has 1000 lines and 1200 samples"));
}

// Where the sight of a look meets the ellipsoid.
Eigen::Vector3d OnTheGround_m(const SicdImage& image, const ApertureLook& look) {
  const SicdMotion motion = MotionOf(image, look.time_s);
  FixedPathLook observation;
  observation.antenna_m = motion.position_m;
  observation.velocity_mps = motion.velocity_mps;
  observation.range_m = look.range_m;
  observation.cone = {Cone::Kind::kDoppler, 0.0, -look.range_rate_mps};
  observation.side = static_cast<int>(image.side);
  const Intersection met =
      IntersectWithHeight(observation, Frame::Geocentric(NamedEllipsoid("WGS84")), 0.0);
  EXPECT_EQ(met.outcome, IntersectionOutcome::kDetermined);
  return met.position_m;
}

/// Images of others; skipped where they are not beside the project.
class RealApertureTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kFolder)) GTEST_SKIP() << "no " << kFolder;
  }
  const std::filesystem::path kFolder = std::filesystem::path(SARBLOCK_SHARED_DATA) / "sicd";
};

TEST_F(RealApertureTest, ImageToGroundToImageComesBack) {
  for (const char* name :
       {"example-sicd-1.3.0.xml", "cropped_sicd_040.nitf", "cropped_sicd_110.nitf"}) {
    const SicdImage image = ReadSicd(kFolder / name);
    for (const double row : {0.0, 0.4, 1.0}) {
      for (const double column : {0.0, 0.7, 1.0}) {
        const double row_px = row * static_cast<double>(image.rows - 1);
        const double column_px = column * static_cast<double>(image.columns - 1);
        const auto look = LookOfPlace(image, row_px, column_px);
        ASSERT_TRUE(look) << name;
        const auto back = PlaceInSicd(image, OnTheGround_m(image, *look));
        ASSERT_TRUE(back) << name;
        EXPECT_NEAR(back->line_px, row_px, 1e-6) << name;
        EXPECT_NEAR(back->pixel_px, column_px, 1e-6) << name;
      }
    }
  }
}

// The file's own corners, which its writer found by its own projection, in a plane where the test
// takes the ellipsoid. 5 degrees of squint; polar angles of 0.03 rad at its ends, whose wrong sign
// would move them by tens of metres.
TEST_F(RealApertureTest, CornersOfTheSquintedExampleAreWhereItSays) {
  const SicdImage image = ReadSicd(kFolder / "example-sicd-1.3.0.xml");
  const double last_row = static_cast<double>(image.rows - 1);
  const double last_column = static_cast<double>(image.columns - 1);
  const struct {
    double row_px, column_px, latitude_deg, longitude_deg;
  } corners[] = {{0.0, 0.0, 0.01001576106033251, -0.0022190990503292212},
                 {0.0, last_column, -0.0007342712730926178, 0.01050652810678314},
                 {last_row, last_column, -0.00999331499561866, 0.002211332461771066},
                 {last_row, 0.0, 0.0007567173381646753, -0.010514294695091552}};
  const Frame frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  constexpr double kRadPerDeg = std::numbers::pi / 180.0;
  for (const auto& corner : corners) {
    const auto look = LookOfPlace(image, corner.row_px, corner.column_px);
    ASSERT_TRUE(look);
    const Eigen::Vector3d p_m = frame.FrameFromGeodetic(
        {corner.latitude_deg * kRadPerDeg, corner.longitude_deg * kRadPerDeg, 0.0});
    const SicdMotion motion = MotionOf(image, look->time_s);
    LookEquations equations;
    ASSERT_TRUE(EvaluateLookEquations(p_m,
                                      motion.position_m,
                                      motion.velocity_mps,
                                      {Cone::Kind::kDoppler, 0.0, -look->range_rate_mps},
                                      0.0,
                                      &equations));
    EXPECT_LT(std::abs(equations.rho_m - look->range_m), 1.1);
    EXPECT_LT(std::abs(equations.doppler_error_m), 1.7);
  }
}

TEST_F(RealApertureTest, AFileWithoutMotionIsRefused) {
  std::ifstream stream(kFolder / "manual-syntax-only-sicd-1.1.0.xml");
  const std::string text(std::istreambuf_iterator<char>(stream), {});
  // Its transmitter and receiver are made up too.
  const std::string one_antenna = Replaced(text, "<RcvAPC ", "<RcvAPC_ ");
  EXPECT_THAT(MessageOf<InputError>([&] {
                return ImportProducts(
                    {ParseSicd(Replaced(one_antenna, "</RcvAPC>", "</RcvAPC_>"), "a.xml")},
                    {},
                    ImportOptions{});
              }),
              HasSubstr("SICD.Position.ARPPoly: state 2: velocity is zero"));
}

// INCA gives a place as closest approach, and as range and rate at the centre of its aperture.
TEST_F(RealApertureTest, BothReadingsOfAnIncaImageAreOnePlaceAtItsSceneCentre) {
  for (const char* name : {"cropped_sicd_040.nitf", "cropped_sicd_110.nitf"}) {
    const SicdImage image = ReadSicd(kFolder / name);
    const auto look = LookOfPlace(image,
                                  image.centre_row_px - image.first_row_px,
                                  image.centre_column_px - image.first_column_px);
    ASSERT_TRUE(look);
    const SicdMotion motion = MotionOf(image, look->time_s);
    const Eigen::Vector3d from_m = motion.position_m - image.centre_m;
    EXPECT_NEAR(look->range_m, from_m.norm(), 1e-9) << name;
    EXPECT_NEAR(look->range_rate_mps, motion.velocity_mps.dot(from_m) / from_m.norm(), 1e-9)
        << name;
  }
}

}  // namespace
}  // namespace sarblock
