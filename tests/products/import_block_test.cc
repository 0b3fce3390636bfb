// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "products/import.h"
#include "products/synthetic_annotation.h"
#include "support/folder_test.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::SyntheticAnnotation;
using testing::HasSubstr;

/// Geometry alone: nothing is taken off.
struct PlainOptions : ImportOptions {
  PlainOptions() { reduce = false; }
};

Sentinel1Product Product(const SyntheticAnnotation& scene, const std::string& file = "a.xml") {
  return ParseSentinel1(scene.Xml(), file);
}

ImportedBlock Import(const SyntheticAnnotation& scene,
                     const ImportOptions& options = PlainOptions()) {
  return ImportProducts({Product(scene)}, {}, options);
}

struct Errors {
  double range_m = 0.0, along_m = 0.0;
};
// e_r and e_d of a look at its given point: independent of the importer's own check.
Errors ErrorsOf(const Block& block, std::size_t point, std::size_t look) {
  const Motion motion = *block.passes[block.looks.pass[look]].path.At(block.looks.time_s[look]);
  const Eigen::Vector3d d = block.points.given_m[point] - motion.position_m;
  return {d.norm() - block.looks.range_m[look], motion.velocity_mps.normalized().dot(d)};
}
Errors LargestErrors(const Block& block) {
  Errors largest;
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      const Errors errors = ErrorsOf(block, point, i);
      largest.range_m = std::max(largest.range_m, std::abs(errors.range_m));
      largest.along_m = std::max(largest.along_m, std::abs(errors.along_m));
    }
  }
  return largest;
}

// Closed form: grid points were put where range and zero Doppler of a circular orbit hold. Texts
// carry 1e-9 of a metre and 1e-15 of an angle of 60 degrees (6e-9 m); the path through states 1 s
// apart is 1e-7 m/s off, which the Doppler equation makes 850 km / 7.5 km/s times larger: 1.2e-5 m.
TEST(ImportProductsTest, GridPointsOfAClosedFormFitThePath) {
  for (const bool leap_second : {false, true}) {
    for (const bool ground : {false, true}) {
      SyntheticAnnotation scene;
      scene.leap_second = leap_second;
      scene.ground = ground;
      const ImportedBlock imported = Import(scene);
      EXPECT_TRUE(imported.faults.empty());
      EXPECT_TRUE(imported.warnings.empty());
      EXPECT_EQ(imported.block.points.size(), 9u);
      const Errors errors = LargestErrors(imported.block);
      EXPECT_LT(errors.range_m, 1e-7);
      EXPECT_LT(errors.along_m, 5e-5);
      ASSERT_EQ(imported.products.size(), 1u);
      EXPECT_EQ(imported.products[0].good, 9u);
      // Two orders of the same sums of numbers of a million metres.
      EXPECT_NEAR(imported.products[0].largest_along_m, errors.along_m, 1e-9);
    }
  }
}

// Hand arithmetic: from the outer edge of the first of 1001 samples to that of the last one; in
// ground range by the polynomials, which grow with pixels and lines.
TEST(ImportProductsTest, TheSwathIsThatOfTheSamples) {
  for (const bool ground : {false, true}) {
    SyntheticAnnotation scene;
    scene.size = true;
    scene.ground = ground;
    const Pass pass = Import(scene).block.passes.at(0);
    ASSERT_TRUE(pass.swath);
    EXPECT_EQ(pass.swath->kind, SwathKind::kSlantRange);
    const ImageGrid& grid = pass.image.value();
    if (!ground) {
      EXPECT_DOUBLE_EQ(pass.swath->limits[0], grid.near_range_m - 0.5 * grid.range_spacing_m);
      EXPECT_DOUBLE_EQ(pass.swath->limits[1], grid.near_range_m + 1000.5 * grid.range_spacing_m);
    } else {
      EXPECT_NEAR(pass.swath->limits[0], scene.SlantRange_m(0.0, -0.5), 1e-8);
      EXPECT_NEAR(pass.swath->limits[1], scene.SlantRange_m(2000.0, 1000.5), 1e-8);
    }
  }
}

