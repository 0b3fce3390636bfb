// SPDX-License-Identifier: Apache-2.0
// SICD images: one made from a closed form, and those of others where they are beside the project.
#include "products/sicd.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"

#include <cmath>
#include <filesystem>
#include <string>

#include "fuzz/sicd_fuzz_targets.h"
#include "products/import.h"
#include "products/synthetic_annotation.h"
#include "support/folder_test.h"
#include <fmt/core.h>
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using test::MessageOf;
using test::Replaced;
using testing::HasSubstr;

class SicdTest : public test::FolderTest {
 protected:
  static std::string Text(const std::string& name = "plain.xml") {
    return Content(std::filesystem::path(SARBLOCK_FUZZ_CORPUS) / "sicd" / name);
  }
  static std::string Refusal(const std::string& text) {
    return MessageOf<InputError>(
        [&] { return ImportProducts({ParseSicd(text, "a.xml")}, {}, ImportOptions{}); });
  }
};

// plain.xml: the antenna flies straight on, p(t) = (7e6, 0, 7000 t + 0.5 t^2 - 3500), and looks to
// the right (east is +y). Rows are 2 m of range, columns 1.5 m of azimuth; the part of the image
// begins at row 10 and column 20; its centre is row 110, column 220; t_CA = 0.5 + 1.4e-4 az.
TEST_F(SicdTest, TheReaderGivesWhatTheFileSays) {
  const SicdImage image = ParseSicd(Text(), "a.xml");
  EXPECT_EQ(image.core_name, "plain");
  EXPECT_EQ(image.side, LookSide::kRight);
  EXPECT_DOUBLE_EQ(image.wavelength_m, 299792458.0 / 9.6e9);
  EXPECT_EQ(image.rows, 400U);
  EXPECT_EQ(image.columns, 300U);
  EXPECT_DOUBLE_EQ(image.Azimuth_m(7.0), (7.0 + 20.0 - 220.0) * 1.5);
  EXPECT_DOUBLE_EQ(image.ClosestRange_m(7.0), 800000.25 + (7.0 + 10.0 - 110.0) * 2.0);
  EXPECT_EQ(UtcMicroseconds(image.start), "2021-05-04T03:02:01.250000");
  EXPECT_DOUBLE_EQ(ValueOf(image.path_m[2], 2.0), 7000.0 * 2.0 + 2.0 - 3500.0);
  EXPECT_DOUBLE_EQ(ValueOf(DerivativeOf(image.path_m[2]), 2.0), 7002.0);
}

TEST_F(SicdTest, RowsAreRangeAndColumnsTimeWhicheverWayTheyRun) {
  for (const bool backward : {false, true}) {
    const std::string text =
        backward ? Replaced(Text(), "1.4e-4</Coef>", "-1.4e-4</Coef>") : Text();
    ImportOptions options;
    options.grid = std::nullopt;
    options.points = ParseMatchedPoints(
        "point,image,line,sample,line_sigma_px,sample_sigma_px\n"
        "P,a,30.5,40.25,0.25,0.5\nQ,a,399.25,299.25,,\n",
        "points.csv");
    const Block block = ImportProducts({ParseSicd(text, "a.xml")}, {}, options).block;
    const Pass& pass = block.passes[0];
    EXPECT_EQ(pass.id, "a");
    EXPECT_EQ(pass.epoch_utc, "2021-05-04T03:02:01Z");
    // Column 40.25: az = (60.25 - 220) 1.5 = -239.625 m; the epoch is 0.25 s before the start.
    const double sign = backward ? -1.0 : 1.0;
    const double time_s = 0.5 + sign * 1.4e-4 * -239.625;
    EXPECT_NEAR(block.looks.time_s[0], time_s + 0.25, 1e-11);
    EXPECT_NEAR(block.looks.range_m[0], 800000.25 + (40.5 - 110.0) * 2.0, 1e-9);
    EXPECT_NEAR(block.SigmaOf(0).range_m, 0.25 * 2.0, 1e-9);
    EXPECT_NEAR(block.SigmaOf(0).azimuth, 0.5 * 1.5 * 1.4e-4, 1e-12);
    const Motion motion = *pass.path.At(block.looks.time_s[0]);
    EXPECT_NEAR(motion.position_m.z(), 7000.0 * time_s + 0.5 * time_s * time_s - 3500.0, 1e-7);
    EXPECT_NEAR(motion.velocity_mps.z(), 7000.0 + time_s, 1e-9);
  }
}

