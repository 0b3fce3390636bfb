// SPDX-License-Identifier: Apache-2.0
// Blocks of arrays in memory: hand values, and what is refused.
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/threads.h"
#include "support/folder_test.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::MessageOf;
using testing::ElementsAre;

constexpr const char* kArraysToml =
    "format = \"sarblock-block 1\"\n"
    "name = \"arrays\"\n"
    "[frame]\n"
    "kind = \"local\"\n"
    "[sigma]\n"
    "range_m = 0.75\n"
    "azimuth_m = 1.25\n"
    "[[pass]]\n"
    "id = \"A\"\n"
    "look = \"left\"\n"
    "[[pass]]\n"
    "id = \"B\"\n"
    "look = \"left\"\n";

std::shared_ptr<IdTable> IdsOf(const std::vector<std::string>& names) {
  auto ids = std::make_shared<IdTable>();
  for (const std::string& name : names) ids->Append(name);
  return ids;
}

/// The columns that a test changes before it reads them.
struct GivenArrays {
  std::shared_ptr<IdTable> passes = IdsOf({"B", "A"});  // in another order than block.toml has them
  std::shared_ptr<IdTable> points = IdsOf({"P9", "P1", "P5"});
  std::vector<std::uint32_t> state_pass{1, 1, 0, 0};
  std::vector<double> state_time_s{0.0, 40.5, 0.0, 40.5};
  std::vector<double> state_x_m{-3000.5, 5100.25, -3000.5, 5100.25};
  std::vector<double> state_y_m{0.0, 0.0, -6000.0, -6000.0};
  std::vector<double> state_z_m = std::vector<double>(4, 8000.0);
  std::vector<double> speed_mps = std::vector<double>(4, 200.0);
  std::vector<double> zero = std::vector<double>(4, 0.0);
  std::vector<std::uint32_t> look_pass{0, 1, 0};
  std::vector<std::uint32_t> look_point{2, 2, 0};
  std::vector<double> time_s{20.25, 19.75, 7.5};
  std::vector<double> range_m{17000.5, 12500.25, 16800.125};
  std::vector<double> squint_deg{kNotGiven, 1.5, kNotGiven};

  [[nodiscard]] files::BlockArrays Arrays() const {
    return {kArraysToml,
            {{"trajectories",
              {{"pass", {}, passes, state_pass},
               {"time_s", state_time_s},
               {"x_m", state_x_m},
               {"y_m", state_y_m},
               {"z_m", state_z_m},
               {"vx_mps", speed_mps},
               {"vy_mps", zero},
               {"vz_mps", zero}}},
             {"observations",
              {{"pass", {}, passes, look_pass},
               {"point", {}, points, look_point},
               {"time_s", time_s},
               {"range_m", range_m},
               {"squint_deg", squint_deg}}}}};
  }
  [[nodiscard]] Block Read() const { return files::ReadBlockArrays(Arrays()).block; }
  [[nodiscard]] std::string Refusal() const {
    return MessageOf<InputError>([&] { return files::ReadBlockArrays(Arrays()); });
  }
};

TEST(ReadBlockArraysTest, TextsAreFoundByTheirIndicesAndLooksSortedByPoint) {  // hand values
  const Block block = GivenArrays().Read();
  ASSERT_EQ(block.passes.size(), 2U);
  EXPECT_EQ(block.passes[0].id, "A");
  EXPECT_EQ(block.passes[0].path.states().back().position_m.y(), 0.0);
  EXPECT_EQ(block.passes[1].path.states().back().position_m.y(), -6000.0);
  ASSERT_EQ(block.points.size(), 2U);  // P1 is seen by none, and no table has it
  EXPECT_EQ(block.points.ids[0], "P5");
  EXPECT_EQ(block.points.ids[1], "P9");
  EXPECT_THAT(block.looks.offsets, ElementsAre(0U, 2U, 3U));
  EXPECT_THAT(block.looks.pass, ElementsAre(0U, 1U, 1U));
  EXPECT_THAT(block.looks.time_s, ElementsAre(19.75, 20.25, 7.5));
  EXPECT_THAT(block.looks.range_m, ElementsAre(12500.25, 17000.5, 16800.125));
  ASSERT_EQ(block.looks.cone.size(), 3U);
  EXPECT_DOUBLE_EQ(block.looks.cone[0], 1.5 * std::acos(-1.0) / 180.0);
  EXPECT_EQ(block.looks.cone[1], 0.0);
}

TEST(ReadBlockArraysTest, PointsOfATableComeFirstInItsOrder) {
  const GivenArrays given;
  const std::vector<std::uint32_t> all{0, 1, 2};
  files::BlockArrays arrays = given.Arrays();
  arrays.tables.push_back({"points", {{"point", {}, given.points, all}}});
  const Block block = files::ReadBlockArrays(arrays).block;
  ASSERT_EQ(block.points.size(), 3U);
  EXPECT_EQ(block.points.ids[1], "P1");
  EXPECT_THAT(block.looks.offsets, ElementsAre(0U, 1U, 1U, 3U));
}

