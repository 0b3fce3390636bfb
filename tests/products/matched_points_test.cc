// SPDX-License-Identifier: Apache-2.0
// Tables of matched points and of reflectors, with images of one kind and of several.
#include "sarblock/core/error.h"
#include "sarblock/geometry/look_equations.h"

#include <cmath>
#include <filesystem>
#include <string>

#include "fuzz/nisar_fuzz_targets.h"
#include "products/block_builder.h"
#include "products/import.h"
#include "products/isis.h"
#include "products/synthetic_annotation.h"
#include "support/folder_test.h"
#include <fmt/core.h>
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using test::MessageOf;
using test::NisarFile;
using test::SyntheticAnnotation;
using testing::HasSubstr;

constexpr const char* kHeader = "point,image,line,sample\n";

class MatchedPointsTest : public test::FolderTest {
 protected:
  std::filesystem::path Own(const std::string& name) const {
    return std::filesystem::path(SARBLOCK_FUZZ_CORPUS) / name;
  }
  NisarProduct Nisar(const std::string& name = "rslc.h5") const {
    const std::filesystem::path file = folder_ / name;
    NisarFile{}.Write(file);
    return ReadNisar(file);
  }
  static ImportOptions With(const std::string& table, double origin_px = 0.0) {
    ImportOptions options;
    options.grid = std::nullopt;
    options.points = ParseMatchedPoints(table, "points.csv");
    options.points->origin_px = {origin_px, origin_px};
    return options;
  }
};

TEST_F(MatchedPointsTest, LineAndSampleBecomeTimeAndRangeByTheOriginThatIsSaid) {
  for (const double origin_px : {0.0, 0.5, 1.0}) {
    const std::string row =
        fmt::format("T1,rslc.h5,{},{}\n", 731.25 + origin_px, 1012.5 + origin_px);
    const Block block = ImportProducts({Nisar()}, {}, With(kHeader + row, origin_px)).block;
    ASSERT_EQ(block.looks.size(), 1U);
    EXPECT_NEAR(block.looks.time_s[0], 0.25 + 731.25 * 0.01, 1e-9);
    EXPECT_NEAR(block.looks.range_m[0], 850123.5 + 1012.5 * 5.25, 1e-8);
    EXPECT_EQ(block.points.role[0], PointRole::kTie);
  }
}

TEST_F(MatchedPointsTest, AnImageGoesByItsPassOrItsFileWithOrWithoutFolderAndEnding) {
  const std::string names[] = {
      "NISAR_LSAR_A_20221016T235950", "rslc.h5", "rslc", (folder_ / "rslc.h5").string()};
  std::string table = kHeader;
  for (std::size_t i = 0; i < 4; ++i) table += fmt::format("T{},{},5,5\n", i, names[i]);
  EXPECT_EQ(ImportProducts({Nisar()}, {}, With(table)).products[0].matches, 4U);
}

TEST_F(MatchedPointsTest, StandardDeviationsOfARowAreInPixels) {
  const Block block = ImportProducts({Nisar()},
                                     {},
                                     With("point,image,line,sample,line_sigma_px,sample_sigma_px\n"
                                          "T1,rslc,10,20,0.25,0.5\nT2,rslc,10,20,,\n"))
                          .block;
  EXPECT_NEAR(block.SigmaOf(0).azimuth, 0.25 * 0.01, 1e-12);
  EXPECT_EQ(block.SigmaOf(0).azimuth_unit, AzimuthUnit::kSeconds);
  EXPECT_NEAR(block.SigmaOf(0).range_m, 0.5 * 5.25, 1e-9);
  EXPECT_NEAR(block.SigmaOf(1).range_m, 5.25 / std::sqrt(12.0), 1e-9);
}

