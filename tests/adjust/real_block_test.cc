// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/files/block_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "model/problem.h"
#include "support/dense_normals.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

namespace fs = std::filesystem;

/// Rows of numbers after the header; the first column of a row is its name.
struct Row {
  std::string name;
  std::vector<double> values;
};
std::vector<Row> ReadRows(const fs::path& file) {
  std::ifstream in(file);
  std::vector<Row> rows;
  std::string line, cell;
  while (std::getline(in, line) && line.starts_with('#')) continue;  // then the header
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    Row row;
    std::getline(cells, row.name, ',');
    while (std::getline(cells, cell, ',')) row.values.push_back(std::stod(cell));
    rows.push_back(std::move(row));
  }
  return rows;
}

/// The shipped block; its README says where it comes from.
fs::path Cabeus() { return fs::path(SARBLOCK_DATASETS) / "real/cabeus"; }

// Real data (three Mini-RF strips over Cabeus): counts by hand, and the dense least-squares
// solution as the second route.
TEST(RealBlockTest, CabeusIsAcceptedWithResidualsOfSevenMetres) {
  const files::BlockFile file = files::ReadBlock(Cabeus());
  const AdjustResult result = Adjust(file.block, file.adjust);
  EXPECT_TRUE(result.usable());
  EXPECT_EQ(result.looks_used, 330U - 43U);
  // Looks and 49 control points; 118 points that were solved and three constants a pass.
  EXPECT_EQ(result.redundancy(), 2.0 * 287.0 + 3.0 * 49.0 - 3.0 * 118.0 - 9.0);
  AdjustmentProblem problem(file.block, file.adjust.groups);
  const BlockState state = test::StateOf(result, &problem);
  test::ExpectDenseLeastSquares(problem, state, result, 1e-5);
  EXPECT_NEAR(result.sigma0_squared, 2.0 * result.final_cost / 358.0, 1e-12);
  EXPECT_TRUE(result.chi_square_passed);
}

// A blunder planted in real data, in one look after another: a range made 300 m longer, 43 times
// its standard deviation, is named in every look whose redundancy makes that certain, and located
// in some. Parallel strips leave the others as one of two or three.
TEST(RealBlockTest, ARangeShiftedBy300MetresIsFoundInCabeus) {
  files::BlockFile file = files::ReadBlock(Cabeus());
  file.adjust.quality.snooping = Snooping::kIterative;
  file.adjust.quality.family_wise = FamilyWise::kSidak;
  const AdjustResult before = Adjust(file.block, file.adjust);
  std::size_t shifted = 0, promised = 0, named = 0, located = 0;
  for (std::uint64_t look = 0; look < file.block.looks.size(); look += 29) {
    if (before.looks.rejected[look] != 0) continue;
    const double sigma_m = file.block.SigmaOf(look).range_m;
    const auto r = static_cast<double>(before.quality.redundancy[0][look]);
    ++shifted;
    // Eight sigmas beyond a critical value of four and a half: power 0.9998.
    const bool certain = 300.0 / sigma_m * std::sqrt(r) > 8.0;
    promised += certain ? 1U : 0U;
    file.block.looks.range_m[look] += 300.0;
    const AdjustResult result = Adjust(file.block, file.adjust);
    file.block.looks.range_m[look] -= 300.0;
    bool in_finding = false;
    for (const BlunderFinding& finding : result.snooping->findings) {
      const bool here =
          std::find(finding.looks.begin(), finding.looks.end(), look) != finding.looks.end();
      in_finding = in_finding || here;
      located += here && finding.located() ? 1U : 0U;
    }
    named += in_finding ? 1U : 0U;
    EXPECT_TRUE(in_finding || !certain) << look << " r " << r << " sigma " << sigma_m;
  }
  EXPECT_GT(promised, 0U) << shifted;
  EXPECT_GT(located, 0U);
  RecordProperty("shifted", static_cast<int>(shifted));
  RecordProperty("named", static_cast<int>(named));
}

// With 7 m for both the global test passes, but the looks are better and the heights held worse
// than said. Closed form, which has one solution: at the end v'Pv = r of ranges and of azimuths.
TEST(RealBlockTest, CabeusSaysWhatItsLooksAreWorth) {
  files::BlockFile file = files::ReadBlock(Cabeus());
  file.adjust.variance_components = VarianceComponents::kRangeAzimuth;
  const AdjustResult result = Adjust(file.block, file.adjust);
  EXPECT_TRUE(result.usable());
  ASSERT_TRUE(result.variance_components.has_value());
  EXPECT_TRUE(result.variance_components->before.passed);
  EXPECT_FALSE(result.chi_square_passed);
  const std::vector<VarianceComponent>& found = result.variance_components->components;
  ASSERT_EQ(found.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    const ObservationGroup& group = result.assessment.groups[k];
    EXPECT_EQ(group.name, k == 0 ? "ranges" : "azimuths");
    // To the hundredth of its standard deviation where the estimation ends.
    EXPECT_NEAR(group.factor(), 1.0, 0.01 * found[k].factor_deviation / found[k].factor);
    EXPECT_LT(found[k].sigma_after(), 7.0);
  }
}

