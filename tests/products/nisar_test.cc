// SPDX-License-Identifier: Apache-2.0
// Products of NISAR written by nisar_file.h: a closed form is the truth.
#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>

#include "fuzz/nisar_fuzz_targets.h"
#include "products/image_table.h"
#include "products/import.h"
#include "support/folder_test.h"
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using test::MessageOf;
using test::NisarFile;
using testing::HasSubstr;

class NisarTest : public test::FolderTest {
 protected:
  std::string Written(const NisarFile& made = {}, std::string_view edits = "") const {
    const std::filesystem::path file = folder_ / "rslc.h5";
    made.Write(file);
    fuzz::ContainerEdit(file, edits);
    return file;
  }
  std::string Refusal(std::string_view edits) const {
    const std::string file = Written({}, edits);
    return MessageOf<InputError>(
        [&] { return ImportProducts({ReadNisar(file)}, {}, ImportOptions{}); });
  }
};

TEST_F(NisarTest, TheReaderGivesWhatTheFileWasMadeOf) {
  for (const bool variable : {false, true}) {
    NisarFile made;
    made.variable_text = variable;
    made.compressed = variable;
    made.product = variable ? "SLC" : "RSLC";
    const NisarProduct product = ReadNisar(Written(made));
    EXPECT_EQ(product.band, "LSAR");
    EXPECT_EQ(product.orbit_type, "Synthetic");
    EXPECT_EQ(product.side, LookSide::kLeft);
    EXPECT_DOUBLE_EQ(product.wavelength_m, 299792458.0 / 1.2575e9);
    EXPECT_EQ(product.lines, 1500U);
    EXPECT_EQ(product.samples, 2000U);
    EXPECT_EQ(UtcMicroseconds(product.first_line), "2022-10-16T23:59:50.250000");
    EXPECT_EQ(UtcMicroseconds(product.last_line), "2022-10-17T00:00:05.240000");
    EXPECT_NEAR(product.line_interval_s, 0.01, 1e-13);
    EXPECT_EQ(product.near_range_m, 850123.5);
    EXPECT_NEAR(product.range_spacing_m, 5.25, 1e-12);
    ASSERT_EQ(product.orbit.size(), 13U);
    EXPECT_EQ(UtcText(product.orbit[1].time), "2022-10-16T23:59:10Z");
    EXPECT_EQ(product.orbit[1].position_m, NisarFile::Position_m(10.0));
    EXPECT_EQ(product.orbit[1].velocity_mps, NisarFile::Velocity_mps(10.0));
    const NisarGrid& grid = product.grid;
    EXPECT_EQ(grid.longitude_deg.size(), 12U);
    const Frame frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
    const Eigen::Vector3d place =
        frame.FrameFromGeodetic({grid.latitude_deg[grid.Index(1, 2, 0)] * kRadPerDeg,
                                 grid.longitude_deg[grid.Index(1, 2, 0)] * kRadPerDeg,
                                 grid.height_m[1]});
    EXPECT_LT((place - NisarFile::Ground_m(65.5, 849000.0, 1500.25)).norm(), 1e-6);
  }
}

TEST_F(NisarTest, ThePassIsTheClosedForm) {
  const Block block = ImportProducts({ReadNisar(Written())}, {}, ImportOptions{}).block;
  ASSERT_EQ(block.passes.size(), 1U);
  const Pass& pass = block.passes[0];
  EXPECT_EQ(pass.id, "NISAR_LSAR_A_20221016T235950");
  EXPECT_EQ(pass.epoch_utc, "2022-10-16T23:59:50Z");
  EXPECT_EQ(block.frame.ellipsoid().name, "WGS84");
  // The polynomial of degree 7 through states 10 s apart.
  for (const double seconds : {50.0, 53.21, 61.5}) {
    const Motion motion = *pass.path.At(seconds - 50.0);
    EXPECT_LT((motion.position_m - NisarFile::Position_m(seconds)).norm(), 1e-5);
    EXPECT_LT((motion.velocity_mps - NisarFile::Velocity_mps(seconds)).norm(), 1e-5);
  }
  const RadarCoordinates radar = *RadarFromImage(*pass.image, {731.25, 1012.5});
  EXPECT_NEAR(radar.time_s, 0.25 + 7.3125, 1e-9);
  EXPECT_NEAR(radar.range_m, 850123.5 + 5315.625, 1e-8);
  EXPECT_NEAR(pass.sigma.range_m, 5.25 / std::sqrt(12.0), 1e-12);
  EXPECT_NEAR(pass.sigma.azimuth, 0.01 / std::sqrt(12.0), 1e-12);
  EXPECT_EQ(pass.sigma.azimuth_unit, AzimuthUnit::kSeconds);
}

