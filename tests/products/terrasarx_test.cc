// SPDX-License-Identifier: Apache-2.0
// Products of TerraSAR-X made from a closed form with delays of their own (synthetic_terrasarx.h),
// and a real one, whose processor placed its grid by the orbit that it wrote.
#include "products/terrasarx.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "fuzz/terrasarx_fuzz_targets.h"
#include "products/import.h"
#include "products/synthetic_terrasarx.h"
#include "support/folder_test.h"
#include <fmt/core.h>
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using test::MessageOf;
using test::SyntheticTerraSarX;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TerraSarXProduct Made(const SyntheticTerraSarX& made = {}) {
  TerraSarXProduct product = ParseTerraSarX(made.Xml(), "t.xml");
  AddGeoref(made.GeorefXml(), "GEOREF.xml", &product);
  return product;
}

TEST(TerraSarXTest, TheReaderGivesWhatTheFilesWereMadeOf) {
  const SyntheticTerraSarX made;
  const TerraSarXProduct product = Made(made);
  EXPECT_EQ(product.mission, "TSX-1");
  EXPECT_EQ(product.mode, "SM");
  EXPECT_EQ(product.orbit_accuracy, "SCIE");
  EXPECT_EQ(product.side, LookSide::kRight);
  EXPECT_DOUBLE_EQ(product.wavelength_m, 299792458.0 / 9.65e9);
  EXPECT_EQ(product.lines, 2001U);
  EXPECT_EQ(product.samples, 1001U);
  EXPECT_EQ(UtcMicroseconds(product.first_line), "2022-10-16T23:59:50.250000");
  EXPECT_EQ(UtcMicroseconds(product.last_line), "2022-10-17T00:00:10.250000");
  EXPECT_EQ(product.line_interval_s, 0.01);
  EXPECT_NEAR(product.near_range_m, 850123.5, 1e-8);
  EXPECT_NEAR(product.range_spacing_m, 5.0, 1e-13);
  ASSERT_EQ(product.orbit.size(), 13U);
  EXPECT_LT((product.orbit[3].position_m - made.orbit.Position_m(30.0)).norm(), 1e-8);
  // By hand: 2 x 851123.5 m / c less 5.7e-3 s, in the polynomials of the header.
  const double x_s = 2.0 * 851123.5 / 299792458.0 - 5.7e-3;
  const LookDelay delay = product.effects.At(851123.5);
  EXPECT_NEAR(delay.range_m, 149896229.0 * (1.52e-8 + 2e-5 * x_s), 1e-12);
  EXPECT_NEAR(delay.time_s, -1.8e-4 + 0.01 * x_s, 1e-16);
  ASSERT_EQ(product.grid.size(), 9U);
  EXPECT_EQ(product.grid[5].azimuth_index, 2);
  EXPECT_EQ(product.grid[5].range_index, 3);
  EXPECT_NEAR(product.grid[5].range_m, 850123.5 + 999.25 * 5.0, 1e-8);
}

// By the formula of the header, written out.
TEST(TerraSarXTest, HeightsOfTheGridAreThoseOfAnEllipsoidWithLongerAxes) {
  const SyntheticTerraSarX made;
  const std::string xml = made.GeorefXml();
  const auto number_of = [&xml](const char* element, std::size_t from) {
    const std::size_t at = xml.find(std::string("<") + element + ">", from);
    return std::stod(xml.substr(at + std::string(element).size() + 2));
  };
  std::size_t last = xml.rfind("<gridPoint");
  const double lat = number_of("lat", last) * kRadPerDeg, lon = number_of("lon", last) * kRadPerDeg;
  const double h_m = number_of("height", last);
  EXPECT_EQ(h_m, 2534.0);
  const double a_m = 6378137.0 + h_m, b_m = 6356752.315 + h_m;
  const double shape = b_m * b_m / (a_m * a_m);
  const double n_m = a_m / std::sqrt(1.0 - (1.0 - shape) * std::pow(std::sin(lat), 2));
  const Eigen::Vector3d by_hand_m(n_m * std::cos(lat) * std::cos(lon),
                                  n_m * std::cos(lat) * std::sin(lon),
                                  n_m * shape * std::sin(lat));
  const Frame earth = Frame::Geocentric(NamedEllipsoid("WGS84"));
  const Geodetic read = Made(made).grid.back().place;
  EXPECT_LT((earth.FrameFromGeodetic(read) - by_hand_m).norm(), 1e-8);
  // Neither the height nor the latitude of WGS84: some 2 mm per 2000 m.
  EXPECT_GT(std::abs(read.h_m - h_m), 1e-3);
  EXPECT_GT(std::abs(read.lat_rad - lat) * a_m, 1e-3);
}

