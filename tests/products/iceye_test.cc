// SPDX-License-Identifier: Apache-2.0
// Metadata of ICEYE images made from a closed form, and a real one, whose rational polynomials are
// a second route from the ground to the image.
#include "products/iceye.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <filesystem>
#include <string>

#include "fuzz/iceye_fuzz_targets.h"
#include "products/import.h"
#include "products/synthetic_iceye.h"
#include "support/folder_test.h"
#include <fmt/core.h>
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using test::MessageOf;
using test::Replaced;
using test::SyntheticIceye;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

std::string Refusal(const std::string& from, const std::string& to) {
  const std::string xml = Replaced(SyntheticIceye{}.Xml(), from, to);
  return MessageOf<InputError>(
      [&] { return ImportProducts({ParseIceye(xml, "i.xml")}, {}, ImportOptions{}); });
}

TEST(IceyeTest, ThePassIsTheClosedForm) {
  const SyntheticIceye made;
  ImportOptions options;
  options.points = ParseMatchedPoints("point,image,line,sample\nT,i.xml,1500.25,250.5\n", "p.csv");
  const IceyeProduct product = ParseIceye(made.Xml(), "i.xml");
  EXPECT_EQ(product.troposphere_m, 2.5);
  EXPECT_DOUBLE_EQ(product.wavelength_m, 299792458.0 / 9.65e9);
  const ImportedBlock imported = ImportProducts({product}, {}, options);
  EXPECT_THAT(imported.warnings, IsEmpty());
  EXPECT_EQ(imported.products[0].orbit_source, "precise");
  EXPECT_EQ(imported.products[0].stated,
            "its processor took 2.5000 m of troposphere off the ranges");
  const Pass& pass = imported.block.passes[0];
  EXPECT_EQ(pass.id, "ICEYE-X7_GRD_20221016T235950");
  EXPECT_EQ(pass.side, LookSide::kRight);
  EXPECT_EQ(pass.reduction, ReductionModels{});
  const Looks& looks = imported.block.looks;
  ASSERT_EQ(looks.size(), 1U);
  EXPECT_NEAR(looks.time_s[0], 0.25 + 15.0025, 1e-9);
  EXPECT_NEAR(looks.range_m[0], SyntheticIceye::SlantRange_m(250.5), 1e-8);
  EXPECT_THAT(looks.range_delay_m, IsEmpty());
  const auto seen = PlaceInImage(pass, made.Ground_m(700.0, 333.0));
  EXPECT_NEAR(seen->line_px, 700.0, 1e-4);
  EXPECT_NEAR(seen->pixel_px, 333.0, 1e-5);
  // A sample of 10 m on the ground, dR/dg in the middle.
  EXPECT_NEAR(pass.sigma.range_m, 10.0 * (0.6 + 2.0 * 5000.0 * 3e-7) / std::sqrt(12.0), 1e-4);
}

TEST(IceyeTest, ADelayThatTheProcessorLeftInIsLeftToTheReduction) {
  const std::string xml = Replaced(SyntheticIceye{}.Xml(), "delay>2.5", "delay>0.0");
  ImportOptions options;
  for (const bool reduce : {true, false}) {
    options.reduce = reduce;
    const ImportedBlock imported = ImportProducts({ParseIceye(xml, "i.xml")}, {}, options);
    EXPECT_EQ(imported.block.passes[0].reduction.troposphere,
              reduce ? TroposphereModel::kStandard : TroposphereModel::kNone);
    EXPECT_EQ(imported.products[0].stated, "its processor took no delay off the ranges");
  }
}

// The order of RPC00B, each term alone: powers of longitude, latitude and height.
TEST(IceyeTest, TermsOfRationalPolynomialsAreInTheirOrder) {
  constexpr int kPowers[20][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0},
                                  {1, 0, 1}, {0, 1, 1}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2},
                                  {1, 1, 1}, {3, 0, 0}, {1, 2, 0}, {1, 0, 2}, {2, 1, 0},
                                  {0, 3, 0}, {0, 1, 2}, {2, 0, 1}, {0, 2, 1}, {0, 0, 3}};
  for (std::size_t k = 0; k < 20; ++k) {
    RationalPolynomials rpc;
    rpc.offset = {100.0, 200.0, 10.0, 20.0, 30.0};
    rpc.scale = {7.0, 3.0, 2.0, 4.0, 50.0};
    rpc.coefficients[0][k] = rpc.coefficients[2][k] = 5.0;
    rpc.coefficients[1][0] = rpc.coefficients[3][0] = 2.0;
    // Normalised latitude 0.7, longitude -0.3, height 1.1.
    const ImageCoordinates at = rpc.At({11.4 * kRadPerDeg, 18.8 * kRadPerDeg, 85.0});
    const double term =
        std::pow(-0.3, kPowers[k][0]) * std::pow(0.7, kPowers[k][1]) * std::pow(1.1, kPowers[k][2]);
    EXPECT_NEAR(at.line_px, 100.0 + 7.0 * 2.5 * term, 1e-10) << k;
    EXPECT_NEAR(at.pixel_px, 200.0 + 3.0 * 2.5 * term, 1e-10) << k;
  }
}