// An independent program's published answer for the same observations and weights: ISIS jigsaw,
// offsets of each pass in J2000 axes with standard deviations scaled by its sigma0.
TEST(RealBlockTest, CabeusAgreesWithJigsaw) {
  files::BlockFile file = files::ReadBlock(Cabeus());
  // East and north of the free points are where the block's own weights leave them.
  const AdjustResult start = Adjust(file.block, file.adjust);
  Block& block = file.block;
  const std::vector<Row> reference = ReadRows(Cabeus() / "jigsaw.csv");
  ASSERT_EQ(reference.size(), 3U);
  block.looks.azimuth_sigma.assign(block.looks.size(), kNotGiven);
  for (std::uint64_t look = 0; look < block.looks.size(); ++look) {
    const Pass& pass = block.passes[block.looks.pass[look]];
    const auto row = std::find_if(
        reference.begin(), reference.end(), [&](const Row& one) { return one.name == pass.id; });
    const double speed_mps = pass.path.At(block.looks.time_s[look])->velocity_mps.norm();
    block.looks.azimuth_sigma[look] =
        row->values[1] * pass.wavelength_m * block.looks.range_m[look] / (2.0 * speed_mps);
    block.passes[block.looks.pass[look]].sigma.range_m = row->values[0];
  }
  for (const Row& row : ReadRows(Cabeus() / "jigsaw_heights.csv")) {
    const std::uint32_t point = block.points.ids.Find(row.name);
    ASSERT_NE(point, IdTable::kNone);
    block.points.role[point] = PointRole::kControl;
    block.points.given_m[point] =
        block.frame.AtHeight(start.points.position_m[point], row.values[0]);
    KnownPosition known{point, {false, false, true}, Eigen::Matrix3d::Zero()};
    known.covariance_enu_m2(2, 2) = 0.01;
    block.points.known.push_back(known);
  }
  std::sort(block.points.known.begin(),
            block.points.known.end(),
            [](const KnownPosition& a, const KnownPosition& b) { return a.point < b.point; });
  file.adjust.scale_by_posterior = true;
  const AdjustResult result = Adjust(file.block, file.adjust);
  EXPECT_TRUE(result.usable());
  EXPECT_EQ(result.redundancy(), 358.0 + 69.0);  // a height more for each free point
  ASSERT_EQ(result.parameters.size(), 9U);
  Eigen::MatrixXd covariance(9, 9);
  ASSERT_EQ(result.parameter_covariance.size(), 45U);
  for (const ParameterCovariance& c : result.parameter_covariance) {
    covariance(c.a, c.b) = covariance(c.b, c.a) = c.covariance;
  }
  for (const Row& row : reference) {
    ASSERT_EQ(row.values.size(), 17U);
    Eigen::Index first = 0;
    while (result.parameters[static_cast<std::size_t>(first)].owner != row.name) first += 3;
    const Eigen::Map<const Eigen::Vector3d> offset_m(row.values.data() + 2);
    const Eigen::Map<const Eigen::Vector3d> sigma_m(row.values.data() + 5);
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> fixed_from_j2000(
        row.values.data() + 8);
    Eigen::Vector3d ours_m;
    for (Eigen::Index k = 0; k < 3; ++k) {
      ours_m[k] = result.parameters[static_cast<std::size_t>(first + k)].value;
    }
    ours_m = (fixed_from_j2000.transpose() * ours_m).eval();
    const Eigen::Matrix3d ours_m2 =
        fixed_from_j2000.transpose() * covariance.block<3, 3>(first, first) * fixed_from_j2000;
    for (Eigen::Index k = 0; k < 3; ++k) {
      EXPECT_NEAR(ours_m[k], offset_m[k], 0.15 * sigma_m[k]) << row.name << " axis " << k;
      EXPECT_NEAR(std::sqrt(ours_m2(k, k)), sigma_m[k], 0.01 * sigma_m[k]) << row.name;
    }
  }
}

}  // namespace
}  // namespace sarblock