TEST(ImportProductsTest, ThePassIsThatOfTheProduct) {
  const Block block = Import(SyntheticAnnotation()).block;
  ASSERT_EQ(block.passes.size(), 1u);
  const Pass& pass = block.passes[0];
  EXPECT_EQ(pass.id, "S1A_IW2_VV_20221016T235950");
  EXPECT_EQ(pass.epoch_utc, "2022-10-16T23:59:50Z");
  EXPECT_EQ(pass.side, LookSide::kRight);
  EXPECT_FALSE(pass.swath);  // the product does not say how many samples it has
  EXPECT_EQ(pass.start_s, 0.25);
  EXPECT_EQ(pass.end_s, 20.25);
  EXPECT_EQ(pass.path.start_s(), -50.0);
  EXPECT_EQ(pass.path.end_s(), 70.0);
  EXPECT_EQ(pass.path.states().size(), 121u);
  EXPECT_EQ(block.frame.ellipsoid().name, "WGS84");
  EXPECT_EQ(block.points.ids[5], "S1A_IW2_VV_20221016T235950:1000:1000");
  EXPECT_TRUE(block.looks.cone.empty());  // zero Doppler
  // A pixel of 5 m and a line of 0.01 s, evenly spread.
  EXPECT_DOUBLE_EQ(pass.sigma.range_m, 5.0 / std::sqrt(12.0));
  EXPECT_DOUBLE_EQ(pass.sigma.azimuth, 0.01 / std::sqrt(12.0));
  EXPECT_EQ(pass.sigma.azimuth_unit, AzimuthUnit::kSeconds);
}

// Two ways to the same numbers: the raster and the grid.
TEST(ImportProductsTest, TheRasterGivesTheGridsTimesAndRanges) {
  for (const bool ground : {false, true}) {
    SyntheticAnnotation scene;
    scene.ground = ground;
    const Block block = Import(scene).block;
    for (std::size_t k = 0; k < 9; ++k) {
      const ImageCoordinates at{1000.0 * static_cast<double>(k / 3),
                                500.0 * static_cast<double>(k % 3)};
      const auto radar = RadarFromImage(*block.passes[0].image, at);
      ASSERT_TRUE(radar);
      EXPECT_NEAR(radar->time_s, block.looks.time_s[k], 1e-12);
      EXPECT_NEAR(radar->range_m, block.looks.range_m[k], 1e-8);
    }
  }
  SyntheticAnnotation scene;
  scene.bursts = true;
  const ImageGrid image = *Import(scene).block.passes[0].image;
  EXPECT_DOUBLE_EQ(RadarFromImage(image, {1100.0, 0.0})->time_s, 9.25);
}

TEST(ImportProductsTest, GridPointsBecomeWhatIsAskedFor) {
  PlainOptions options;
  Block block = Import(SyntheticAnnotation(), options).block;
  EXPECT_EQ(block.points.role[4], PointRole::kCheck);
  EXPECT_EQ(block.points.known[4].covariance_enu_m2, Eigen::Matrix3d(Eigen::Matrix3d::Zero()));
  options.grid = PointRole::kTie;
  block = Import(SyntheticAnnotation(), options).block;
  EXPECT_EQ(block.points.role[4], PointRole::kTie);
  EXPECT_TRUE(block.points.known.empty());
  EXPECT_TRUE(block.points.given_m[4].allFinite());
  options.grid = PointRole::kControl;
  EXPECT_THAT(test::MessageOf<InputError>([&] { return Import(SyntheticAnnotation(), options); }),
              HasSubstr("grid-sigma-m: is missing"));
  options.grid_sigma_m = 0.25;
  options.range_sigma_m = 0.5;
  options.azimuth_sigma_m = 0.75;
  block = Import(SyntheticAnnotation(), options).block;
  EXPECT_EQ(block.points.role[4], PointRole::kControl);
  EXPECT_EQ(block.points.known[4].covariance_enu_m2(1, 1), 0.0625);
  EXPECT_EQ(block.passes[0].sigma.range_m, 0.5);
  EXPECT_EQ(block.passes[0].sigma.azimuth, 0.75);
  EXPECT_EQ(block.passes[0].sigma.azimuth_unit, AzimuthUnit::kMetres);
}