TEST(TerraSarXTest, ThePassIsTheClosedFormAndItsGridFitsOnceDelaysAreTakenOff) {
  const SyntheticTerraSarX made;
  const ImportedBlock imported = ImportProducts({Made(made)}, {}, ImportOptions{});
  EXPECT_THAT(imported.warnings, IsEmpty());
  EXPECT_THAT(imported.faults, IsEmpty());
  ASSERT_EQ(imported.products.size(), 1U);
  EXPECT_EQ(imported.products[0].good, 9U);
  EXPECT_LT(imported.products[0].largest_range_m, 1e-5);
  EXPECT_LT(imported.products[0].largest_along_m, 1e-4);
  EXPECT_EQ(imported.products[0].orbit_source, "SCIE");
  // Half the speed of light times 1.5e-8 s and 2e-10 s.
  EXPECT_EQ(imported.products[0].stated,
            "taken off its looks, as the product states: range 2.2784 m (ATMOS 2.2484, IONO "
            "0.0300), azimuth time -180.0 us (TIMING -180.0)");
  const Block& block = imported.block;
  const Pass& pass = block.passes[0];
  EXPECT_EQ(pass.id, "TSX-1_SM_20221016T235950");
  EXPECT_EQ(pass.epoch_utc, "2022-10-16T23:59:50Z");
  EXPECT_EQ(pass.side, LookSide::kRight);
  EXPECT_EQ(pass.reduction, ReductionModels{});
  for (const double seconds : {50.0, 53.21, 61.5}) {
    const Motion motion = *pass.path.At(seconds - 50.0);
    EXPECT_LT((motion.position_m - made.orbit.Position_m(seconds)).norm(), 1e-5);
    EXPECT_LT((motion.velocity_mps - made.orbit.Velocity_mps(seconds)).norm(), 1e-5);
  }
  ASSERT_EQ(block.looks.size(), 9U);
  for (std::size_t i = 0; i < 9; ++i) {
    const RadarCoordinates measured = block.Measured(i);
    EXPECT_NEAR(
        block.looks.range_delay_m[i], SyntheticTerraSarX::RangeDelay_m(measured.range_m), 1e-9);
    EXPECT_NEAR(
        block.looks.time_shift_s[i], SyntheticTerraSarX::AzimuthShift_s(measured.range_m), 1e-15);
  }
  // Of the point at line 1000, sample 500 as annotated.
  EXPECT_NEAR(block.Measured(4).time_s, 10.25, 1e-9);
  EXPECT_NEAR(block.Measured(4).range_m, 852623.5, 1e-7);
}

TEST(TerraSarXTest, WithoutReductionTheGridIsOffByTheDelays) {
  const SyntheticTerraSarX made;
  ImportOptions options;
  options.reduce = false;
  const ImportedBlock imported = ImportProducts({Made(made)}, {}, options);
  const ImportedProduct& product = imported.products[0];
  EXPECT_NEAR(
      product.largest_range_m, SyntheticTerraSarX::RangeDelay_m(850123.5 + 999.25 * 5.0), 1e-3);
  // A point is 0.18 ms ahead of the antenna at the rate d/dt v.(p - s)/|v|.
  const double time_s = 60.25;  // of the middle of the image
  const Eigen::Vector3d v_mps = made.orbit.Velocity_mps(time_s);
  const Eigen::Vector3d a_mps2 =
      0.5 * (made.orbit.Velocity_mps(time_s + 1.0) - made.orbit.Velocity_mps(time_s - 1.0));
  const Frame earth = Frame::Geocentric(NamedEllipsoid("WGS84"));
  const Eigen::Vector3d sight_m =
      earth.FrameFromGeodetic(Made().grid[4].place) - made.orbit.Position_m(time_s);
  const double rate_mps = v_mps.norm() - a_mps2.dot(sight_m) / v_mps.norm();
  EXPECT_NEAR(product.mean_along_m, 1.8e-4 * rate_mps, 2e-3);
  EXPECT_EQ(product.stated, "");
  EXPECT_THAT(imported.block.looks.range_delay_m, IsEmpty());
  EXPECT_THAT(imported.block.looks.time_shift_s, IsEmpty());
}

