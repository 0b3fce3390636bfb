// SPDX-License-Identifier: Apache-2.0
// The reader of annotations and orbit files on annotations of our own making.
#include "sarblock/core/error.h"

#include <string>

#include "io/io_fixture.h"
#include "product/synthetic_annotation.h"
#include "products/image_table.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::LineOf;
using test::Replaced;
using test::SyntheticAnnotation;
using testing::ElementsAre;
using testing::HasSubstr;

std::string ErrorOf(const std::string& text) {
  return test::MessageOf<InputError>([&] { return ParseSentinel1(text, "a.xml"); });
}
std::string OrbitErrorOf(const std::string& text) {
  return test::MessageOf<InputError>([&] { return ParseOrbitFile(text, "o.EOF"); });
}

TEST(Sentinel1ReaderTest, ReadsASlantRangeProduct) {  // what the fixture was made of
  SyntheticAnnotation scene;
  scene.bursts = true;
  const Sentinel1Product product = ParseSentinel1(scene.Xml(), "a.xml");
  EXPECT_EQ(product.mission, "S1A");
  EXPECT_EQ(product.swath, "IW2");
  EXPECT_EQ(product.polarisation, "VV");
  EXPECT_EQ(product.orbit_source, "Synthetic");
  EXPECT_NEAR(product.wavelength_m, 0.0554657646, 1e-10);  // 299792458 / 5.405e9
  EXPECT_EQ(product.presentation, Presentation::kSlant);
  EXPECT_EQ(UtcText(product.first_line), "2022-10-16T23:59:50Z");
  EXPECT_DOUBLE_EQ(product.first_line.fraction_s, 0.25);
  EXPECT_EQ(SecondsBetween(product.first_line, product.last_line), 20.0);
  EXPECT_EQ(product.line_interval_s, 0.01);
  EXPECT_NEAR(product.near_range_m, 850123.5, 1e-9);
  EXPECT_NEAR(product.range_spacing_m, 5.0, 1e-14);
  ASSERT_EQ(product.bursts.size(), 2u);
  EXPECT_EQ(SecondsBetween(product.bursts[0], product.bursts[1]), 9.0);
  EXPECT_EQ(product.lines_per_burst, 1100);
  ASSERT_EQ(product.orbit.size(), 13u);
  EXPECT_LT((product.orbit[3].position_m - scene.Position_m(30.0)).norm(), 2e-9);
  EXPECT_LT((product.orbit[3].velocity_mps - scene.Velocity_mps(30.0)).norm(), 2e-9);
  ASSERT_EQ(product.grid.size(), 9u);
  EXPECT_EQ(product.grid[5].line, 1000);
  EXPECT_EQ(product.grid[5].pixel, 1000);
  EXPECT_EQ(SecondsBetween(product.first_line, product.grid[5].time), 10.0);
  EXPECT_NEAR(product.grid[5].slant_range_m, 855123.5, 1e-9);
  EXPECT_NEAR(product.grid[5].place.h_m, 317.0, 1e-7);
}

TEST(Sentinel1ReaderTest, ReadsAGroundRangeProduct) {
  SyntheticAnnotation scene;
  scene.ground = true;
  const Sentinel1Product product = ParseSentinel1(scene.Xml(), "a.xml");
  EXPECT_EQ(product.presentation, Presentation::kGround);
  EXPECT_EQ(product.near_range_m, 0.0);
  EXPECT_EQ(product.range_spacing_m, 10.0);
  EXPECT_TRUE(product.bursts.empty());
  ASSERT_EQ(product.ground_range.size(), 2u);
  EXPECT_EQ(SecondsBetween(product.first_line, product.ground_range[1].time), 20.0);
  EXPECT_THAT(product.ground_range[1].coefficients, ElementsAre(850223.5, 0.61, 3e-7));
}

TEST(Sentinel1ReaderTest, ALeapSecondInsideTheProductCounts) {
  SyntheticAnnotation scene;
  scene.leap_second = true;
  const std::string xml = scene.Xml();
  EXPECT_THAT(xml, HasSubstr("2016-12-31T23:59:60.000000"));  // a state stands in it
  const Sentinel1Product product = ParseSentinel1(xml, "a.xml");
  EXPECT_EQ(SecondsBetween(product.first_line, product.last_line), 20.0);
  for (std::size_t k = 1; k < product.orbit.size(); ++k) {
    EXPECT_EQ(SecondsBetween(product.orbit[k - 1].time, product.orbit[k].time), 10.0);
  }
}