TEST(ReadBlockArraysTest, CellsAreRefusedByTableColumnAndRow) {
  GivenArrays given;
  given.range_m[1] = -5.0;
  EXPECT_EQ(given.Refusal(), "observations.range_m[1]: must be a number above 0, got -5");
  given = {};
  given.time_s[2] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(given.Refusal(), "observations.time_s[2]: must be a finite number, got inf");
  given = {};
  given.time_s[0] = kNotGiven;
  EXPECT_EQ(given.Refusal(), "observations.time_s[0]: is empty, a number is needed");
  given = {};
  given.look_point[1] = 3;
  EXPECT_EQ(given.Refusal(),
            "observations.point[1]: must be an index below 3, the number of texts, got 3");
  given = {};
  given.points = IdsOf({"P9", "P1", "P\x01"});
  EXPECT_EQ(given.Refusal(),
            "observations.point[0]: the name holds a control character, which is not allowed");
  given = {};
  given.passes = IdsOf({"B", "A", "C"});
  given.look_pass[2] = 2;
  EXPECT_TRUE(given.Refusal().starts_with("observations.pass[2]: block.toml has no pass 'C'"))
      << given.Refusal();
  given = {};
  given.look_pass[1] = 0;
  EXPECT_EQ(given.Refusal(),
            "observations.point[1]: pass 'B' sees point 'P5' twice, first on row 0; one look per "
            "pass and point is allowed");
}

TEST(ReadBlockArraysTest, ColumnsAreRefusedByTableAndColumn) {
  GivenArrays given;
  given.range_m.pop_back();
  EXPECT_EQ(given.Refusal(),
            "observations.range_m: has 2 rows where observations.pass has 3, as many are needed");
  files::BlockArrays arrays = GivenArrays().Arrays();
  const auto refusal = [&] {
    return MessageOf<InputError>([&] { return files::ReadBlockArrays(arrays); });
  };
  given = {};
  arrays = given.Arrays();
  arrays.tables[1].columns[0] = {"pass", given.time_s};
  EXPECT_EQ(refusal(), "observations.pass: holds numbers, texts are needed");
  arrays = given.Arrays();
  arrays.tables[1].columns[4] = arrays.tables[1].columns[3];
  EXPECT_EQ(refusal(), "observations.range_m: is given twice; one column only");
  arrays = given.Arrays();
  arrays.tables[1].columns.erase(arrays.tables[1].columns.begin() + 1);
  EXPECT_TRUE(refusal().starts_with("observations.point: the column is missing; there are pass,"))
      << refusal();
  arrays = given.Arrays();
  arrays.tables.pop_back();
  EXPECT_TRUE(refusal().starts_with("observations: is missing")) << refusal();
}

// More rows than a part has: the first bad one is named whatever the threads.
TEST(ReadBlockArraysTest, TheFirstBadRowIsNamedWhateverComesBehindIt) {
  constexpr std::size_t kRows = 70001;
  GivenArrays given;
  given.points = std::make_shared<IdTable>();
  given.look_pass.assign(kRows, 1);
  given.time_s.assign(kRows, 20.25);
  given.squint_deg.assign(kRows, kNotGiven);
  given.look_point.clear();
  given.range_m.clear();
  for (std::size_t i = 0; i < kRows; ++i) {
    given.points->Append("T" + std::to_string(i));
    given.look_point.push_back(static_cast<std::uint32_t>(kRows - 1 - i));
    given.range_m.push_back(9000.5 + 0.125 * static_cast<double>(i));
  }
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    const Block block = given.Read();
    ASSERT_EQ(block.points.size(), kRows);
    for (std::size_t i = 0; i < kRows; ++i) {  // numbered as the rows name them
      ASSERT_EQ(block.points.ids[i], "T" + std::to_string(kRows - 1 - i));
      ASSERT_EQ(block.looks.range_m[i], given.range_m[i]);
    }
  }
  given.range_m[66000] = -1.0;
  given.range_m[40000] = -2.0;
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    EXPECT_EQ(given.Refusal(), "observations.range_m[40000]: must be a number above 0, got -2");
  }
}

/// Looks of more than one part, two per point. With a squint in the first row of each part they are
/// read cell by cell, without one as columns.
struct ManyLooks {
  static constexpr std::size_t kPoints = 12007, kBad = 17001;
  GivenArrays given;
  std::vector<double> rejected;