TEST(IceyeTest, WhatMakesNoSenseIsRefusedByElement) {
  EXPECT_EQ(Refusal("right", "right"), "");
  EXPECT_THAT(Refusal(">GRD<", ">SLC<"),
              AllOf(HasSubstr("Metadata.product_level"),
                    HasSubstr("must be 'GRD' (other products are not read), got 'SLC'")));
  EXPECT_THAT(Refusal("right", "up"), HasSubstr("must be left or right, got 'up'"));
  EXPECT_THAT(Refusal("right", "left"),
              HasSubstr("coord_first_near: lies to the right of the flight, look_side is left"));
  EXPECT_THAT(Refusal("<azimuth_time_interval>0.01", "<azimuth_time_interval>0.011"),
              HasSubstr("contradicts the times of the first and last line: 20 s over 2001 lines"));
  EXPECT_THAT(Refusal("<coord_first_near>1 1", "<coord_first_near>1001 1"),
              HasSubstr("must run with time and away from the track"));
  EXPECT_EQ(Refusal("<coord_first_near>1 1", "<coord_first_near>[1,1,"), "");
  EXPECT_THAT(Refusal("<coord_first_near>1 1", "<coord_first_near>1 1.5"),
              HasSubstr("must be column, row, latitude and longitude, got '1 1.5"));
  EXPECT_THAT(Refusal("<number>2", "<number>3"), HasSubstr("must be 2, got 3"));
  EXPECT_THAT(Refusal("delay>2.5", "delay>2500"), HasSubstr("must be 0 to 150 m, got 2500"));
  // 0.05 s are five lines.
  const SyntheticIceye made;
  EXPECT_THAT(Refusal("<zerodoppler_start_utc>" + made.orbit.TimeText(50.25),
                      "<zerodoppler_start_utc>" + made.orbit.TimeText(50.26)),
              "");
  const std::string late =
      Replaced(Replaced(made.Xml(),
                        "<zerodoppler_start_utc>" + made.orbit.TimeText(50.25),
                        "<zerodoppler_start_utc>" + made.orbit.TimeText(50.30)),
               "<zerodoppler_end_utc>" + made.orbit.TimeText(70.25),
               "<zerodoppler_end_utc>" + made.orbit.TimeText(70.30));
  EXPECT_THAT(
      MessageOf<InputError>([&] { return ImportProducts({ParseIceye(late, "i.xml")}, {}, {}); }),
      AllOf(HasSubstr("coord_first_near: is at line 0 of the image by its row, by orbit and "
                      "times at line -5"),
            HasSubstr("2 lines are allowed")));
}

class IceyeFileTest : public test::FolderTest {};

TEST_F(IceyeFileTest, CorpusIsReadOrRefused) {
  std::size_t files = 0, read = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(SARBLOCK_FUZZ_CORPUS) / "iceye")) {
    const std::string text = Content(entry.path());
    EXPECT_NO_THROW(fuzz::Iceye(text)) << entry.path();
    ++files;
    const std::string problem =
        MessageOf<InputError>([&] { return ImportProducts({ParseIceye(text, "a.xml")}, {}, {}); });
    read += problem.empty() ? 1U : 0U;
  }
  EXPECT_GE(files, 20U);
  EXPECT_GE(read, 2U);
}

/// Metadata of others; skipped where they are not beside the project.
class RealIceyeTest : public test::FolderTest {
 protected:
  void SetUp() override {
    file_ = std::filesystem::path(SARBLOCK_SHARED_DATA) / "iceye" /
            "ICEYE_X7_GRD_SM_154171_20211027T183203.xml";
    if (!std::filesystem::exists(file_)) GTEST_SKIP() << "no " << file_;
  }
  std::filesystem::path file_;
};

// Two routes: path, raster and ground range polynomial against the product's rational polynomials.
// If the delay of 2.49 m were in the ranges but not in the polynomials, samples would be 3.4 off.
TEST_F(RealIceyeTest, RationalPolynomialsSeeThePlacesWhereThePathDoes) {
  const IceyeProduct product = ReadIceye(file_);
  EXPECT_TRUE(std::holds_alternative<IceyeProduct>(ReadSensorImage(file_)));
  EXPECT_NEAR(product.troposphere_m, 2.4857, 1e-4);
  const ImportedBlock imported = ImportProducts({product}, {}, {});
  EXPECT_THAT(imported.warnings, IsEmpty());
  const Frame earth = Frame::Geocentric(NamedEllipsoid("WGS84"));
  for (const double height_m : {-200.0, 172.0, 500.0}) {
    for (const double lat_deg : {16.05, 16.3, 16.55}) {
      for (const double lon_deg : {102.45, 102.6, 102.75}) {
        const Geodetic place{lat_deg * kRadPerDeg, lon_deg * kRadPerDeg, height_m};
        const auto seen =
            PlaceInImage(imported.block.passes[0], earth.FrameFromGeodetic(place)).value();
        const ImageCoordinates rpc = product.rpc->At(place);
        EXPECT_NEAR(rpc.line_px, seen.line_px, 0.01);
        EXPECT_NEAR(rpc.pixel_px, seen.pixel_px, 0.02);
      }
    }
  }
}

TEST_F(RealIceyeTest, ARasterThatItsRationalPolynomialsContradictIsRefused) {
  // The first coefficient 2.5 m shorter: dR/dg is 0.25 to 0.27, samples are 2.5 m.
  const std::string xml = Replaced(Content(file_), "<value>595967.7", "<value>595965.2");
  EXPECT_THAT(
      MessageOf<InputError>([&] { return ImportProducts({ParseIceye(xml, "i.xml")}, {}, {}); }),
      AllOf(HasSubstr("coord_first_near: is 0.00"),
            HasSubstr("3.9"),
            HasSubstr("samples from where the RPC see it, 1 is allowed")));
}

}  // namespace
}  // namespace sarblock