TEST_F(MatchedPointsTest, KindsOfImagesMakeOneBlockInWhichTheirLooksMeet) {
  // One place in both images, each by the closed form of its orbit; both clocks are UTC.
  const Eigen::Vector3d place_m = NisarFile::Ground_m(57.5, 853000.0, 321.5);
  const SyntheticAnnotation scene;
  const Sentinel1Product sentinel1 = ParseSentinel1(scene.Xml(), "s1.xml");
  const NisarProduct nisar = Nisar();
  ImportOptions options = With(kHeader + fmt::format("P,rslc,{},{}\nP,s1,400,300\n",
                                                     (57.5 - NisarFile::kFirstLine_s) / 0.01,
                                                     (853000.0 - NisarFile::kNearRange_m) / 5.25));
  const ImportedBlock imported = ImportProducts({sentinel1, nisar}, {}, options);
  const Block& block = imported.block;
  ASSERT_EQ(block.passes.size(), 2U);
  EXPECT_EQ(block.points.size(), 1U);
  ASSERT_EQ(block.looks.size(), 2U);
  EXPECT_EQ(block.looks.pass[0], 0U);
  EXPECT_NEAR(block.looks.time_s[0], 0.25 + 4.0, 1e-6);
  EXPECT_NEAR(block.looks.range_m[0], scene.SlantRange_m(400.0, 300.0), 1e-6);
  const Motion motion = *block.passes[1].path.At(block.looks.time_s[1]);
  LookEquations equations;
  ASSERT_TRUE(EvaluateLookEquations(
      place_m, motion.position_m, motion.velocity_mps, Cone{}, 0.0, &equations));
  EXPECT_NEAR(equations.rho_m, block.looks.range_m[1], 1e-4);
  EXPECT_NEAR(equations.doppler_error_m, 0.0, 1e-3);
}

TEST_F(MatchedPointsTest, ImagesWithoutANetworkAndOfOtherBodies) {
  const SensorImage isd = ReadSensorImage(Own("isd/one.json"));
  const SensorImage cube = ReadSensorImage(Own("cube/one.cub"));
  ASSERT_TRUE(std::holds_alternative<RadarImage>(isd));
  const ImportOptions options = With(std::string(kHeader) + "T1,one,10,20\n");
  const Block block = ImportProducts({isd}, {}, options).block;
  EXPECT_EQ(block.frame.ellipsoid().name, "Moon");
  EXPECT_EQ(block.looks.size(), 1U);
  EXPECT_GT(block.passes[0].sigma.range_m, 0.0);
  EXPECT_THAT(MessageOf<InputError>([&] {
                return ImportProducts({Nisar(), cube}, {}, options);
              }),
              HasSubstr("is an image of another body than"));
  EXPECT_THAT(MessageOf<InputError>([&] { return ReadSensorImage(Put("a.txt", "hello")); }),
              HasSubstr("is no image that is read"));
  EXPECT_TRUE(std::holds_alternative<Sentinel1Product>(
      ReadSensorImage(Put("a.xml", "\n" + SyntheticAnnotation{}.Xml()))));
}

TEST_F(MatchedPointsTest, ANetworkTakesMorePointsAndMoreLooksOfItsOwn) {
  const ControlNetwork network = ReadControlNetwork(Own("network/moon.net"));
  const std::vector<RadarImage> images{ReadIsisCube(Own("cube/one.cub")),
                                       ReadIsisCube(Own("cube/two.cub"))};
  NetworkImportOptions options;
  options.range_sigma_m = options.azimuth_sigma_m = 4.0;
  const ImportedNetwork before = ImportNetwork(network, images, options);
  options.points = ParseMatchedPoints(std::string(kHeader) + "new,one,10,20\nnew,two,11,20\n", "p");
  const ImportedNetwork after = ImportNetwork(network, images, options);
  EXPECT_EQ(after.matches, 2U);
  EXPECT_EQ(after.block.points.size(), before.block.points.size() + 1);
  EXPECT_EQ(after.block.looks.size(), before.block.looks.size() + 2);
  // A point of the network that has a look there already.
  const std::string id(before.block.points.ids[0]);
  const std::string pass = before.block.passes[before.block.looks.pass[0]].id;
  options.points = ParseMatchedPoints(kHeader + id + "," + pass + ",10,20\n", "p.csv");
  EXPECT_THAT(MessageOf<InputError>([&] { return ImportNetwork(network, images, options); }),
              HasSubstr("p.csv:2: point: '" + id + "' is measured twice"));
}