// A grid point measured where the image shows it: its look and the look of the grid agree.
TEST(TerraSarXTest, MatchedPointsAndReflectorsKnowTheDelays) {
  const SyntheticTerraSarX made;
  ImportOptions options;
  options.grid = std::nullopt;
  const TerraSarXProduct product = Made(made);
  const Geodetic& place = product.grid[4].place;
  options.reflectors = ParseReflectors(
      fmt::format("Corner reflector ID,Latitude (deg),Longitude (deg),Height above ellipsoid (m)\n"
                  "CR,{:.15f},{:.15f},{:.9f}\n",
                  place.lat_rad / kRadPerDeg,
                  place.lon_rad / kRadPerDeg,
                  place.h_m),
      "r.csv");
  options.reflector_sigma_m = 0.01;
  options.points = ParseMatchedPoints(
      "point,image,line,sample\nCR,t.xml,1000,500\nT,t,1500.25,250.5\n", "p.csv");
  const ImportedBlock imported = ImportProducts({product}, {}, options);
  ASSERT_EQ(imported.reflectors.size(), 1U);
  EXPECT_NEAR(imported.reflectors[0].line_px, 1000.0, 1e-4);  // 8 mm
  EXPECT_NEAR(imported.reflectors[0].sample_px, 500.0, 1e-5);
  EXPECT_NEAR(imported.products[0].offset.line_px, 0.0, 1e-4);
  EXPECT_NEAR(imported.products[0].offset.sample_px, 0.0, 1e-5);
  const Looks& looks = imported.block.looks;
  ASSERT_EQ(looks.size(), 2U);
  for (const auto& [i, line, sample] :
       {std::tuple(0U, 1000.0, 500.0), std::tuple(1U, 1500.25, 250.5)}) {
    const double range_m = 850123.5 + 5.0 * sample;
    EXPECT_NEAR(looks.range_m[i], range_m - SyntheticTerraSarX::RangeDelay_m(range_m), 1e-7);
    EXPECT_NEAR(
        looks.time_s[i], 0.25 + 0.01 * line - SyntheticTerraSarX::AzimuthShift_s(range_m), 1e-10);
  }
}

// The first sample of the image is seen 2.2 m nearer: within the swath all the same.
TEST(TerraSarXTest, TheSwathIsThatOfGeometricRanges) {
  const Swath swath = ImportProducts({Made()}, {}, {}).block.passes[0].swath.value();
  const double first_m = 850123.5 - 2.5, last_m = 850123.5 + 5002.5;
  EXPECT_NEAR(swath.limits[0], first_m - SyntheticTerraSarX::RangeDelay_m(first_m), 1e-6);
  EXPECT_NEAR(swath.limits[1], last_m - SyntheticTerraSarX::RangeDelay_m(last_m), 1e-6);
}

class TerraSarXFileTest : public test::FolderTest {};

TEST_F(TerraSarXFileTest, GeorefIsFoundInAnnotationOrBesideTheFile) {
  const SyntheticTerraSarX made;
  const std::string file = Put("t.xml", made.Xml());
  EXPECT_EQ(ReadTerraSarX(file).georef_file, "");
  const std::string beside = Put("GEOREF.xml", made.GeorefXml());
  EXPECT_EQ(ReadTerraSarX(file).georef_file, beside);
  std::filesystem::create_directories(folder_ / "ANNOTATION");
  const std::string below = Put("ANNOTATION/GEOREF.xml", made.GeorefXml());
  EXPECT_EQ(std::get<TerraSarXProduct>(ReadSensorImage(file)).georef_file, below);
}

