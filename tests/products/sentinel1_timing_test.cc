// SPDX-License-Identifier: Apache-2.0
// What times and ranges of Sentinel-1 images hold beyond geometry, on annotations of our own
// making.
#include "products/sentinel1_timing.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <tuple>

#include "products/import.h"
#include "products/synthetic_annotation.h"
#include "reduction/reduction.h"
#include "support/folder_test.h"
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::Replaced;
using test::SyntheticAnnotation;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr double kVacuum_mps = 299792458.0;

SyntheticAnnotation Bursts() {
  SyntheticAnnotation scene;
  scene.timing = scene.bursts = scene.size = true;
  return scene;
}

Sentinel1Timing TimingOf(const SyntheticAnnotation& scene) {
  const Sentinel1Product product = ParseSentinel1(scene.Xml(), "a.xml");
  ImportOptions options;
  std::vector<std::string> warnings;
  ImagePass image = PassOfSentinel1(product, {}, options, &warnings);
  image.pass.side = LookSide::kRight;
  std::vector<double> heights_m;
  for (const GeolocationGridPoint& point : product.grid) heights_m.push_back(point.place.h_m);
  return TimingOfSentinel1(product, image.pass, heights_m);
}

RadarCoordinates RasterAt(const SyntheticAnnotation& scene, int line, double pixel) {
  return {0.25 + scene.LineTime_s(line), scene.SlantRange_m(line, pixel)};
}

// Hand arithmetic at line 700, pixel 400 of the first of two bursts: tau = 2 (850123.5 + 400 5) / c
// = 5684.742475 us. Bistatic: 9 600 - (5700 + 5684.742475)/2 us. Doppler: k_s = 2
// 7508.236786/0.0554657646 0.75 pi/180 = 3543.901 Hz/s, k_t = -2136 3543.901/(-2136 - 3543.901) =
// 1332.7297 Hz/s, and line 700 is 1.505 s after the middle of the burst, line 549.5; the centroid
// is the same everywhere, so t_ref = 0: f = 24 + 1332.7297 1.505 Hz.
TEST(Sentinel1TimingTest, DelaysAreThoseOfTheFormulas) {
  const SyntheticAnnotation scene = Bursts();
  const Sentinel1Timing timing = TimingOf(scene);
  EXPECT_EQ(timing.left_out(), "");
  const ImageCoordinates place{700.0, 400.0};
  const RadarCoordinates raster = RasterAt(scene, 700, 400.0);
  const auto ground_m = timing.GroundAt(place, raster);
  ASSERT_TRUE(ground_m);
  const Sentinel1Delay delay = timing.At(place, raster, *ground_m);
  const double two_way_s = 2.0 * (850123.5 + 2000.0) / kVacuum_mps;
  // The grid's times are rounded to a microsecond.
  EXPECT_NEAR(delay.bistatic_s, 5.4e-3 - 0.5 * (5.7e-3 + two_way_s), 6e-7);
  const double doppler_hz = 24.0 + 1332.7297 * 1.505;
  EXPECT_NEAR(delay.pulse_motion_m, -doppler_hz / 1e12 * 0.5 * kVacuum_mps, 2e-6);
}

// Second route: the Doppler rate is -2/lambda times the second derivative of the range, here by
// differences of the closed form of the orbit.
TEST(Sentinel1TimingTest, TheFmRateIsTheCurvatureOfTheRange) {
  const SyntheticAnnotation scene = Bursts();
  const Sentinel1Timing timing = TimingOf(scene);
  const ImageCoordinates place{700.0, 400.0};
  const RadarCoordinates raster = RasterAt(scene, 700, 400.0);
  const Eigen::Vector3d p_m = *timing.GroundAt(place, raster);
  const auto range_m = [&](double from_s) {
    return (scene.Position_m(scene.first_line_s + 7.0 + from_s) - p_m).norm();
  };
  const double step_s = 0.1;
  const double curvature =
      (range_m(step_s) - 2.0 * range_m(0.0) + range_m(-step_s)) / (step_s * step_s);
  const double k_geo = -2.0 / (kVacuum_mps / 5.405e9) * curvature;
  const double doppler_hz = 24.0 + 1332.7297 * 1.505;
  // Differences are good to 2e-7 of the rate.
  EXPECT_NEAR(
      timing.At(place, raster, p_m).fm_rate_s, doppler_hz * (1.0 / k_geo - 1.0 / -2136.0), 3e-6);
}