class ReflectorTest : public MatchedPointsTest {
 protected:
  static constexpr const char* kColumns =
      "Corner reflector ID,Latitude (deg),Longitude (deg),Height above ellipsoid (m),Azimuth (deg),"
      "Tilt / Elevation (deg),Side length (m),Survey Date,Validity,Velocity East (m/s),Velocity "
      "North (m/s),Velocity Up (m/s)\n";
  static std::string Row(const std::string& id,
                         const Eigen::Vector3d& place_m,
                         const std::string& date,
                         int validity = 7,
                         const std::string& velocity = "0,0,0") {
    const Geodetic at = Frame::Geocentric(NamedEllipsoid("WGS84")).GeodeticFromFrame(place_m);
    return fmt::format("{}, {:.12f}, {:.12f}, {:.9f},0,0,2.4,{},{},{}\n",
                       id,
                       at.lat_rad / kRadPerDeg,
                       at.lon_rad / kRadPerDeg,
                       at.h_m,
                       date,
                       validity,
                       velocity);
  }
  static Eigen::Vector3d Place_m(int k) {
    return NisarFile::Ground_m(52.0 + k, 852000.0 + 800.0 * k, 120.0 + 3.0 * k);
  }
};

TEST_F(ReflectorTest, TheLatestSurveyBeforeTheImageMovesOnWithItsVelocity) {
  const Frame frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  const Eigen::Vector3d p_m = Place_m(0), later_m = Place_m(1);
  const Reflectors reflectors =
      ParseReflectors(kColumns + Row("A", later_m, "2019-01-01T00:00:00") +
                          Row("A", p_m, "2021-10-16T23:59:50.0000", 7, "1e-9,-2e-9,3e-9") +
                          Row("A", later_m, "2023-01-01T00:00:00") + Row("B", p_m, "2022-12-01") +
                          Row("C", p_m, "2020-01-01", 3) + Row("D", p_m, "1970-01-01T00:00:00"),
                      "cr.csv");
  const auto at = ReflectorsAt(reflectors, *ParseUtc("2022-10-16T23:59:50"), frame);
  ASSERT_EQ(at.size(), 2U);  // B is surveyed later, C not valid for geometry
  EXPECT_EQ(at[0].id, "A");
  EXPECT_EQ(at[1].id, "D");
  const Eigen::Vector3d moved_m = frame.EnuFromFrame(p_m) * (at[0].position_m - p_m);
  const double year_s = 365.0 * 86400.0;  // 31.5, -63.1 and 94.6 mm
  EXPECT_LT((moved_m - Eigen::Vector3d(1e-9, -2e-9, 3e-9) * year_s).norm(), 1e-5);
  EXPECT_LT((at[1].position_m - p_m).norm(), 1e-5);
}

TEST_F(ReflectorTest, MeasuredReflectorsBecomeControlAndTheOthersAreLeftOut) {
  std::string table = kColumns;
  for (int k = 0; k < 3; ++k) table += Row(fmt::format("C{}", k), Place_m(k), "2020-01-01");
  table += Row("far", NisarFile::Ground_m(20.0, 852000.0, 0.0), "2020-01-01");
  table += Row("new", Place_m(4), "2024-01-01");
  ImportOptions options =
      With(std::string(kHeader) + "C1,rslc,275.1,510.0\nnew,rslc,5,5\nT1,rslc,6,6\n");
  options.reflectors = ParseReflectors(table, "cr.csv");
  EXPECT_THAT(MessageOf<InputError>([&] { return ImportProducts({Nisar()}, {}, options); }),
              HasSubstr("reflector-sigma-m: is missing"));
  options.reflector_sigma_m = 0.02;
  const ImportedBlock imported = ImportProducts({Nisar()}, {}, options);
  EXPECT_EQ(imported.block.points.size(), 3U);
  ASSERT_EQ(imported.block.points.known.size(), 1U);
  const std::uint32_t c1 = imported.block.points.known[0].point;
  EXPECT_EQ(imported.block.points.ids[c1], "C1");
  EXPECT_EQ(imported.block.points.role[c1], PointRole::kControl);
  EXPECT_LT((imported.block.points.given_m[c1] - Place_m(1)).norm(), 1e-5);
  EXPECT_NEAR(imported.block.points.known[0].covariance_enu_m2(2, 2), 4e-4, 1e-12);
  EXPECT_THAT(imported.warnings, testing::Contains(HasSubstr("new is measured but left as a tie")));
  ASSERT_EQ(imported.reflectors.size(), 1U);
  EXPECT_NEAR(imported.reflectors[0].line_px, (53.0 - 50.25) / 0.01, 1e-4);
  EXPECT_NEAR(imported.reflectors[0].sample_px, (852800.0 - 850123.5) / 5.25, 1e-4);
  EXPECT_NEAR(imported.products[0].offset.line_px, 0.1, 1e-4);
  options.points = std::nullopt;  // then all that lie in the image, for looks to come
  EXPECT_EQ(ImportProducts({Nisar()}, {}, options).block.points.size(), 3U);
}