TEST_F(SicdTest, MatchesOutsideItsRowsAndColumnsAreRefused) {
  const auto refusal = [](const std::string& row) {
    ImportOptions options;
    options.grid = std::nullopt;
    options.points = ParseMatchedPoints("point,image,line,sample\n" + row, "points.csv");
    return MessageOf<InputError>(
        [&] { return ImportProducts({ParseSicd(Text(), "a.xml")}, {}, options); });
  };
  EXPECT_EQ(refusal("P,a,399.4,299.4\n"), "");
  EXPECT_THAT(refusal("P,a,400,5\n"), HasSubstr("it has 400 lines and 300 samples"));
  EXPECT_THAT(refusal("P,a,5,300\n"), HasSubstr("it has 400 lines and 300 samples"));
}

TEST_F(SicdTest, TheSceneCentreIsComparedWithThePathAndCanBeACheckPoint) {
  const ImportedBlock imported = ImportProducts({ParseSicd(Text(), "a.xml")}, {}, ImportOptions{});
  EXPECT_EQ(imported.products[0].grid_points, 1U);
  EXPECT_TRUE(imported.faults.empty());
  EXPECT_EQ(imported.block.points.ids[0], "a:SCP");
  EXPECT_EQ(imported.block.points.role[0], PointRole::kCheck);
  // plain.xml has the centre where its range sphere meets the plane of zero Doppler, rounded to
  // a nanometre: t = 0.5, z = 0.125, x = 6.3e6, y = sqrt(R^2 - 0.7e6^2).
  EXPECT_LT(imported.products[0].largest_range_m, 1e-6);
  EXPECT_LT(imported.products[0].largest_along_m, 1e-6);
}

TEST_F(SicdTest, OtherKindsOfImagesAndNonsenseAreRefusedWithLineAndElement) {
  const auto expect = [](const std::string& from, const std::string& to, const char* message) {
    EXPECT_THAT(Refusal(Replaced(Text(), from, to)), HasSubstr(message)) << from;
  };
  expect("RGZERO", "RGAZIMUTH", "Grid.Type: 'RGAZIMUTH' is not read: RGZERO of an RMA/INCA");
  expect("RGZERO", "RGAZIM", "ImageFormation");
  expect("MONOSTATIC", "BISTATIC", "CollectType: 'BISTATIC' is not read, MONOSTATIC is");
  expect("<INCA>", "<RMAT>", "is not valid XML");
  expect("<SideOfTrack>R", "<SideOfTrack>S", "must be L or R, got 'S'");
  expect("<SideOfTrack>R",
         "<SideOfTrack>L",
         "SideOfTrack: must be R, the side of the flight on which the scene centre point "
         "(GeoData.SCP) is, got L");
  expect("<NumRows>400", "<NumRows>1", "NumRows: is below 2");
  expect("<R_CA_SCP>800000.25", "<R_CA_SCP>-1", "must be a number above 0, got");
  expect("exponent1=\"2\"",
         "exponent1=\"65\"",
         "its attribute exponent1 must be an integer of 0 to 64, got '65'");
  expect("exponent1=\"2\"",
         "exponent2=\"2\"",
         "its attribute exponent1 must be an integer of 0 to 64, got ''");
  expect("<Coef exponent1=\"1\">1.4e-4</Coef>",
         "<Coef exponent1=\"1\">1.4e-4</Coef><Coef exponent1=\"2\">1e-9</Coef>",
         "TimeCAPoly: is not linear over the columns");
  expect("1.4e-4</Coef>", "0</Coef>", "gives the same time to all columns");
  expect("<CollectDuration>1", "<CollectDuration>1e6", "spans more than a day");
  EXPECT_THAT(Refusal("<product/>"), HasSubstr("is not the element expected here, <SICD> is"));
}

