// SPDX-License-Identifier: Apache-2.0
// Images of Sentinel-1 compared with themselves: their size, their valid samples, their grid and
// their orbit, on annotations of our own making. What is changed is the oracle.
#include "sarblock/core/error.h"

#include <string>

#include "products/import.h"
#include "products/synthetic_annotation.h"
#include "support/folder_test.h"
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::Replaced;
using test::SyntheticAnnotation;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Geometry alone: nothing is taken off.
ImportOptions Plain() {
  ImportOptions options;
  options.reduce = false;
  return options;
}

std::string PointRefusal(const SyntheticAnnotation& scene, double line, double sample) {
  ImportOptions options;
  options.points = ParseMatchedPoints(
      fmt::format("point,image,line,sample\nT1,a.xml,{},{}\n", line, sample), "points.csv");
  return test::MessageOf<InputError>(
      [&] { return ImportProducts({ParseSentinel1(scene.Xml(), "a.xml")}, {}, options); });
}

std::string ImportRefusal(const std::string& xml) {
  return test::MessageOf<InputError>(
      [&] { return ImportProducts({ParseSentinel1(xml, "a.xml")}, {}, Plain()); });
}

TEST(Sentinel1ImageTest, PlacesOutsideTheImageAreRefused) {
  for (const bool ground : {false, true}) {
    SyntheticAnnotation scene;
    scene.ground = ground;
    scene.size = true;
    for (const auto& [line, sample] : {std::pair(1000.0, 1001.0),
                                       {1000.0, 68000.0},
                                       {1000.0, -500.0},
                                       {2001.0, 500.0},
                                       {-1.0, 0.0}}) {
      EXPECT_THAT(PointRefusal(scene, line, sample),
                  AllOf(HasSubstr("points.csv:2: line: line "),
                        HasSubstr("are outside image 'a.xml': it has 2001 lines and 1001 samples; "
                                  "merged, debursted or cut images count")))
          << line << " " << sample;
    }
    EXPECT_EQ(PointRefusal(scene, 1000.0, 1000.4), "");
    EXPECT_EQ(PointRefusal(scene, 0.0, -0.4), "");
  }
}

TEST(Sentinel1ImageTest, PlacesWithoutAValidSampleAreRefused) {
  SyntheticAnnotation scene;
  scene.bursts = scene.size = scene.valid_samples = true;
  EXPECT_THAT(PointRefusal(scene, 700.0, 11.0),
              HasSubstr("samples 12 to 988 of line 700 are valid"));
  EXPECT_THAT(PointRefusal(scene, 700.0, 989.0),
              HasSubstr("samples 12 to 988 of line 700 are valid"));
  EXPECT_THAT(PointRefusal(scene, 1102.0, 500.0), HasSubstr("line 1102 of it has no valid sample"));
  EXPECT_EQ(PointRefusal(scene, 700.0, 12.0), "");
  EXPECT_EQ(PointRefusal(scene, 1105.0, 988.0), "");
}

// 10 us of two-way time are 1499 m, 299.8 samples of 5 m; 27 ms are 2.7 lines.
TEST(Sentinel1ImageTest, ARasterThatContradictsItsGridIsRefused) {
  SyntheticAnnotation scene;
  const std::string xml = scene.Xml();
  const double near_s = 2.0 * SyntheticAnnotation::kNearRange_m / 299792458.0;
  const auto time = [](double t_s) { return fmt::format("<slantRangeTime>{:.15e}", t_s); };
  EXPECT_THAT(
      ImportRefusal(Replaced(xml, time(near_s), time(near_s + 1e-5))),
      AllOf(HasSubstr("a.xml:"),
            HasSubstr("geolocationGridPoint: the raster of the image contradicts this point"),
            HasSubstr("it is 299.8 samples (1499 m) from it, 1 is allowed (9 of 9"),
            HasSubstr("slantRangeTime or rangeSamplingRate")));
  EXPECT_EQ(ImportRefusal(Replaced(xml, time(near_s), time(near_s + 2e-8))), "");
  scene.bursts = true;
  const std::string late = Replaced(scene.Xml(),
                                    "<azimuthTime>" + scene.TimeText(scene.first_line_s + 9.0),
                                    "<azimuthTime>" + scene.TimeText(scene.first_line_s + 9.027));
  EXPECT_THAT(ImportRefusal(late),
              AllOf(HasSubstr("it is 2.7 lines (0.027 s) from it"), HasSubstr("(3 of 9 points")));
}