// Second route to the sign: an echo with a Doppler, correlated with the chirp that was sent, peaks
// f/K_r earlier.
TEST(Sentinel1TimingTest, AnEchoWithADopplerPeaksEarlier) {
  constexpr double kRate_hz_per_s = 1e12, kLength_s = 5e-5, kDoppler_hz = 1e5;
  const auto correlation = [&](double late_s) {
    std::complex<double> sum;
    for (int k = -2000; k <= 2000; ++k) {
      const double t_s = kLength_s * k / 4000.0, sent_s = t_s - late_s;
      if (std::abs(sent_s) > 0.5 * kLength_s) continue;
      const double cycles =
          0.5 * kRate_hz_per_s * (t_s * t_s - sent_s * sent_s) + kDoppler_hz * t_s;
      sum += std::polar(1.0, 2.0 * std::numbers::pi * cycles);
    }
    return std::abs(sum);
  };
  EXPECT_GT(correlation(-1e-7), correlation(-1.1e-7));
  EXPECT_GT(correlation(-1e-7), correlation(-0.9e-7));
  EXPECT_GT(correlation(-1e-7), correlation(1e-7));
}

// A place in both bursts is seen at Dopplers k_t 9 s apart, 12.0 kHz: its ranges differ by 1.80 m,
// and by nothing once they are reduced. With the other sign they would differ by 3.60 m.
TEST(Sentinel1TimingTest, OverlappingBurstsMeetWithoutAStep) {
  const SyntheticAnnotation scene = Bursts();
  const Sentinel1Timing timing = TimingOf(scene);
  // 10 s after the first line.
  const RadarCoordinates raster = RasterAt(scene, 1000, 500.0);
  const Eigen::Vector3d p_m = *timing.GroundAt({1000.0, 500.0}, raster);
  const double first_m = timing.At({1000.0, 500.0}, raster, p_m).pulse_motion_m;
  const double second_m = timing.At({1200.0, 500.0}, raster, p_m).pulse_motion_m;
  EXPECT_NEAR(second_m - first_m, 1332.7297 * 9.0 / 1e12 * 0.5 * kVacuum_mps, 1e-5);
}

TEST(Sentinel1TimingTest, StripsHaveTheDopplerOfTheirCentroid) {
  SyntheticAnnotation scene;
  scene.timing = true;
  for (const bool ground : {false, true}) {
    scene.ground = ground;
    const Sentinel1Timing timing = TimingOf(scene);
    EXPECT_EQ(timing.left_out(), "");
    const RadarCoordinates raster = RasterAt(scene, 700, 400.0);
    const Eigen::Vector3d p_m = *timing.GroundAt({700.0, 400.0}, raster);
    EXPECT_NEAR(timing.At({700.0, 400.0}, raster, p_m).pulse_motion_m,
                -24.0 / 1e12 * 0.5 * kVacuum_mps,
                1e-12);
  }
}

// The sub-swath of a pixel of a merged image says which pulses are its own.
TEST(Sentinel1TimingTest, MergedImagesHaveThePulsesOfTheirSubSwaths) {
  SyntheticAnnotation scene;
  scene.timing = scene.ground = true;
  scene.swath = "IW";
  const auto bounds = [](const char* swath, int first, int last) {
    return fmt::format(
        "<swathMerge><swath>{}</swath><swathBoundsList><swathBounds><firstAzimuthLine>0"
        "</firstAzimuthLine><lastAzimuthLine>2000</lastAzimuthLine><firstRangeSample>{}"
        "</firstRangeSample><lastRangeSample>{}</lastRangeSample></swathBounds></swathBoundsList>"
        "</swathMerge>",
        swath,
        first,
        last);
  };
  std::string xml =
      Replaced(scene.Xml(),
               "</product>",
               "<swathMerging><swathMergeList>" + bounds("IW1", 0, 449) + bounds("IW2", 450, 1000) +
                   "</swathMergeList></swathMerging></product>");
  EXPECT_THAT(
      ImportProducts({ParseSentinel1(xml, "a.xml")}, {}, {}).warnings,
      ElementsAre(HasSubstr("the bistatic residual (downlinkInformationList has no pulses of the "
                            "sub-swath of line 0, pixel 0)")));
  const std::size_t begin = xml.find("<downlinkInformation>"),
                    end = xml.find("</downlinkInformation>") + 23;
  const std::string one = xml.substr(begin, end - begin);
  xml.replace(begin,
              end - begin,
              Replaced(one, "<swath>IW<", "<swath>IW1<") +
                  Replaced(Replaced(one, "<swath>IW<", "<swath>IW2<"), "<rank>9<", "<rank>8<"));
  const ImportedBlock imported = ImportProducts({ParseSentinel1(xml, "a.xml")}, {}, {});
  EXPECT_THAT(imported.warnings, IsEmpty());
  // Pixels 0 and 500 of the first row: a rank is 0.6 ms. An FM rate that does not change with range
  // adds 0.04 ms.
  const std::vector<double>& shift_s = imported.block.looks.time_shift_s;
  EXPECT_NEAR(shift_s[0] - shift_s[1], 6e-4, 5e-5);
  EXPECT_NEAR(shift_s[1], shift_s[2], 5e-5);
}