// offsets.xml is plain.xml with AdjustableParameterOffsets: (1.5, -2.25, 3.125) m and (0.5, 0.25,
// -0.125) m/s from SCPTime 0.5 on, clocks 2e-8 s apart.
TEST_F(SicdTest, OffsetsOfTheFileMoveThePathAndTheRanges) {
  ImportOptions options;
  options.grid = std::nullopt;
  options.points = ParseMatchedPoints("point,image,line,sample\nP,a,30.5,40.25\n", "points.csv");
  const Block plain = ImportProducts({ParseSicd(Text(), "a.xml")}, {}, options).block;
  const Block moved = ImportProducts({ParseSicd(Text("offsets.xml"), "a.xml")}, {}, options).block;
  EXPECT_EQ(plain.looks.time_s[0], moved.looks.time_s[0]);
  EXPECT_NEAR(moved.looks.range_m[0] - plain.looks.range_m[0], 299792458.0 * 1e-8, 1e-9);
  for (const double time_s : {0.5, 0.75, 1.5}) {  // the epoch is 0.25 s before the start
    const Motion a = *plain.passes[0].path.At(time_s), b = *moved.passes[0].path.At(time_s);
    const Eigen::Vector3d velocity_mps(0.5, 0.25, -0.125);
    const Eigen::Vector3d offset_m =
        Eigen::Vector3d(1.5, -2.25, 3.125) + velocity_mps * (time_s - 0.75);
    EXPECT_LT((b.position_m - a.position_m - offset_m).norm(), 1e-8);
    EXPECT_LT((b.velocity_mps - a.velocity_mps - velocity_mps).norm(), 1e-8);
  }
  EXPECT_THAT(Refusal(Replaced(Text("offsets.xml"), "<SCPTime>0.5</SCPTime>", "")),
              HasSubstr("a.xml:16: SICD.SCPCOA.SCPTime: the element is missing"));
}

// A transmitter 1 m north and a receiver 1 m south of ARPPoly make its ranges but for 1e-6 m; 5 km
// apart they are two antennas.
TEST_F(SicdTest, ATransmitterApartFromTheReceiverIsABistaticImage) {
  EXPECT_THAT(
      Refusal(Text("two_antennas.xml")),
      HasSubstr("Position.RcvAPC.RcvAPCPoly: with TxAPCPoly makes ranges that differ by 1.21e+03 m "
                "from those of ARPPoly: the transmitter and the receiver of a bistatic image are "
                "not read, one antenna for both is"));
  const auto antenna = [](const char* name, const char* z) {
    return fmt::format(
        "<{0}><X><Coef exponent1=\"0\">7e6</Coef></X><Y><Coef exponent1=\"0\">0</Coef></Y><Z>"
        "<Coef exponent1=\"2\">0.5</Coef><Coef exponent1=\"0\">{1}</Coef>"
        "<Coef exponent1=\"1\">7000</Coef></Z></{0}>",
        name,
        z);
  };
  const std::string near = "</ARPPoly>" + antenna("TxAPCPoly", "-3499") + "<RcvAPC>" +
                           antenna("RcvAPCPoly", "-3501") + "</RcvAPC>";
  EXPECT_EQ(Refusal(Replaced(Text(), "</ARPPoly>", near)), "");
}