TEST(Sentinel1ReaderTest, NamesFileLineAndElementOfWhatIsWrong) {
  const std::string xml = SyntheticAnnotation().Xml();
  const auto changed = [&xml](const std::string& from, const std::string& to) {
    return ErrorOf(Replaced(xml, from, to));
  };
  const auto at = [&xml](const std::string& wanted) {
    return "a.xml:" + std::to_string(LineOf(xml, wanted)) + ": ";
  };
  const std::string general = "product.generalAnnotation.";
  const std::string image = "product.imageAnnotation.imageInformation.";
  EXPECT_THAT(changed("<missionId>S1A</missionId>\n", ""),
              HasSubstr("a.xml:3: product.adsHeader.missionId: the element is missing"));
  EXPECT_THAT(
      changed("Slant Range", "Map"),
      HasSubstr(
          at("<projection>") + general +
          "productInformation.projection: must be 'Slant Range' or 'Ground Range', got 'Map'"));
  EXPECT_THAT(changed("<radarFrequency>", "<radarFrequency>-"),
              HasSubstr(at("<radarFrequency>") + general + "productInformation.radarFrequency: "));
  EXPECT_THAT(changed("<slantRangeTime>", "<slantRangeTime>x"),
              HasSubstr(at("<slantRangeTime>") + image + "slantRangeTime: 'x5.67"));
  EXPECT_THAT(changed("LineUtcTime>2022-10-16T", "LineUtcTime>2022-10-36T"),
              HasSubstr(at("<productFirstLine") + image +
                        "productFirstLineUtcTime: '2022-10-36T23:59:50.250000' is no UTC time"));
  EXPECT_THAT(changed("Earth Fixed", "Inertial"),
              HasSubstr(at("<frame>") + general +
                        "orbitList.orbit.frame: must be 'Earth Fixed', got 'Inertial'"));
  EXPECT_THAT(changed("23:59:10.000000", "23:59:00.000000"),
              HasSubstr("orbitList.orbit: its time 2022-10-16T23:59:00Z is not after"));
  EXPECT_THAT(changed("<pixel>500</pixel>", "<pixel>0</pixel>"),
              HasSubstr("geolocationGridPoint: line 0, pixel 0 is given twice"));
  EXPECT_THAT(changed("<pixel>500</pixel>", "<pixel>5.5</pixel>"),
              HasSubstr(at("<pixel>500") +
                        "product.geolocationGrid.geolocationGridPointList.geolocationGridPoint."
                        "pixel: must be an integer of 0 or more, got '5.5'"));
  EXPECT_THAT(changed("<latitude>", "<latitude>9"), HasSubstr("latitude: is not between -90"));
  EXPECT_THAT(changed("<height>", "<height>nan"), HasSubstr("is not a finite number"));
  EXPECT_THAT(ErrorOf("<product>\n<adsHeader>\n</product>"),
              HasSubstr("a.xml:3: is not valid XML: Start-end tags mismatch"));
  EXPECT_THAT(ErrorOf("<other/>"), HasSubstr("a.xml:1: other: is not the element expected here"));
  EXPECT_THAT(ErrorOf(""), HasSubstr("a.xml:1: is not valid XML: No document element found"));
}

TEST(Sentinel1ReaderTest, GroundRangeNeedsItsPolynomials) {
  SyntheticAnnotation scene;
  scene.ground = true;
  const std::string xml = scene.Xml();
  const std::string second = "8.502235000000000e+05 6.100000000000000e-01 3.000000000000000e-07";
  EXPECT_THAT(ErrorOf(Replaced(xml, second, "8.5e5")),
              HasSubstr("grsrCoefficients: has one coefficient, two or more are needed"));
  EXPECT_THAT(ErrorOf(Replaced(xml, second, "8.5e5,0.6")),
              HasSubstr("grsrCoefficients: '8.5e5,0.6' is not a list of finite numbers"));
  EXPECT_THAT(
      ErrorOf(Replaced(xml, "<coordinateConversionList>", "<coordinateConversionList/><a>")),
      HasSubstr("is not valid XML"));
  SyntheticAnnotation slant;
  EXPECT_THAT(ErrorOf(Replaced(slant.Xml(), "Slant Range", "Ground Range")),
              HasSubstr("coordinateConversionList: is empty"));
}

TEST(OrbitFileTest, ReadsUtcStates) {
  const SyntheticAnnotation scene;
  const OrbitFile orbit = ParseOrbitFile(scene.OrbitXml(-50.0, 150.0), "o.EOF");
  EXPECT_EQ(orbit.mission, "Sentinel-1A");
  ASSERT_EQ(orbit.states.size(), 21u);
  EXPECT_EQ(UtcText(orbit.states[0].time), "2022-10-16T23:58:10Z");
  EXPECT_LT((orbit.states[20].position_m - scene.Position_m(150.0)).norm(), 2e-9);
}

TEST(OrbitFileTest, NamesWhatIsWrong) {
  const std::string xml = SyntheticAnnotation().OrbitXml(0.0, 50.0);
  EXPECT_THAT(OrbitErrorOf(Replaced(xml, "EARTH_FIXED", "J2000")),
              HasSubstr("Variable_Header.Ref_Frame: must be 'EARTH_FIXED', got 'J2000'"));
  EXPECT_THAT(OrbitErrorOf(Replaced(xml, "<X>+6", "<X>++6")), HasSubstr("OSV.X: '++6"));
  EXPECT_THAT(OrbitErrorOf(Replaced(xml, "<VZ>", "<WZ>0</WZ><VQ>")), HasSubstr("not valid XML"));
  EXPECT_THAT(OrbitErrorOf(SyntheticAnnotation().OrbitXml(0.0, 0.0)),
              HasSubstr("List_of_OSVs: has fewer than two states"));
  EXPECT_THAT(OrbitErrorOf(SyntheticAnnotation().Xml()),
              HasSubstr("product: is not the element expected here, <Earth_Explorer_File> is"));
}

}  // namespace
}  // namespace sarblock
