// SPDX-License-Identifier: Apache-2.0
// The reader of annotations and orbit files on annotations of our own making.
#include <string>

#include "products/image_table.h"
#include "products/synthetic_annotation.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::SyntheticAnnotation;
using testing::ElementsAre;
using testing::HasSubstr;

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

TEST(OrbitFileTest, ReadsUtcStates) {
  const SyntheticAnnotation scene;
  const OrbitFile orbit = ParseOrbitFile(scene.OrbitXml(-50.0, 150.0), "o.EOF");
  EXPECT_EQ(orbit.mission, "Sentinel-1A");
  ASSERT_EQ(orbit.states.size(), 21u);
  EXPECT_EQ(UtcText(orbit.states[0].time), "2022-10-16T23:58:10Z");
  EXPECT_LT((orbit.states[20].position_m - scene.Position_m(150.0)).norm(), 2e-9);
}

}  // namespace
}  // namespace sarblock