// plain.xml with corners where a sight to the right at the height of its scene centre, -66 km,
// ends: the look of row 0 and column 0 to the micrometre, 5 m off for the opposite one.
TEST_F(SicdTest, CornersBecomeCheckPointsKnownAsWellAsIsSaid) {
  ImportOptions options;
  options.grid = std::nullopt;
  const SicdImage image = ParseSicd(Text(), "a.xml");
  const Frame earth = Frame::Geocentric(NamedEllipsoid("WGS84"));
  const double height_m = earth.GeodeticFromFrame(image.centre_m).h_m;
  std::string corners = "<ImageCorners>";
  const double row_px[] = {0.0, 0.0, 399.0, 399.0}, column_px[] = {0.0, 299.0, 299.0, 0.0};
  const char* const names[] = {"FRFC", "FRLC", "LRLC", "LRFC"};
  for (std::size_t k = 0; k < 4; ++k) {
    const double t = 0.5 + 1.4e-4 * (column_px[k] + 20.0 - 220.0) * 1.5;
    FixedPathLook observation;
    observation.antenna_m = Eigen::Vector3d(7e6, 0.0, 7000.0 * t + 0.5 * t * t - 3500.0);
    observation.velocity_mps = Eigen::Vector3d(0.0, 0.0, 7000.0 + t);
    observation.range_m = 800000.25 + (row_px[k] + 10.0 - 110.0) * 2.0 + (k == 2 ? 5.0 : 0.0);
    observation.side = -1;
    const Geodetic place =
        earth.GeodeticFromFrame(IntersectWithHeight(observation, earth, height_m).position_m);
    constexpr double kDegrees = 57.29577951308232;
    corners += fmt::format("<ICP index=\"{}:{}\"><Lat>{:.17g}</Lat><Lon>{:.17g}</Lon></ICP>",
                           k + 1,
                           names[k],
                           place.lat_rad * kDegrees,
                           place.lon_rad * kDegrees);
  }
  const std::string text =
      Replaced(Text(), "</SCP></GeoData>", "</SCP>" + corners + "</ImageCorners></GeoData>");
  EXPECT_EQ(ImportProducts({ParseSicd(text, "a.xml")}, {}, options).block.points.size(), 0U);
  options.corner_sigma_m = 2.5;
  const ImportedBlock imported = ImportProducts({ParseSicd(text, "a.xml")}, {}, options);
  EXPECT_EQ(imported.products[0].corners, 4U);
  EXPECT_NEAR(imported.products[0].corner_range_m, 5.0, 1e-5);
  EXPECT_LT(imported.products[0].corner_along_m, 1e-5);
  ASSERT_EQ(imported.block.points.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(imported.block.points.ids[static_cast<std::uint32_t>(k)],
              std::string("a:") + names[k]);
    EXPECT_EQ(imported.block.points.role[k], PointRole::kCheck);
  }
  EXPECT_NEAR(imported.block.points.known.at(0).covariance_enu_m2(1, 1), 6.25, 1e-12);
  EXPECT_THAT(MessageOf<InputError>(
                  [&] { return ImportProducts({ParseSicd(Text(), "a.xml")}, {}, options); }),
              HasSubstr("SICD.GeoData.ImageCorners: does not place the four corners"));
}

TEST_F(SicdTest, RefusalsAfterReadingNameTheLine) {
  const auto expect = [](const std::string& from, const std::string& to, const char* message) {
    EXPECT_THAT(Refusal(Replaced(Text(), from, to)), HasSubstr(message)) << from;
  };
  expect("1.4e-4</Coef>", "0</Coef>", "a.xml:16: SICD.RMA.INCA.TimeCAPoly: gives the same time");
  expect("<CollectDuration>1", "<CollectDuration>1e6", "a.xml:8: SICD.Timeline.CollectDuration:");
  expect("7000</Coef>", "0</Coef>", "a.xml:9: SICD.Position.ARPPoly:");
}