// Row 3 lies 0.05 degrees of latitude (5.5 km) off, row 2 has heights 400 m too low. By hand: the
// point 400 m lower is 400 cos(incidence) farther, which the message must say back.
TEST(ImportProductsTest, FaultyRowsAreNamedAndTheRestIsGood) {
  SyntheticAnnotation scene;
  scene.latitude_error_deg[2] = 0.05;
  scene.height_error_m[1] = -400.0;
  PlainOptions options;
  options.grid = PointRole::kControl;
  options.grid_sigma_m = 0.25;
  const ImportedBlock imported = Import(scene, options);
  ASSERT_EQ(imported.faults.size(), 2u);
  const FaultyRow &height = imported.faults[0], &position = imported.faults[1];
  EXPECT_EQ(height.fault, GridFault::kHeight);
  EXPECT_EQ(height.line, 1000);
  EXPECT_EQ(height.row, 2u);
  EXPECT_EQ(height.points, 3u);
  EXPECT_NEAR(height.height_m[0], 400.0, 1e-3);
  EXPECT_NEAR(height.height_m[1], 400.0, 1e-3);
  const auto limits = [&block = imported.block](std::size_t first, double Errors::*error) {
    return std::minmax({ErrorsOf(block, first, first).*error,
                        ErrorsOf(block, first + 1, first + 1).*error,
                        ErrorsOf(block, first + 2, first + 2).*error});
  };
  const auto [least_range_m, most_range_m] = limits(3, &Errors::range_m);
  EXPECT_NEAR(height.range_m[0], least_range_m, 1e-8);
  EXPECT_NEAR(height.range_m[1], most_range_m, 1e-8);
  EXPECT_EQ(position.fault, GridFault::kPosition);
  EXPECT_EQ(position.line, 2000);
  const auto [least_along_m, most_along_m] = limits(6, &Errors::along_m);
  EXPECT_NEAR(position.along_m[0], least_along_m, 1e-8);
  EXPECT_NEAR(position.along_m[1], most_along_m, 1e-8);
  const std::size_t line = test::LineOf(scene.Xml(), "<line>2000</line>") - 3;
  EXPECT_THAT(Describe(position),
              HasSubstr("a.xml:" + std::to_string(line) +
                        ": geolocationGrid line 2000 (row 3): 3 of 3 points do not fit the orbit"));
  const Block& block = imported.block;
  EXPECT_EQ(imported.products[0].good, 3u);
  for (std::size_t k = 0; k < 9; ++k) {
    EXPECT_EQ(block.looks.rejected(k), k >= 6) << k;
    EXPECT_EQ(block.points.known[k].fixed[2], k < 3 || k >= 6) << k;
    EXPECT_TRUE(block.points.known[k].fixed[0]);
  }
  options.grid = PointRole::kCheck;  // without a standard deviation plan only cannot be written
  options.grid_sigma_m.reset();
  const Block checks = Import(scene, options).block;
  EXPECT_EQ(checks.points.role[2], PointRole::kCheck);
  EXPECT_EQ(checks.points.role[3], PointRole::kTie);
  EXPECT_FALSE(checks.points.given_m[3].allFinite());
  EXPECT_FALSE(checks.looks.rejected(3));
}

TEST(ImportProductsTest, SeveralProductsMakeOneBlock) {
  SyntheticAnnotation first, second;
  second.swath = "IW3";
  const ImportedBlock imported =
      ImportProducts({Product(first), Product(second, "b.xml")}, {}, PlainOptions());
  EXPECT_EQ(imported.block.passes.size(), 2u);
  EXPECT_EQ(imported.block.points.size(), 18u);
  EXPECT_EQ(imported.block.looks.pass[17], 1u);
  EXPECT_THAT(
      test::MessageOf<InputError>([&] {
        return ImportProducts({Product(first), Product(first, "b.xml")}, {}, PlainOptions());
      }),
      HasSubstr("b.xml: id: 'S1A_IW2_VV_20221016T235950' is the id of another image"));
  PlainOptions named;
  named.pass_ids = {"one", "two"};
  EXPECT_EQ(ImportProducts({Product(first), Product(first)}, {}, named).block.passes[1].id, "two");
  named.pass_ids = {"one"};
  EXPECT_THROW(static_cast<void>(ImportProducts({Product(first), Product(first)}, {}, named)),
               InputError);
}