TEST(Sentinel1TimingTest, WhatTheAnnotationLacksIsNamedAndLeftIn) {
  const std::string xml = Bursts().Xml();
  const auto warnings = [](const std::string& text) {
    return ImportProducts({ParseSentinel1(text, "a.xml")}, {}, {}).warnings;
  };
  EXPECT_THAT(warnings(xml), IsEmpty());
  EXPECT_THAT(warnings(Replaced(xml, "<rank>9", "<rank>nine")),
              ElementsAre(AllOf(HasSubstr("a.xml: stays in its times and ranges: the bistatic"),
                                HasSubstr("rank: must be an integer of 0 or more, got 'nine'"),
                                HasSubstr("motion within the pulse ("),
                                Not(HasSubstr("FM rate")))));
  // 2e5 Hz less 1332.7 Hz/s of the steered beam times 5.5 s.
  EXPECT_THAT(warnings(Replaced(xml, "dataDcPolynomial>2.4", "dataDcPolynomial>2e5 2.4")),
              ElementsAre(AllOf(Not(HasSubstr("bistatic")),
                                HasSubstr("dataDcPolynomial gives a Doppler of 1.927e+05 Hz"))));
  EXPECT_THAT(
      warnings(Replaced(xml, "azimuthFmRatePolynomial>-2.1", "azimuthFmRatePolynomial>-1.1")),
      ElementsAre(HasSubstr("azimuthFmRatePolynomial gives -1136 Hz/s, orbit and ground")));
  EXPECT_THAT(
      warnings(Replaced(xml,
                        "<orbitSource>",
                        "<bistaticDelayCorrectionApplied>false</bistaticDelayCorrection"
                        "Applied><orbitSource>")),
      ElementsAre(HasSubstr("the bistatic residual (bistaticDelayCorrectionApplied is false)")));
  SyntheticAnnotation bare;  // times of grid and raster are the same
  EXPECT_THAT(warnings(bare.Xml()),
              ElementsAre(AllOf(HasSubstr("downlinkInformationList: the element is missing"),
                                HasSubstr("dopplerCentroid: the element is missing"))));
  SyntheticAnnotation ground = Bursts();
  ground.ground = true;
  ground.bursts = false;
  EXPECT_THAT(warnings(Replaced(ground.Xml(), "SteeringRate>0", "SteeringRate>1")),
              ElementsAre(HasSubstr("motion within the pulse (an image in ground range does not")));
  ImportOptions none;
  none.reduce = false;
  const ImportedBlock plain = ImportProducts({ParseSentinel1(bare.Xml(), "a.xml")}, {}, none);
  EXPECT_THAT(plain.warnings, IsEmpty());
  EXPECT_THAT(plain.block.looks.time_shift_s, IsEmpty());
  EXPECT_EQ(plain.block.passes[0].reduction, ReductionModels{});
}

class ReducedImportTest : public testing::Test {
 protected:
  void Import(const SyntheticAnnotation& scene, ImportOptions options) {
    imported_ = ImportProducts({ParseSentinel1(scene.Xml(), "a.xml")}, {}, options);
  }
  // Largest |e_r| and |e_d| of the looks of points with positions, everything taken off.
  std::array<double, 2> LargestErrors_m() const {
    const Block& given = imported_.block;
    ReducedBlock reduced(given);
    reduced.ReduceAt(given.points.given_m);
    const Block& block = reduced.block();
    std::array<double, 2> largest_m{};
    for (std::size_t i = 0; i < block.looks.size(); ++i) {
      const Eigen::Vector3d& p_m = block.points.given_m[block.looks.PointOf(i)];
      if (!p_m.allFinite()) continue;
      const Motion motion = *block.passes[0].path.At(block.looks.time_s[i]);
      const Eigen::Vector3d d_m = p_m - motion.position_m;
      largest_m[0] = std::max(largest_m[0], std::abs(d_m.norm() - block.looks.range_m[i]));
      largest_m[1] = std::max(largest_m[1], std::abs(motion.velocity_mps.normalized().dot(d_m)));
    }
    return largest_m;
  }
  ImportedBlock imported_;
};