TEST_F(SicdTest, TheXmlInANitfFileIsFoundAndLyingLengthsAreRefused) {
  const std::string nitf = fuzz::NitfOf(Text());
  const SicdImage image = ParseSicd(nitf, "a.nitf");
  EXPECT_EQ(image.rows, 400U);
  const auto refusal = [](const std::string& bytes) {
    return MessageOf<InputError>([&] { return ParseSicd(bytes, "a.nitf"); });
  };
  const auto with = [&nitf](std::size_t at, const std::string& field) {
    std::string bytes = nitf;
    bytes.replace(at, field.size(), field);
    return bytes;
  };
  EXPECT_THAT(refusal(with(354, "999999")), HasSubstr("are not in the file, which has"));
  EXPECT_THAT(refusal(with(354, "4x0412")), HasSubstr("a.nitf: HL: '4x0412' is no number"));
  EXPECT_THAT(refusal(with(360, "999")), HasSubstr("is no number"));
  EXPECT_THAT(refusal(with(fuzz::kNitfDesLengthAt, "999999999")), HasSubstr("64 MiB"));
  EXPECT_THAT(refusal(with(fuzz::kNitfDesLengthAt, "060000000")), HasSubstr("XML_DATA_CONTENT"));
  EXPECT_THAT(refusal(Replaced(nitf, "XML_DATA_CONTENT", "TRE_OVERFLOW    ")),
              HasSubstr("is in no data extension segment"));
  for (const std::size_t part : {std::size_t{9}, std::size_t{400}, nitf.size() - 20}) {
    EXPECT_NE(refusal(nitf.substr(0, part)), "") << part;
  }
}

TEST_F(SicdTest, FilesOfTheCorpusAreReadOrRefused) {
  std::size_t files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(SARBLOCK_FUZZ_CORPUS) / "sicd")) {
    EXPECT_NO_THROW(fuzz::Sicd(Content(entry.path()))) << entry.path();
    EXPECT_NO_THROW(fuzz::Sicd(fuzz::NitfOf(Content(entry.path())))) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 6U);
}

/// TerraSAR-X; skipped where it is not beside the project.
TEST(RealSicdTest, TheSceneCentreOfTerraSarXIsWhereItsPathSeesIt) {
  const std::filesystem::path folder = std::filesystem::path(SARBLOCK_SHARED_DATA) / "sicd";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  for (const char* name : {"cropped_sicd_040.nitf", "cropped_sicd_110.nitf"}) {
    ImportOptions options;
    options.points = ParseMatchedPoints(
        fmt::format("point,image,line,sample\nfirst,{0},0,0\nlast,{0},4,4\n", name), "points.csv");
    const SicdImage image = ReadSicd(folder / name);
    const ImportedBlock imported = ImportProducts({image}, {}, options);
    EXPECT_EQ(imported.products[0].good, 1U);
    EXPECT_LT(imported.products[0].largest_range_m, 1e-6) << name;
    EXPECT_LT(imported.products[0].largest_along_m, 2e-3) << name;
    EXPECT_EQ(imported.block.passes[0].side, LookSide::kRight);
    EXPECT_EQ(imported.products[0].matches, 2U);
    // Range and time of the first pixel of the part, by the polynomials as they stand.
    const double epoch_s =
        SecondsBetween(*ParseUtc(imported.block.passes[0].epoch_utc), image.start);
    EXPECT_NEAR(imported.block.looks.range_m[1],
                image.closest_range_m + (100.0 - 4839.0) * image.row_spacing_m,
                1e-8);
    EXPECT_NEAR(imported.block.looks.time_s[1],
                epoch_s + image.closest_time_s[0] +
                    image.closest_time_s[1] * (100.0 - 4299.0) * image.column_spacing_m,
                1e-12);
  }
  EXPECT_THAT(MessageOf<InputError>([&] { return ReadSicd(folder / "example-sicd-1.4.0.xml"); }),
              HasSubstr("'BISTATIC' is not read"));
}

}  // namespace
}  // namespace sarblock
