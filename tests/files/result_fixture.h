// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"

#include <string>
#include <string_view>
#include <vector>

#include "support/csv_rows.h"
#include "support/folder_test.h"

namespace sarblock::test {

inline constexpr std::string_view kToml =
    "format = \"sarblock-block 1\"\nname = \"tiny\"\n[frame]\nkind = \"geocentric\"\n"
    "ellipsoid = \"WGS84\"\n[sigma]\nrange_m = 1.5\nazimuth_m = 2.5\n"
    "[[pass]]\nid = \"A\"\nlook = \"left\"\n[[pass]]\nid = \"B\"\nlook = \"left\"\n";
inline constexpr std::string_view kPaths =
    "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\n"
    "A,0,7000000,0,0,0,7500,0\nA,40,7000000,300000,0,0,7500,0\n"
    "B,0,7000000,0,9000,0,7500,0\nB,40,7000000,300000,9000,0,7500,0\n";
inline constexpr std::string_view kLooks =
    "pass,point,time_s,range_m,rejected\nA,P,12.5,800000,0\nB,P,12.5,800100,1\n"
    "A,\"Q,1\",13.5,800200,\n";
inline constexpr std::string_view kPoints =
    "point,role,x_m,y_m,z_m\nP,check,6371000.5,95000.25,1000.125\n";

/// A block of two points and a result filled by hand, with a folder to write it to.
class ResultFolderTest : public FolderTest {
 protected:
  ResultFolderTest() : block_(files::ReadBlockTexts({kToml, kPaths, kLooks, kPoints}).block) {
    options_.test_level = 0.975;
    options_.pairs = PairChoice::kAll;
    result_.status = AdjustStatus::kConverged;
    result_.assessment.verdict = Verdict::kAccepted;
    PointResults& points = result_.points;
    points.status = {PointStatus::kAdjusted, PointStatus::kTooFewLooks};
    points.reason = {"", "one look"};
    points.looks = {1, 1};
    points.position_m = {Eigen::Vector3d(6371000.5, 95000.25, 1000.125),
                         Eigen::Vector3d::Constant(kNotGiven)};
    points.covariance_m2 = {
        SymmetricEnu{9.0, 4.0, 2.25, 1.5, -0.5, 0.25},
        SymmetricEnu{kNotGiven, kNotGiven, kNotGiven, kNotGiven, kNotGiven, kNotGiven}};
    points.intersection_rad = {0.375, kNotGiven};
    result_.parameters = {{"A", "range.bias", "m", -3.5, 0.5, 20.0},
                          {"B", "range.bias", "m", 1.25, kNotGiven, kNotGiven}};
    result_.parameter_covariance = {{0, 0, 0.25}, {0, 1, -0.125}};
    result_.pairs = {{0, 1, Eigen::Vector3d(1.5, -2.5, 3.5), {1, 2, 3, 0.1, 0.2, 0.3}}};
    result_.looks.range_residual_m = {0.75, kNotGiven, -0.25};
    result_.looks.azimuth_residual_m = {-1.75, kNotGiven, 0.5};
    result_.looks.weight = {0.5f, 0.0f, 1.0f};
    result_.checks = {{0, Eigen::Vector3d(0.5, kNotGiven, -1.5), 3.75, 2}};
    result_.observation_count = 17;
    result_.parameter_count = 9;
    result_.sigma0_squared = 4.0;
    result_.test_redundancy = 8.0;
    result_.assessment.groups = {{"ranges", 24.0, 6.0, {0.5, 2.5}},
                                 {"all", 32.0, 8.0, {0.25, 2.25}}};
    result_.chi_square = {2.5, 17.5};
    result_.stages = {{"solve", 0.25, 80.0}, {"solve", 0.5, 90.0}};
    result_.warnings = {"of the result"};
    context_.warnings = {"of reading"};
    context_.stages = {{"read", 0.125, 40.0}};
  }
  // The cells of a row of a table, by column.
  std::vector<std::string> Row(const std::string& table,
                               std::size_t row,
                               const std::vector<TableColumn>& columns) const {
    CsvRows reader(folder_ / table, columns);
    for (std::size_t i = 0; i <= row; ++i) EXPECT_TRUE(reader.Next());
    std::vector<std::string> cells;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      EXPECT_TRUE(reader.Has(i)) << columns[i].name;
      cells.emplace_back(reader.Text(i));
    }
    return cells;
  }

  Block block_;
  AdjustOptions options_;
  AdjustResult result_;
  files::ResultContext context_;
};

}  // namespace sarblock::test