// Two ways to one pixel: the grid's own time and range, and the raster's; of the modes IW and EW,
// in ground range, and of a strip.
TEST_F(ReducedImportTest, RasterAndGridAreOne) {
  for (const auto& [swath, ground, bursts] : {std::tuple{"IW2", false, true},
                                              std::tuple{"EW4", false, true},
                                              std::tuple{"IW2", true, false},
                                              std::tuple{"S3", false, false}}) {
    SCOPED_TRACE(swath);
    SyntheticAnnotation scene = Bursts();
    scene.swath = swath;
    scene.ground = ground;
    scene.bursts = bursts;
    ImportOptions options;
    std::string table = "point,image,line,sample\n";
    for (int k = 0; k < 9; ++k) {
      table += fmt::format("R{},a.xml,{},{}\n", k, 1000 * (k / 3), 500 * (k % 3));
    }
    options.points = ParseMatchedPoints(table, "points.csv");
    Import(scene, options);
    const Looks& looks = imported_.block.looks;
    ASSERT_EQ(looks.size(), 18U);
    for (std::size_t k = 0; k < 9; ++k) {
      EXPECT_NEAR(looks.time_s[k], looks.time_s[k + 9], 1e-9);
      EXPECT_NEAR(looks.range_m[k], looks.range_m[k + 9], 1e-6);
      // As annotated they are not: half the travel time from tau_mid, 14 us at the near edge.
      const double two_way_s = 2.0 * imported_.block.Measured(k).range_m / kVacuum_mps;
      const double apart_s =
          imported_.block.Measured(k).time_s - imported_.block.Measured(k + 9).time_s;
      EXPECT_NEAR(apart_s, 0.5 * (two_way_s - SyntheticAnnotation::kReference_s), 6e-7);
      // Independently of the raster: the part that the grid lacks is the same everywhere.
      const double tau_s = 2.0 * imported_.block.Measured(k + 9).range_m / kVacuum_mps;
      const double bistatic_s = 5.4e-3 - 0.5 * (SyntheticAnnotation::kReference_s + tau_s);
      EXPECT_NEAR(looks.time_shift_s[k] - (looks.time_shift_s[k + 9] - bistatic_s),
                  5.4e-3 - SyntheticAnnotation::kReference_s,
                  1.5e-6);
    }
  }
}

// Their positions are where the reduced looks see them: to a closed form as exactly as before.
TEST_F(ReducedImportTest, GridPointsFitTheirReducedLooks) {
  ImportOptions options;
  Import(Bursts(), options);
  EXPECT_GT(imported_.products[0].grid_move_m.least, 1.0);
  const auto [range_m, along_m] = LargestErrors_m();
  EXPECT_LT(range_m, 1e-3);  // a move of metres turns the line of sight of the troposphere
  EXPECT_LT(along_m, 1e-2);  // times of the grid are rounded to a microsecond
  EXPECT_THAT(imported_.products[0].delays.troposphere_m.Mean(),
              testing::AllOf(testing::Gt(2.3), testing::Lt(6.0)));
}