TEST_F(TerraSarXFileTest, WithoutGeorefTheStandardTroposphereIsLeftToTheReduction) {
  const TerraSarXProduct product = ReadTerraSarX(Put("t.xml", SyntheticTerraSarX{}.Xml()));
  const ImportedBlock imported = ImportProducts({product}, {}, {});
  EXPECT_THAT(imported.warnings, ElementsAre(HasSubstr("no GEOREF.xml in ANNOTATION")));
  EXPECT_EQ(imported.block.passes[0].reduction.troposphere, TroposphereModel::kStandard);
  ImportOptions options;
  options.reduce = false;
  const ImportedBlock raw = ImportProducts({product}, {}, options);
  EXPECT_THAT(raw.warnings, IsEmpty());
  EXPECT_EQ(raw.block.passes[0].reduction, ReductionModels{});
}

TEST(TerraSarXTest, VelocitiesAreUsedOnlyWhereTheyAreAskedFor) {
  ImportOptions options;
  options.through = OrbitThrough::kStates;
  const ImportedBlock imported = ImportProducts({Made()}, {}, options);
  // Rounded to 1 mm/s: up to 0.5 mm/s of 7.5 km/s at 850 km.
  EXPECT_GT(imported.products[0].largest_along_m, 0.01);
  EXPECT_LT(imported.products[0].largest_along_m, 0.12);
}

TEST(TerraSarXTest, ALookSideThatTheGridContradictsIsAWarning) {
  TerraSarXProduct product = Made();
  product.side = LookSide::kLeft;
  EXPECT_THAT(ImportProducts({product}, {}, {}).warnings,
              ElementsAre(HasSubstr("lies to the right of the flight")));
}

TEST_F(TerraSarXFileTest, CorpusIsReadOrRefused) {
  std::size_t files = 0, read = 0;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(SARBLOCK_FUZZ_CORPUS) / "terrasarx")) {
    const std::string text = Content(entry.path());
    EXPECT_NO_THROW(fuzz::TerraSarX(text)) << entry.path();
    ++files;
    read += MessageOf<InputError>([&] {
              return ImportProducts({fuzz::TerraSarXOf(text)}, {}, {});
            }).empty()
                ? 1U
                : 0U;
  }
  EXPECT_GE(files, 20U);
  EXPECT_GE(read, 3U);
}

/// A product of others; skipped where it is not beside the project. Its processor placed the grid
/// by its orbit and the delays that it states. With heights above the ellipsoid the range would be
/// off by up to 2.1 mm, with the time shift of the other sign by 360 us.
TEST(RealTerraSarXTest, TheGridFitsTheOrbitOnceTheStatedDelaysAreTakenOff) {
  const std::filesystem::path folder = std::filesystem::path(SARBLOCK_SHARED_DATA) / "terrasarx";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  const TerraSarXProduct product =
      ReadTerraSarX(folder / "TSX1_SAR__SSC______SM_S_SRA_20080310T133220_20080310T133228.xml");
  const ImportedBlock imported = ImportProducts({product}, {}, {});
  EXPECT_THAT(imported.warnings, IsEmpty());
  ASSERT_EQ(imported.block.looks.size(), 8296U);
  const Pass& pass = imported.block.passes[0];
  double range_m = 0.0, time_s = 0.0;
  for (std::size_t point = 0; point < 8296; ++point) {
    const Eigen::Vector3d& p_m = imported.block.points.given_m[point];
    const double seen_s =
        FindConeTime(pass.path, p_m, Cone{}, pass.path.start_s(), pass.path.end_s()).value();
    const double seen_m = (pass.path.At(seen_s)->position_m - p_m).norm();
    time_s = std::max(time_s, std::abs(imported.block.looks.time_s[point] - seen_s));
    range_m = std::max(range_m, std::abs(imported.block.looks.range_m[point] - seen_m));
  }
  RecordProperty("range_m", std::to_string(range_m));
  RecordProperty("time_us", std::to_string(1e6 * time_s));
  EXPECT_LT(range_m, 2e-5);   // asked for: 1 mm
  EXPECT_LT(time_s, 0.5e-6);  // asked for: 1 us
  // The sum of the delays that GEOREF.xml has, constants.
  EXPECT_NEAR(product.effects.At(product.near_range_m).range_m,
              0.5 * 299792458.0 * (1.86348973640016759e-10 + 1.45474766252304439e-8),
              1e-9);
}

}  // namespace
}  // namespace sarblock
