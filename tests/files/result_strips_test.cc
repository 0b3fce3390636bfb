// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"

#include <cmath>

#include "adjust/finish.h"
#include "support/csv_rows.h"
#include "support/folder_test.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

class ResultStripsTest : public test::FolderTest {};

/// One straight pass along +x, 1200 m high, looking left; looks at ranges 1300 and 2000 m of points
/// on the plane z = 0: 500 and 1600 m beside the track.
Block StraightBlock() {
  return files::ReadBlockTexts(
             {"format = \"sarblock-block 1\"\nname = \"straight\"\n[frame]\nkind = \"local\"\n"
              "[sigma]\nrange_m = 1.5\nazimuth_m = 2.5\n"
              "[[pass]]\nid = \"A\"\nlook = \"left\"\nstart_s = 10\nend_s = 30\n",
              "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\n"
              "A,0,0,0,1200,100,0,0\nA,40,4000,0,1200,100,0,0\n",
              "pass,point,time_s,range_m\nA,P,12,1300\nA,Q,28,2000\n",
              std::nullopt})
      .block;
}

AdjustResult ResultOf(const Block& block) {
  AdjustResult result;
  result.points.status.assign(block.points.size(), PointStatus::kAdjusted);
  result.points.looks = {1, 1};
  result.points.position_m = {Eigen::Vector3d(1200, 500, 0), Eigen::Vector3d(2800, 1600, 0)};
  return result;
}

TEST(StripStationsTest, GiveThePathAndTheGroundBetweenTheLooks) {  // hand: 5-12-13 and 3-4-5
  const Block block = StraightBlock();
  const std::vector<StripStation> stations = SampleStrips(block, {}, ResultOf(block));
  ASSERT_EQ(stations.size(), kStripStations);
  const StripStation& first = stations.front();
  EXPECT_EQ(first.time_s, 10.0);
  EXPECT_EQ(first.strip_time, -1.0);
  EXPECT_NEAR((first.antenna_m - Eigen::Vector3d(1000, 0, 1200)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((first.near_m - Eigen::Vector3d(1000, 500, 0)).norm(), 0.0, 1e-6);
  EXPECT_NEAR((first.far_m - Eigen::Vector3d(1000, 1600, 0)).norm(), 0.0, 1e-6);
  EXPECT_NEAR((stations.back().far_m - Eigen::Vector3d(3000, 1600, 0)).norm(), 0.0, 1e-6);
  EXPECT_TRUE(first.correction_m.hasNaN());
}

TEST_F(ResultStripsTest, CorrectionsHaveTheBandOfTheirCovariance) {  // hand values
  const Block block = StraightBlock();
  PositionCorrection position;
  position.degree = 1;
  position.components = {false, false, true};
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  AdjustResult result = ResultOf(block);
  result.parameters = {{"A", "position.up.0", "m", 3.0, 2.0},
                       {"A", "position.up.1", "m", -0.5, 1.5}};
  result.parameter_covariance = {{0, 0, 4.0}, {0, 1, -1.0}, {1, 1, 2.25}};
  result.strips = SampleStrips(block, options.groups, result);
  files::WriteResult(folder_, block, options, result, {});
  const std::vector<TableColumn> columns{{"strip_time"},
                                         {"correction_up_m"},
                                         {"sigma_up_m"},
                                         {"correction_along_m"},
                                         {"sigma_along_m"}};
  test::CsvRows reader(folder_ / "strips.csv", columns);
  for (std::size_t k = 0; k < kStripStations; ++k) {
    ASSERT_TRUE(reader.Next());
    const double x = -1.0 + 2.0 * static_cast<double>(k) / (kStripStations - 1);
    EXPECT_NEAR(reader.Number(0), x, 1e-15);
    EXPECT_NEAR(reader.Number(1), 3.0 - 0.5 * x, 1e-12);
    EXPECT_NEAR(reader.Number(2), std::sqrt(4.0 - 2.0 * x + 2.25 * x * x), 1e-12);
    EXPECT_EQ(reader.Number(3), 0.0);
    EXPECT_EQ(reader.Number(4), 0.0);
  }
  EXPECT_FALSE(reader.Next());
}

TEST(FixedPathCovarianceTest, IsThatOfABlockWhosePathsAreKnown) {  // two routes
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  for (const std::size_t point : {0U, 4U, 7U})
    test::AddKnownPoint(point, {0.31, 0.47, 0.83}, &known);
  PositionCorrection position;
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  const auto adjust = [&](double prior_sigma_m) {
    position.prior_sigma_m.fill({prior_sigma_m});
    options.groups = {{"position", position, {}, false}};
    return Adjust(known.block, options);
  };
  const AdjustResult exact = adjust(1e-6);
  const AdjustResult result = adjust(3.7);
  const std::vector<SymmetricEnu>& fixed_m2 = result.points.fixed_path_covariance_m2;
  ASSERT_EQ(fixed_m2.size(), known.block.points.size());
  for (std::size_t point = 0; point < fixed_m2.size(); ++point) {
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_NEAR(fixed_m2[point][k], exact.points.covariance_m2[point][k], 1e-6);
    }
    EXPECT_LE(fixed_m2[point][2], result.points.covariance_m2[point][2]);
  }
}

TEST_F(ResultStripsTest, ChecksumsAreThoseOfTheStandard) {  // FIPS 180-4, appendix B.1
  EXPECT_EQ(files::Sha256OfFile(Put("abc", "abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(files::Sha256OfFile(Put("empty", "")),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST_F(ResultStripsTest, InputsAreTheFilesOfTheBlockThatAreThere) {
  Put("block.toml", "abc");
  Put("observations.csv.gz", "abc");
  Put("truth.csv", "not read");
  const std::vector<files::InputFile> files = files::ListInputFiles(folder_, {});
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0].name, "block.toml");
  EXPECT_EQ(files[1].name, "observations.csv.gz");
  EXPECT_EQ(files[1].bytes, 3u);
}

}  // namespace
}  // namespace sarblock
