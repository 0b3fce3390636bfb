// SPDX-License-Identifier: Apache-2.0
// Looks given by line and pixel, standard deviations in lines and pixels.
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"

#include <array>
#include <cmath>
#include <string>

#include "support/csv_rows.h"
#include "support/folder_test.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

const std::string kHead =
    "format = \"sarblock-block 1\"\n"              // 1
    "[frame]\nkind = \"local\"\n"                  // 2, 3
    "[sigma]\nrange_m = 1.25\nazimuth_m = 0.75\n"  // 4 to 6
    "[[pass]]\nid = \"A\"\nlook = \"left\"\n";     // 7 to 9
const std::string kSlant =
    "[pass.image]\npresentation = \"slant\"\nfirst_line_s = 1.5\nline_interval_s = 0.004\n"
    "near_range_m = 8500.5\nrange_spacing_m = 2.5\n";
const std::string kGround =
    "[pass.image]\npresentation = \"ground\"\nfirst_line_s = 1.5\nline_interval_s = 0.004\n"
    "range_spacing_m = 4.0\nground_range = [8500.5, 0.25, 1e-5]\n";
const std::string kImagePaths =
    "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\n"
    "A,0,0,0,8000.5,210.5,0,0\nA,30.25,6367.625,0,8000.5,210.5,0,0\n";

files::BlockFile ReadImageBlock(const std::string& image, const std::string& looks) {
  return files::ReadBlockTexts({kHead + image, kImagePaths, looks, std::nullopt});
}

TEST(ImageLooksTest, LineAndPixelBecomeTimeAndRange) {  // hand arithmetic
  const std::string looks =
      "pass,point,line,pixel,time_s,range_m\nA,P,100.5,40.25,,\nA,Q,,,2.5,9000\n";
  const Block slant = ReadImageBlock(kSlant, looks).block;
  EXPECT_DOUBLE_EQ(slant.looks.time_s[0], 1.5 + 100.5 * 0.004);
  EXPECT_DOUBLE_EQ(slant.looks.range_m[0], 8500.5 + 40.25 * 2.5);
  EXPECT_EQ(slant.looks.time_s[1], 2.5);
  EXPECT_EQ(slant.looks.range_m[1], 9000.0);
  const Block ground = ReadImageBlock(kGround, "pass,point,line,pixel\nA,P,100.5,40.25\n").block;
  EXPECT_DOUBLE_EQ(ground.looks.range_m[0], 8500.5 + 0.25 * 161.0 + 1e-5 * 161.0 * 161.0);
}

TEST(ImageLooksTest, StandardDeviationsInPixelsBecomeMetresAndSeconds) {  // hand arithmetic
  const std::string looks =
      "pass,point,line,pixel,line_sigma_px,pixel_sigma_px\nA,P,100.5,40.25,,\nA,Q,90,30,0.5,0.25\n";
  const std::string sigma = "line_sigma_px = 0.125\npixel_sigma_px = 0.3\n";
  const Block slant = ReadImageBlock(kSlant + sigma, looks).block;
  EXPECT_DOUBLE_EQ(slant.SigmaOf(0).range_m, 0.3 * 2.5);
  EXPECT_DOUBLE_EQ(slant.SigmaOf(0).azimuth, 0.125 * 0.004);
  EXPECT_EQ(slant.SigmaOf(0).azimuth_unit, AzimuthUnit::kSeconds);
  EXPECT_DOUBLE_EQ(slant.SigmaOf(1).range_m, 0.25 * 2.5);
  EXPECT_DOUBLE_EQ(slant.SigmaOf(1).azimuth, 0.5 * 0.004);
  const Block ground =
      ReadImageBlock(kGround + sigma, looks).block;  // dR/dg = 0.25 + 2e-5 g at 161 and 120 m
  EXPECT_NEAR(ground.SigmaOf(0).range_m, 0.3 * 4.0 * 0.25322, 1e-12);
  EXPECT_NEAR(ground.SigmaOf(1).range_m, 0.25 * 4.0 * 0.2524, 1e-12);
}

class ImageFilesTest : public test::FolderTest {};

