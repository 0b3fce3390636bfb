// SPDX-License-Identifier: Apache-2.0
// SICD images: one made from a closed form, and those of others where they are beside the project.
#include "sarblock/product/sicd.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/product/import_block.h"

#include <cmath>
#include <filesystem>
#include <string>

#include "fuzz/sicd_fuzz_targets.h"
#include "io/io_fixture.h"
#include "product/synthetic_annotation.h"
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

TEST_F(SicdTest, TheSceneCentreIsHeldAgainstThePathAndCanBeACheckPoint) {
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
  expect("<SideOfTrack>R", "<SideOfTrack>S", "'S' is not allowed, L or R is");
  expect("<NumRows>400", "<NumRows>1", "NumRows: is below 2");
  expect("<R_CA_SCP>800000.25", "<R_CA_SCP>-1", "a number above 0 is");
  expect("exponent1=\"2\"", "exponent1=\"65\"", "its attribute exponent1, '65', is not allowed");
  expect("exponent1=\"2\"", "exponent2=\"2\"", "its attribute exponent1, '', is not allowed");
  expect("<Coef exponent1=\"1\">1.4e-4</Coef>",
         "<Coef exponent1=\"1\">1.4e-4</Coef><Coef exponent1=\"2\">1e-9</Coef>",
         "TimeCAPoly: is not linear over the columns");
  expect("1.4e-4</Coef>", "0</Coef>", "gives the same time to all columns");
  expect("<CollectDuration>1", "<CollectDuration>1e6", "spans more than a day");
  EXPECT_THAT(Refusal("<product/>"), HasSubstr("is not the element expected here, <SICD> is"));
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