TEST_F(NisarTest, AGoodGridFitsAndBecomesWhatIsAskedFor) {
  const NisarProduct product = ReadNisar(Written());
  ImportOptions options;
  const ImportedBlock checked = ImportProducts({product}, {}, options);
  EXPECT_TRUE(checked.faults.empty());
  EXPECT_TRUE(checked.warnings.empty());
  EXPECT_EQ(checked.products[0].good, 12U);
  EXPECT_LT(checked.products[0].largest_range_m, 1e-5);
  EXPECT_LT(checked.products[0].largest_along_m, 1e-3);
  ASSERT_EQ(checked.block.looks.size(), 12U);
  EXPECT_EQ(checked.block.points.known.size(), 12U);
  EXPECT_EQ(checked.block.points.ids[0], "NISAR_LSAR_A_20221016T235950:1:1:-100.5");
  options.grid = std::nullopt;
  const ImportedBlock none = ImportProducts({product}, {}, options);
  EXPECT_EQ(none.block.points.size(), 0U);
  EXPECT_EQ(none.products[0].good, 12U);
}

TEST_F(NisarTest, ARepeatedAzimuthTimeOfTheGridIsNamed) {
  NisarFile made;
  made.repeated_row = true;
  ImportOptions options;
  const ImportedBlock imported = ImportProducts({ReadNisar(Written(made))}, {}, options);
  ASSERT_EQ(imported.faults.size(), 1U);
  const FaultyRow& row = imported.faults[0];
  EXPECT_TRUE(row.same_time);
  EXPECT_EQ(row.row, 2U);
  EXPECT_EQ(row.points, 4U);
  EXPECT_EQ(row.of, 4U);
  // By the closed form: places of the second row as seen at the time of the first.
  double expected_m = std::numeric_limits<double>::infinity();
  for (const double height_m : NisarFile::kHeights_m) {
    for (const double range_m : NisarFile::kColumns_m) {
      const Eigen::Vector3d sight_m =
          NisarFile::Ground_m(NisarFile::kRows_s[1], range_m, height_m) -
          NisarFile::Position_m(NisarFile::kRows_s[0]);
      const Eigen::Vector3d u = NisarFile::Velocity_mps(NisarFile::kRows_s[0]).normalized();
      expected_m = std::min(expected_m, u.dot(sight_m));
    }
  }
  EXPECT_NEAR(row.along_m[0], expected_m, 1e-3);
  EXPECT_THAT(Describe(row), HasSubstr("rslc.h5: geolocationGrid line -50 (row 2): 4 of 4 points"));
  EXPECT_THAT(Describe(row), HasSubstr("its azimuth time is that of the row before; their looks"));
  std::size_t rejected = 0;
  for (std::size_t i = 0; i < imported.block.looks.size(); ++i) {
    rejected += imported.block.looks.rejected(i) ? 1U : 0U;
  }
  EXPECT_EQ(rejected, 4U);
  options.grid = std::nullopt;
  const ImportedBlock none = ImportProducts({ReadNisar(Written(made))}, {}, options);
  EXPECT_THAT(Describe(none.faults[0]), testing::Not(HasSubstr("looks")));
}

TEST_F(NisarTest, ALookSideThatTheGridContradictsIsAWarning) {
  NisarFile made;
  made.look = "RIGHT";
  const ImportedBlock imported = ImportProducts({ReadNisar(Written(made))}, {}, ImportOptions{});
  EXPECT_EQ(imported.block.passes[0].side, LookSide::kRight);
  EXPECT_THAT(imported.warnings, testing::Contains(HasSubstr("lies to the left of the flight")));
}