TEST_F(ImageFilesTest, WrittenRastersReadBackToTheSame) {  // round trip, equal to the last bit
  const std::string bursts =
      "epoch_utc = \"2022-10-16T01:50:44Z\"\n"
      "[pass.image]\npresentation = \"slant\"\nburst_start_s = [0.1, 2.857]\nlines_per_burst = "
      "700\n"
      "line_interval_s = 0.0020555\nnear_range_m = 8500.5\nrange_spacing_m = 2.3\n";
  const std::string polynomials =
      "[pass.image]\npresentation = \"ground\"\nfirst_line_s = 0.1\nline_interval_s = 0.0020555\n"
      "near_range_m = -3.5\nrange_spacing_m = 10\n"
      "[[pass.image.ground_range]]\ntime_s = 0.3\norigin_m = 1.5\ncoefficients = [8500.1, 0.3, "
      "1e-7]\n"
      "[[pass.image.ground_range]]\ntime_s = 9.3\ncoefficients = [8501.7, 0.31]\n";
  for (const std::string& image : {bursts, polynomials}) {
    const files::BlockFile file = ReadImageBlock(image, "pass,point,line,pixel\nA,P,100.5,40.25\n");
    files::WriteBlock(folder_ / "block", file.block, file.adjust);
    const Block again = files::ReadBlock(folder_ / "block").block;
    const ImageGrid &a = *file.block.passes[0].image, &b = *again.passes[0].image;
    EXPECT_EQ(again.passes[0].epoch_utc, file.block.passes[0].epoch_utc);
    EXPECT_EQ(a.presentation, b.presentation);
    EXPECT_EQ(a.first_line_s, b.first_line_s);
    EXPECT_EQ(a.line_interval_s, b.line_interval_s);
    EXPECT_EQ(a.near_range_m, b.near_range_m);
    EXPECT_EQ(a.range_spacing_m, b.range_spacing_m);
    EXPECT_EQ(a.burst_start_s, b.burst_start_s);
    EXPECT_EQ(a.lines_per_burst, b.lines_per_burst);
    ASSERT_EQ(a.ground_range.size(), b.ground_range.size());
    for (std::size_t k = 0; k < a.ground_range.size(); ++k) {
      EXPECT_EQ(a.ground_range[k].time_s, b.ground_range[k].time_s);
      EXPECT_EQ(a.ground_range[k].origin_m, b.ground_range[k].origin_m);
      EXPECT_EQ(a.ground_range[k].coefficients, b.ground_range[k].coefficients);
    }
    EXPECT_EQ(again.looks.time_s, file.block.looks.time_s);
    EXPECT_EQ(again.looks.range_m, file.block.looks.range_m);
  }
}

// Hand arithmetic: a straight path at 210.5 m/s, so that e_d falls by that rate; half a line is
// 0.5 * 0.004 s * 210.5 m/s = 0.421 m, a pixel 2.5 m. A pass without an image has empty cells.
TEST_F(ImageFilesTest, ResidualsAreGivenInLinesAndPixels) {
  const std::string second = "[[pass]]\nid = \"B\"\nlook = \"left\"\n";
  const std::string paths =
      kImagePaths + "B,0,0,0,8000.5,210.5,0,0\nB,30.25,6367.625,0,8000.5,210.5,0,0\n";
  const std::string looks =
      "pass,point,line,pixel,time_s,range_m\nA,P,100.5,40.25,,\nB,P,,,2.5,9000\n";
  const files::BlockFile file =
      files::ReadBlockTexts({kHead + kSlant + second, paths, looks, std::nullopt});
  AdjustResult result;
  result.points.status = {PointStatus::kAdjusted};
  result.points.reason = {""};
  result.points.looks = {2};
  result.points.position_m = {Eigen::Vector3d(402.5, 3000.25, 12.5)};
  result.points.intersection_rad = {0.1};
  result.looks.range_residual_m = {-0.625, 0.1};
  result.looks.azimuth_residual_m = {0.421, 0.1};
  files::WriteResult(folder_, file.block, file.adjust, result, files::ResultContext{});
  const std::vector<TableColumn> columns{
      {"pass"}, {"line_residual_px"}, {"pixel_residual_px"}, {"line"}, {"pixel"}};
  test::CsvRows reader(folder_ / "residuals.csv", columns);
  ASSERT_TRUE(reader.Next());
  EXPECT_NEAR(reader.Number(1), 0.5, 1e-12);
  EXPECT_NEAR(reader.Number(2), -0.25, 1e-12);
  EXPECT_NEAR(reader.Number(3), 100.5, 1e-9);
  EXPECT_NEAR(reader.Number(4), 40.25, 1e-9);
  ASSERT_TRUE(reader.Next());
  for (std::size_t column = 1; column < 5; ++column) EXPECT_FALSE(reader.Given(column));
}

}  // namespace
}  // namespace sarblock