TEST_F(ReflectorTest, HalfAPixelAgainstKnownPositionsIsNamedWithItsRemedy) {
  std::string table = kColumns, points = kHeader;
  for (int k = 0; k < 6; ++k) {
    table += Row(fmt::format("C{}", k), Place_m(k), "2020-01-01");
    points += fmt::format("C{},rslc,{},{}\n",
                          k,
                          (52.0 + k - NisarFile::kFirstLine_s) / 0.01 + 0.5,
                          (852000.0 + 800.0 * k - NisarFile::kNearRange_m) / 5.25 + 0.5);
  }
  ImportOptions options = With(points);
  options.reflectors = ParseReflectors(table, "cr.csv");
  options.reflector_role = PointRole::kCheck;
  EXPECT_THAT(ImportProducts({Nisar()}, {}, options).warnings,
              testing::ElementsAre(HasSubstr("half a pixel in line and sample after")));
  options.points->origin_px = {0.5, 0.5};
  EXPECT_TRUE(ImportProducts({Nisar()}, {}, options).warnings.empty());
}

TEST_F(ReflectorTest, OneMovedBetweenTheImagesIsRefused) {
  NisarProduct first = Nisar(), second = first;
  constexpr double kYear_s = 365.0 * 86400.0;
  second.first_line.tai_whole += static_cast<std::int64_t>(kYear_s);
  second.last_line.tai_whole += static_cast<std::int64_t>(kYear_s);
  for (OrbitState& state : second.orbit) state.time.tai_whole += static_cast<std::int64_t>(kYear_s);
  second.grid = {};
  ImportOptions options;
  options.grid = std::nullopt;
  options.reflector_sigma_m = 0.01;
  options.reflectors =
      ParseReflectors(kColumns + Row("A", Place_m(0), "2021-10-16", 7, "1e-9,0,0"), "cr.csv");
  // 31.536 mm a year: half of it to either side of the mean.
  EXPECT_THAT(ImportProducts({first, second}, {}, options).warnings,
              testing::ElementsAre(HasSubstr("A is up to 15.8 mm from the mean"),
                                   HasSubstr("one of both has the orbit of another date")));
  options.reflectors = ParseReflectors(
      kColumns + Row("A", Place_m(0), "2021-10-16") + Row("A", Place_m(1), "2023-01-01"), "cr.csv");
  EXPECT_THAT(MessageOf<InputError>([&] {
                return ImportProducts({first, second}, {}, options);
              }),
              HasSubstr("A: was moved between the images"));
}

TEST_F(ReflectorTest, PlacesOnTheEarthAreNoneOfTheMoon) {
  ImportOptions options;
  options.reflector_role = PointRole::kCheck;
  options.reflectors = ParseReflectors(kColumns + Row("A", Place_m(0), "2021-10-16"), "cr.csv");
  const SensorImage cube = ReadSensorImage(Own("cube/one.cub"));
  EXPECT_THAT(MessageOf<InputError>([&] { return ImportProducts({cube}, {}, options); }),
              HasSubstr("cr.csv: holds places on the Earth"));
}

TEST_F(MatchedPointsTest, TablesOfTheCorpusAreReadOrRefused) {
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(Own("points"))) {
    const std::string text = Content(entry.path());
    EXPECT_NO_THROW(fuzz::Matches(text)) << entry.path();
    EXPECT_NO_THROW(fuzz::ReflectorTable(text)) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 15U);
}

}  // namespace
}  // namespace sarblock