TEST_F(NisarTest, WhatIsMissingOrMakesNoSenseIsRefusedWithItsPath) {
  const std::string root = "/science/LSAR/RSLC", orbit = root + "/metadata/orbit",
                    grid = root + "/metadata/geolocationGrid",
                    lines = root + "/swaths/zeroDopplerTime", band = root + "/swaths/frequencyA";
  const auto expect = [&](const std::string& edits, const std::string& message) {
    EXPECT_THAT(Refusal(edits), HasSubstr(message)) << edits;
  };
  expect("delete " + root, "/science/LSAR/RSLC: is missing: an RSLC of NISAR is needed");
  expect("delete /science/LSAR/identification/lookDirection", "lookDirection: is missing");
  expect("word /science/LSAR/identification/lookDirection ahead",
         "must be left or right, got 'ahead'");
  expect("delete " + band, "frequencyA: is missing; --frequency takes the other one");
  expect("units " + lines + " days", "zeroDopplerTime (units): must be 'seconds since '");
  expect("units " + lines + " seconds since 1970-01-01 00:00:00", "a UTC time from 1972 on, got");
  expect("set " + lines + " 700 5", "zeroDopplerTime[700]: 5 is not evenly spaced");
  expect("set " + lines + " 1499 5", "zeroDopplerTime: must increase");
  expect("set " + band + "/slantRange 3 nan", "slantRange: holds nan, numbers are needed");
  expect("set " + band + "/processedCenterFrequency 0 -2", "must be a number above 0, got -2");
  expect("matrix " + band + "/processedCenterFrequency 2", "has 2 dimensions, 0 is needed");
  expect("words " + orbit + "/time 13", "orbit/time (units): the attribute is missing");
  expect("floats " + orbit + "/position 39", "has 1 dimensions, 2 is needed");
  expect("matrix " + orbit + "/position 13", "position: is 13 x 2, 13 x 3 is needed");
  expect("set " + orbit + "/time 4 3620", "state 5: its time 2022-10-16T23:59:20Z is not after");
  expect("set " + orbit + "/time 12 99999", "states 12 and 13 are 96289 s apart");
  expect("units " + orbit + "/time seconds since 2022-10-17 00:00:00",
         "covers 3610.000 to 3730.000 s after 2022-10-16T23:59:50Z");
  expect("cube " + grid + "/coordinateX 5", "coordinateX: is 5 x 2 x 2, 2 x 3 x 2 is needed");
  expect("set " + grid + "/coordinateY 7 95", "95 is not between -90 and 90 degrees");
  expect("set " + grid + "/epsg 0 32610", "epsg: must be 4326");
  expect("set " + grid + "/zeroDopplerTime 2 999", "is outside the orbit, which goes from");
  expect("link " + orbit + "/time " + lines, "orbit/time: is a link, the data themselves");
  expect("external " + orbit + "/time 13", "units): the attribute is missing");
  const std::string no_grid = "delete " + grid + "\n";
  expect(no_grid + "units " + orbit + "/time seconds since 2022-10-16 22:59:55",
         "the image 0.250 to");
}

TEST_F(NisarTest, ClaimsBeyondTheFileAreRefusedBeforeMemoryIsTaken) {
  const std::string root = "/science/LSAR/RSLC", band = root + "/swaths/frequencyA/slantRange";
  EXPECT_THAT(Refusal("extend " + band + " 1000000000000"),
              HasSubstr("has 1000000000000 values, at most 10000000 are allowed"));
  EXPECT_THAT(Refusal("extend " + band + " 9000000"),
              HasSubstr("has 9000000 values, not all of which are in the file"));
  EXPECT_THAT(Refusal("cut 8"), HasSubstr("cannot be opened as an HDF5 file"));
  const std::string whole = Written();
  const auto bytes = std::filesystem::file_size(whole);
  for (const auto part : {bytes / 4, bytes / 2, bytes - 9}) {
    EXPECT_THAT(Refusal("cut " + std::to_string(part)), HasSubstr("rslc.h5: "));
  }
}

TEST_F(NisarTest, DamagedFilesOfTheCorpusAreReadOrRefused) {
  std::size_t files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(SARBLOCK_FUZZ_CORPUS) / "nisar")) {
    EXPECT_NO_THROW(fuzz::Nisar(Content(entry.path()), folder_)) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 40U);
}

/// Products of others; skipped where they are not beside the project. Their grids have two rows,
/// the second one with the time of the first: its points are ahead by what lies between both.
TEST(RealNisarTest, GridsThatRepeatATimeAreNamed) {
  const std::filesystem::path folder = std::filesystem::path(SARBLOCK_SHARED_DATA) / "nisar";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  const auto check = [&](const char* name, std::size_t points) {
    const ImportedBlock imported = ImportProducts({ReadNisar(folder / name)}, {}, ImportOptions{});
    EXPECT_EQ(imported.products[0].grid_points, 2 * points);
    EXPECT_EQ(imported.products[0].good, points);  // of the first row, within a millimetre
    EXPECT_LT(imported.products[0].largest_range_m, 1e-3);
    EXPECT_LT(imported.products[0].largest_along_m, 1e-3);
    ASSERT_EQ(imported.faults.size(), 1U);
    EXPECT_TRUE(imported.faults[0].same_time);
    EXPECT_EQ(imported.faults[0].points, points);
    const Block& block = imported.block;
    double expected_m = std::numeric_limits<double>::infinity();
    for (std::size_t first = 0; first < points; ++first) {
      const Eigen::Vector3d v_mps =
          block.passes[0].path.At(block.looks.time_s[first])->velocity_mps;
      const Eigen::Vector3d ahead_m =
          block.points.given_m[first + points] - block.points.given_m[first];
      expected_m = std::min(expected_m, v_mps.normalized().dot(ahead_m));
    }
    EXPECT_NEAR(imported.faults[0].along_m[0], expected_m, 1e-3);
  };
  check("calib_slc_pass1_20mhz.h5", 480);
  check("REE_RSLC_out17.h5", 40);
}

}  // namespace
}  // namespace sarblock