// The file has the same closed-form orbit, the annotation a wrong one.
TEST(ImportProductsTest, AnOrbitFileReplacesTheAnnotatedOrbit) {
  SyntheticAnnotation scene;
  const OrbitFile file = ParseOrbitFile(scene.OrbitXml(-50.0, 150.0), "o.EOF");
  OrbitFile early = ParseOrbitFile(scene.OrbitXml(-50.0, 60.0), "early.EOF");
  OrbitFile other = file;
  other.mission = "Sentinel-1B";
  Sentinel1Product product = Product(scene);
  for (OrbitState& state : product.orbit) state.position_m *= 1.001;
  PlainOptions options;
  options.orbit_margin_s = 25.0;
  const Block block = ImportProducts({product}, {early, other, file}, options).block;
  EXPECT_LT(LargestErrors(block).along_m, 5e-5);
  EXPECT_EQ(block.passes[0].path.start_s(), -30.0);  // the state before 0.25 - 25
  EXPECT_EQ(block.passes[0].path.end_s(), 50.0);     // the state after 20.25 + 25
  const std::string message = test::MessageOf<InputError>([&] {
    return ImportProducts({product}, {early, other}, options);
  });
  EXPECT_THAT(message,
              HasSubstr("a.xml: orbit: no orbit file covers this product (S1A, "
                        "2022-10-16T23:59:50Z to 2022-10-17T00:00:10Z); given: early.EOF"));
}

TEST(ImportProductsTest, ContradictingVelocitiesAreWarnedOf) {
  SyntheticAnnotation scene;
  scene.velocity_error_mps = 0.008;
  const ImportedBlock swinging = Import(scene);
  ASSERT_EQ(swinging.warnings.size(), 1u);
  EXPECT_THAT(swinging.warnings[0], HasSubstr("by up to 0.0080 m/s"));
  PlainOptions positions;
  positions.through = OrbitThrough::kPositions;
  const ImportedBlock calm = Import(scene, positions);
  EXPECT_TRUE(calm.warnings.empty());
  EXPECT_LT(LargestErrors(calm.block).along_m, 5e-5);
  EXPECT_GT(LargestErrors(swinging.block).along_m, 0.1);  // 0.008 / 7500 of 850 km is 0.9 m
}

// Closed form: four positions 40 s apart, a cubic in place of a circle; its error is a warning.
TEST(ImportProductsTest, PathsThatAreOffBetweenFewStatesAreAWarning) {
  Sentinel1Product product = Product(SyntheticAnnotation());
  for (std::size_t k = 1; k < 4; ++k) product.orbit[k] = product.orbit[4 * k];
  product.orbit.resize(4);
  const ImportedBlock orbit = ImportProducts({product}, {}, PlainOptions());
  EXPECT_TRUE(orbit.warnings.empty());
  EXPECT_LT(LargestErrors(orbit.block).along_m, 1e-3);
  PlainOptions positions;
  positions.through = OrbitThrough::kPositions;
  positions.max_misfit_m = 1000.0;
  const ImportedBlock cubic = ImportProducts({product}, {}, positions);
  EXPECT_GT(LargestErrors(cubic.block).along_m, 1.0);
  ASSERT_EQ(cubic.warnings.size(), 1U);
  EXPECT_THAT(cubic.warnings[0],
              testing::AllOf(HasSubstr("a.xml: the path between the states of the orbit (4 states, "
                                       "40 s apart) is off by some "),
                             HasSubstr("with --orbit-through states it is ")));
}

TEST(ImportProductsTest, StatesTooFarApartAreRefused) {
  Sentinel1Product product = Product(SyntheticAnnotation());
  for (std::size_t k = 10; k < product.orbit.size(); ++k) product.orbit[k].time.tai_whole += 3600;
  EXPECT_THAT(
      test::MessageOf<InputError>([&] { return ImportProducts({product}, {}, PlainOptions()); }),
      HasSubstr("a.xml: orbit: states 10 and 11 are 3610 s apart, 300 s at most is allowed"));
  PlainOptions fine;
  fine.orbit_step_s = 1e-3;
  EXPECT_THROW(static_cast<void>(Import(SyntheticAnnotation(), fine)), InputError);
}

TEST(ImportProductsTest, AGridOutsideTheOrbitIsRefused) {
  SyntheticAnnotation scene;
  scene.first_line_s = 105.0;
  EXPECT_THAT(
      test::MessageOf<InputError>([&] { return Import(scene); }),
      HasSubstr("geolocationGridPoint.azimuthTime: 20.000000 s after 2022-10-17T00:00:45Z is "
                "outside the orbit, which goes from -105.000000 to 15.000000 s"));
}

}  // namespace
}  // namespace sarblock