// A reflector is predicted where it is seen: measured there, it is at its place.
TEST_F(ReducedImportTest, PredictedReflectorsHoldTheDelays) {
  const SyntheticAnnotation scene = Bursts();
  const Sentinel1Timing timing = TimingOf(scene);
  const Eigen::Vector3d p_m = *timing.GroundAt({640.0, 320.0}, RasterAt(scene, 640, 320.0));
  const Geodetic at = Frame::Geocentric(NamedEllipsoid("WGS84")).GeodeticFromFrame(p_m);
  ImportOptions options;
  options.grid = std::nullopt;
  options.reflector_role = PointRole::kCheck;
  options.reflectors = ParseReflectors(
      fmt::format("Corner reflector ID,Latitude (deg),Longitude (deg),Height above ellipsoid (m)\n"
                  "C1,{:.13f},{:.13f},{:.9f}\n",
                  at.lat_rad / kRadPerDeg,
                  at.lon_rad / kRadPerDeg,
                  at.h_m),
      "cr.csv");
  Import(scene, options);
  ASSERT_EQ(imported_.reflectors.size(), 1U);
  const ReflectorInImage seen = imported_.reflectors[0];
  // The troposphere alone is 2.3 m of 5 m pixels.
  EXPECT_GT(seen.sample_px, 320.0 + 0.3);
  options.points = ParseMatchedPoints(
      fmt::format(
          "point,image,line,sample\nC1,a.xml,{:.9f},{:.9f}\n", seen.line_px, seen.sample_px),
      "points.csv");
  Import(scene, options);
  const auto [range_m, along_m] = LargestErrors_m();
  EXPECT_LT(range_m, 1e-4);
  EXPECT_LT(along_m, 1e-3);
  EXPECT_NEAR(imported_.products[0].offset.line_px, 0.0, 1e-4);
  EXPECT_NEAR(imported_.products[0].offset.sample_px, 0.0, 1e-4);
}

// Polarisations and sub-swaths of one flight.
TEST(DataTakeTest, ImagesOfOneFlightShareTheirPathErrors) {
  const std::string xml = Bursts().Xml();
  const Sentinel1Product vv = ParseSentinel1(xml, "vv.xml");
  const Sentinel1Product vh =
      ParseSentinel1(Replaced(xml, "<polarisation>VV", "<polarisation>VH"), "vh.xml");
  SyntheticAnnotation next = Bursts();
  next.swath = "IW3";
  const Sentinel1Product iw3 = ParseSentinel1(next.Xml(), "iw3.xml");
  ImportOptions options;
  options.path_sigma_m = 0.25;
  options.points = ParseMatchedPoints(
      "point,image,line,sample\nT,vv,400,300\nT,vh,400.25,300.5\nT,iw3,400,300\nU,vh,500,300\n",
      "points.csv");
  const ImportedBlock imported = ImportProducts({vv, vh, iw3}, {}, options);
  EXPECT_THAT(imported.warnings,
              ElementsAre(HasSubstr("2 looks at pixels that another polarisation")));
  ASSERT_EQ(imported.takes.size(), 1U);
  EXPECT_EQ(imported.takes[0].passes.size(), 3U);
  ASSERT_EQ(imported.corrections.size(), 1U);
  EXPECT_TRUE(imported.corrections[0].shared);
  EXPECT_EQ(imported.corrections[0].passes, imported.takes[0].passes);
  const auto& position = std::get<PositionCorrection>(imported.corrections[0].model);
  EXPECT_EQ(position.prior_sigma_m[1], std::vector<double>{0.25});
}

// One orbit file for two images of different days: the other keeps its own.
TEST(DataTakeTest, AnOrbitFileGoesToTheImageThatItCovers) {
  SyntheticAnnotation scene = Bursts(), other = Bursts();
  other.leap_second = true;  // of another year
  const OrbitFile orbit = ParseOrbitFile(scene.OrbitXml(-60.0, 200.0), "o.EOF");
  const ImportedBlock imported = ImportProducts(
      {ParseSentinel1(scene.Xml(), "a.xml"), ParseSentinel1(other.Xml(), "b.xml")}, {orbit}, {});
  EXPECT_EQ(imported.products[0].orbit_file, "o.EOF");
  EXPECT_EQ(imported.products[1].orbit_file, "");
  EXPECT_THAT(imported.warnings,
              testing::Contains(HasSubstr("b.xml: no orbit file covers it, its annotated orbit")));
  EXPECT_THAT(test::MessageOf<InputError>([&] {
                return ImportProducts({ParseSentinel1(other.Xml(), "b.xml")}, {orbit}, {});
              }),
              HasSubstr("no orbit file covers this product"));
}

TEST(DataTakeTest, OnBoardOrbitsAreNoControl) {
  const std::string xml = Replaced(Bursts().Xml(), "Synthetic", "Downlink");
  EXPECT_THAT(ImportProducts({ParseSentinel1(xml, "a.xml")}, {}, {}).warnings,
              ElementsAre(HasSubstr("its geolocation grid is no control")));
}

}  // namespace
}  // namespace sarblock