// A row that contradicts the orbit is a fault of the grid and says nothing of the raster.
TEST(Sentinel1ImageTest, FaultyRowsDoNotRefuseTheRaster) {
  SyntheticAnnotation scene;
  const std::string xml = scene.Xml();
  const std::string row = "<azimuthTime>" + scene.TimeText(scene.first_line_s + 20.0);
  std::string faulty = xml;
  for (int i = 0; i < 3; ++i) {
    faulty = Replaced(faulty, row, "<azimuthTime>" + scene.TimeText(scene.first_line_s + 17.0));
  }
  const ImportedBlock imported = ImportProducts({ParseSentinel1(faulty, "a.xml")}, {}, Plain());
  EXPECT_EQ(imported.faults.size(), 1U);
}

// Closed form: the same orbit with its clock 18 s ahead sees all points 18 s later.
TEST(Sentinel1ImageTest, AnOrbitInGpsTimeIsNamed) {
  const SyntheticAnnotation scene;
  OrbitFile orbit = ParseOrbitFile(scene.OrbitXml(-60.0, 200.0), "gps.EOF");
  const Sentinel1Product product = ParseSentinel1(scene.Xml(), "a.xml");
  EXPECT_EQ(ImportProducts({product}, {orbit}, Plain()).products[0].good, 9U);
  for (OrbitState& state : orbit.states) state.time = AddSeconds(state.time, 18.0);
  EXPECT_THAT(
      test::MessageOf<InputError>([&] { return ImportProducts({product}, {orbit}, Plain()); }),
      HasSubstr("gps.EOF: orbit: sees all 9 grid points of a.xml 18.000 s later than their "
                "azimuthTime: its times must be UTC, and GPS time differs from UTC by 18 s"));
  for (OrbitState& state : orbit.states) state.time = AddSeconds(state.time, -18.7);
  EXPECT_THAT(
      test::MessageOf<InputError>([&] { return ImportProducts({product}, {orbit}, Plain()); }),
      testing::EndsWith("0.700 s earlier than their azimuthTime: its times must be UTC"));
}

TEST(Sentinel1ImageTest, TheOrbitFileThatIsTakenAndItsQualityAreNamed) {
  const SyntheticAnnotation scene;
  const Sentinel1Product product = ParseSentinel1(scene.Xml(), "a.xml");
  const std::string xml = scene.OrbitXml(-60.0, 200.0);
  const auto first = xml.find("</OSV>");
  const std::string degraded = std::string(xml).insert(xml.find("</OSV>", first + 200 * 20),
                                                       "<Quality>DEGRADED</Quality>\n");
  const ImportedBlock imported =
      ImportProducts({product}, {ParseOrbitFile(degraded, "o.EOF")}, Plain());
  EXPECT_EQ(imported.products[0].orbit_file, "o.EOF");
  EXPECT_THAT(imported.warnings,
              ElementsAre(AllOf(HasSubstr("o.EOF: 1 of the "),
                                HasSubstr("states that are used are not NOMINAL, the first, "
                                          "'DEGRADED' at 20"))));
  EXPECT_THAT(ImportProducts({product}, {ParseOrbitFile(xml, "o.EOF")}, Plain()).warnings,
              IsEmpty());
}

TEST(Sentinel1ImageTest, GridsAndOrbitsThatAreNotUsedDoNotRefuseTheProduct) {
  const SyntheticAnnotation scene;
  const std::string xml = Replaced(scene.Xml(), "<height>", "<height>nan");
  EXPECT_THAT(ImportRefusal(xml), HasSubstr("is not a finite number"));
  const Sentinel1Product product =
      ParseSentinel1(xml, "a.xml", {.grid = PartUse::kCompared, .orbit = PartUse::kUsed});
  EXPECT_EQ(product.grid.size(), 8U);
  ImportOptions options = Plain();
  options.grid = std::nullopt;
  EXPECT_THAT(ImportProducts({product}, {}, options).warnings,
              ElementsAre(HasSubstr("a.xml: 1 of 9 grid points are left out, the first: a.xml:")));
  const std::string inertial = Replaced(scene.Xml(), "Earth Fixed", "Inertial");
  EXPECT_THAT(ImportRefusal(inertial), HasSubstr("must be 'Earth Fixed', got 'Inertial'"));
  const OrbitFile orbit = ParseOrbitFile(scene.OrbitXml(-60.0, 200.0), "o.EOF");
  const ImportedBlock imported = ImportProducts(
      {ParseSentinel1(inertial, "a.xml", {.grid = PartUse::kUsed, .orbit = PartUse::kCompared})},
      {orbit},
      Plain());
  EXPECT_EQ(imported.products[0].good, 9U);
  EXPECT_THAT(imported.warnings, Contains(HasSubstr("the annotated orbit is not used: a.xml:")));
}

}  // namespace
}  // namespace sarblock