  ManyLooks() {
    std::vector<std::string> names;
    given.look_pass.clear();
    given.look_point.clear();
    given.time_s.clear();
    given.range_m.clear();
    for (std::uint32_t point = 0; point < kPoints; ++point) {
      names.push_back("Q" + std::to_string(point));
      for (const std::uint32_t pass : {1U, 0U}) {
        given.look_pass.push_back(pass);
        given.look_point.push_back(point);
        given.time_s.push_back(1.5 + 0.0025 * point + 0.125 * pass);
        given.range_m.push_back(12500.25 + 0.375 * point + 1500.0 * (1 - pass));
        rejected.push_back(point % 7 == 0 ? 1.0 : point % 7 == 1 ? kNotGiven : 0.0);
      }
    }
    given.points = IdsOf(names);
    given.squint_deg.assign(given.time_s.size(), kNotGiven);
  }
  void AskForCells() {
    for (std::size_t row = 0; row < given.squint_deg.size(); row += 1024) {
      given.squint_deg[row] = 1.5;
    }
  }
  [[nodiscard]] files::BlockArrays Arrays() const {
    files::BlockArrays arrays = given.Arrays();
    arrays.tables.back().columns.push_back({"rejected", rejected});
    return arrays;
  }
  [[nodiscard]] std::string Refusal() const {
    return MessageOf<InputError>([&] { return files::ReadBlockArrays(Arrays()); });
  }
};

TEST(ReadBlockArraysTest, LooksReadAsColumnsAreThoseReadCellByCell) {  // two routes inside
  ManyLooks looks;
  const Block columns = files::ReadBlockArrays(looks.Arrays()).block;
  looks.AskForCells();
  const Block cells = files::ReadBlockArrays(looks.Arrays()).block;
  EXPECT_TRUE(columns.looks.cone.empty());
  EXPECT_EQ(cells.looks.cone.size(), looks.rejected.size());
  EXPECT_EQ(columns.looks.offsets, cells.looks.offsets);
  EXPECT_EQ(columns.looks.pass, cells.looks.pass);
  EXPECT_EQ(columns.looks.flags, cells.looks.flags);
  EXPECT_EQ(columns.looks.time_s, cells.looks.time_s);
  EXPECT_EQ(columns.looks.range_m, cells.looks.range_m);
  EXPECT_TRUE(columns.looks.rejected(0));
  EXPECT_FALSE(columns.looks.rejected(2));
  EXPECT_EQ(columns.looks.range_m[1], 14000.25);  // of pass B, which stands behind A
}

TEST(ReadBlockArraysTest, RowsAmongColumnsAreRefusedAsCellsAre) {  // two routes inside
  const double infinity = std::numeric_limits<double>::infinity();
  using Change = std::pair<std::vector<double> ManyLooks::*, std::vector<double> GivenArrays::*>;
  const std::vector<std::pair<Change, std::vector<double>>> changes{
      {{nullptr, &GivenArrays::time_s}, {kNotGiven, -0.001, 40.501, infinity, -infinity}},
      {{nullptr, &GivenArrays::range_m},
       {kNotGiven, 0.0, -3.5, 1e-61, 1.0000001e12, infinity, -infinity}},
      {{&ManyLooks::rejected, nullptr}, {-0.0, -1.0, 0.5, 2.0, infinity}}};
  for (const auto& change : changes) {
    for (const double value : change.second) {
      ManyLooks looks;
      auto& column = change.first.first != nullptr ? looks.*change.first.first
                                                   : looks.given.*change.first.second;
      column[ManyLooks::kBad] = value;
      const std::string refusal = looks.Refusal();
      EXPECT_THAT(refusal, testing::HasSubstr("[17001]: ")) << value;
      looks.AskForCells();
      EXPECT_EQ(refusal, looks.Refusal());
    }
  }
}

TEST(ReadBlockArraysTest, ColumnsNeedStandardDeviationsOfThePassAsCellsDo) {
  ManyLooks looks;
  files::BlockArrays arrays = looks.Arrays();
  std::string toml(kArraysToml);
  toml.erase(toml.find("azimuth_m"), std::string("azimuth_m = 1.25\n").size());
  arrays.block_toml = toml;
  EXPECT_THAT(MessageOf<InputError>([&] { return files::ReadBlockArrays(arrays); }),
              testing::HasSubstr("no standard deviation of azimuth: neither this row, pass 'A'"));
}

// A row that gives no cone takes the squint of its pass; a swath comes with block.toml.
TEST(BlockArraysTest, PassesSayTheirSquintAndSwath) {
  GivenArrays given;
  files::BlockArrays arrays = given.Arrays();
  std::string toml(arrays.block_toml);
  arrays.block_toml = toml += "squint_deg = -2.5\nswath_range_m = [16000, 18000]\n";
  const Block block = files::ReadBlockArrays(arrays).block;
  ASSERT_TRUE(block.passes[1].swath);
  EXPECT_EQ(block.passes[1].swath->kind, SwathKind::kSlantRange);
  EXPECT_THAT(block.passes[1].swath->limits, ElementsAre(16000.0, 18000.0));
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    EXPECT_DOUBLE_EQ(block.looks.cone[i], (block.looks.pass[i] == 0 ? 1.5 : -2.5) * kRadPerDeg);
  }
  toml += "swath_look_deg = [0, 20]\n";
  arrays.block_toml = toml;
  EXPECT_THAT(MessageOf<InputError>([&] { return files::ReadBlockArrays(arrays); }),
              testing::HasSubstr("pass[1].swath_range_m: excludes swath_look_deg"));
}

}  // namespace
}  // namespace sarblock
