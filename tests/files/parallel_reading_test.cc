// SPDX-License-Identifier: Apache-2.0
// A large table of looks is read and copied in parts by all threads: what is read, and what is
// refused, is what one thread reading row by row would have found.
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "core/threads.h"
#include "files/convert.h"
#include "support/folder_test.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

constexpr std::size_t kManyPoints = 45007;

const std::string kTwoPassesToml =
    "format = \"sarblock-block 1\"\n"
    "name = \"large\"\n"
    "[frame]\n"
    "kind = \"local\"\n"
    "[sigma]\n"
    "range_m = 1.25\n"
    "azimuth_m = 0.75\n"
    "[[pass]]\n"
    "id = \"A1\"\n"
    "look = \"left\"\n"
    "[[pass]]\n"
    "id = \"A2\"\n"
    "look = \"right\"\n";
const std::string kTwoPassesPaths =
    "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\n"
    "A1,0,0,0,8000.5,210.5,0,0\n"
    "A1,30.25,6367.6,0,8000.5,210.5,0,0\n"
    "A2,0,0,4000,8000.5,210.5,0,0\n"
    "A2,30.25,6367.6,4000,8000.5,210.5,0,0\n";

double RangeOfLook_m(std::size_t pass, std::size_t point) {
  return 9001.25 + 0.125 * static_cast<double>(point) + 3.0 * static_cast<double>(pass);
}

/// A point in the order of the second pass; its id is new where the first pass has not seen it.
std::size_t ShuffledPoint(std::size_t k) { return (k * 7919) % kManyPoints; }

/// Rows of pass A1 for every third point, then of A2 for all points in another order; a squint from
/// the last tenth on, some rejected. 3 MB: more parts than a megabyte each.
std::vector<std::string> LargeRows() {
  std::vector<std::string> rows;
  const auto add = [&](std::size_t pass, std::size_t point, bool squint) {
    rows.push_back("A" + std::to_string(pass + 1) + ",POINT-" + std::to_string(100000 + point) +
                   ",3.5," + std::to_string(RangeOfLook_m(pass, point)) + "," +
                   (squint ? "1.5" : "") + "," + (point % 11 == 0 ? "1" : "") + "\n");
  };
  for (std::size_t point = 0; point < kManyPoints; point += 3) add(0, point, false);
  for (std::size_t k = 0; k < kManyPoints; ++k) add(1, ShuffledPoint(k), k > kManyPoints * 9 / 10);
  return rows;
}

std::string TableOfRows(const std::vector<std::string>& rows) {
  std::string text = "pass,point,time_s,range_m,squint_deg,rejected\n";
  for (const std::string& row : rows) text += row;
  return text;
}

// Closed form.
void ExpectLargeBlock(const Block& block) {
  ASSERT_EQ(block.points.size(), kManyPoints);
  ASSERT_EQ(block.looks.size(), kManyPoints + (kManyPoints + 2) / 3);
  // Points in the order of their first row.
  std::vector<std::size_t> order;
  for (std::size_t point = 0; point < kManyPoints; point += 3) order.push_back(point);
  for (std::size_t k = 0; k < kManyPoints; ++k) {
    if (ShuffledPoint(k) % 3 != 0) order.push_back(ShuffledPoint(k));
  }
  std::vector<bool> squinted(kManyPoints, false);
  for (std::size_t k = kManyPoints * 9 / 10 + 1; k < kManyPoints; ++k)
    squinted[ShuffledPoint(k)] = true;
  for (std::size_t j = 0; j < kManyPoints; ++j) {
    const std::size_t point = order[j];
    ASSERT_EQ(block.points.ids[j], "POINT-" + std::to_string(100000 + point));
    const std::size_t begin = block.looks.offsets[j], end = block.looks.offsets[j + 1];
    ASSERT_EQ(end - begin, point % 3 == 0 ? 2U : 1U);
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t pass = end - begin == 2 ? i - begin : 1;
      ASSERT_EQ(block.looks.pass[i], pass);
      ASSERT_EQ(block.looks.range_m[i], RangeOfLook_m(pass, point));
      ASSERT_EQ(block.looks.rejected(i), point % 11 == 0);
      ASSERT_EQ(block.looks.cone[i] != 0.0, pass == 1 && squinted[point]);
    }
  }
  EXPECT_TRUE(block.looks.range_sigma_m.empty());
}

class ParallelReadingTest : public test::FolderTest {
 protected:
  void PutBlock(const std::vector<std::string>& rows) const {
    Put("block.toml", kTwoPassesToml);
    Put("trajectories.csv", kTwoPassesPaths);
    Put("observations.csv", TableOfRows(rows));
  }
  [[nodiscard]] std::string Refusal(int threads) const {
    const ThreadLimit limit(threads);
    return test::MessageOf<InputError>([&] { return files::ReadBlock(folder_); });
  }
};

// Closed form, whatever the threads.
TEST_F(ParallelReadingTest, EveryThreadCountReadsTheSameBlock) {
  const std::vector<std::string> rows = LargeRows();
  PutBlock(rows);
  ASSERT_GT(std::filesystem::file_size(folder_ / "observations.csv"), 2U << 20);
  for (const int threads : {1, 2, 3, 8}) {
    const ThreadLimit limit(threads);
    ExpectLargeBlock(files::ReadBlock(folder_).block);
  }
}

TEST_F(ParallelReadingTest, TheFirstBadLineIsNamedWhateverComesBehindIt) {
  std::vector<std::string> rows = LargeRows();
  rows[55001] = "A2,LATE,3.5,far,,\n";
  rows[40000] = "A3,EARLY,3.5,9001.25,,\n";  // another part
  PutBlock(rows);
  for (const int threads : {1, 2, 8}) {
    EXPECT_THAT(Refusal(threads),
                HasSubstr("observations.csv:40002: pass: block.toml has no pass 'A3'"));
  }
  rows[40000] = "A1,EARLY,3.5,9001.25,,\n";
  PutBlock(rows);
  for (const int threads : {1, 2, 8}) {
    EXPECT_THAT(
        Refusal(threads),
        HasSubstr(
            "observations.csv:55003: range_m: must be a decimal number with a point, got 'far'"));
  }
}

TEST_F(ParallelReadingTest, LinesThatAreNoRowsAreCounted) {
  std::vector<std::string> rows = LargeRows();
  rows[20] = "# a remark\n\n" + rows[20];
  rows[50000] = "A2,ONE,3.5\n";
  PutBlock(rows);
  EXPECT_THAT(Refusal(2),
              HasSubstr("observations.csv:50004: the row has 3 cells, the header has 6"));
}

TEST_F(ParallelReadingTest, APointSeenTwiceInTwoPartsIsNamedWithBothLines) {
  std::vector<std::string> rows = LargeRows();
  rows.push_back("A1,POINT-100003,3.5,9001.25,,\n");
  PutBlock(rows);
  EXPECT_THAT(Refusal(2),
              HasSubstr("observations.csv:" + std::to_string(rows.size() + 1) +
                        ": point: pass 'A1' sees point 'POINT-100003' twice, first on line 3;"));
}

TEST_F(ParallelReadingTest, AFileWithoutALastNewLineAndACompressedOneAreRead) {
  std::vector<std::string> rows = LargeRows();
  rows.back().pop_back();
  PutBlock(rows);
  EXPECT_EQ(files::ReadBlock(folder_).block.looks.size(), rows.size());
  std::filesystem::remove(folder_ / "observations.csv");
  PutGzip("observations.csv.gz", TableOfRows(rows));
  EXPECT_EQ(files::ReadBlock(folder_).block.looks.size(), rows.size());
}

// Closed form, and two routes. The rows of a file, whose texts stand once, in parts of 8192.
TEST_F(ParallelReadingTest, EveryThreadCountReadsTheSameBlockFromAFile) {
  PutBlock(LargeRows());
  const std::filesystem::path file = folder_ / "large.h5";
  std::string first;
  for (const int threads : {1, 2, 3, 8}) {
    const ThreadLimit limit(threads);
    files::Convert(folder_, file);
    ExpectLargeBlock(files::ReadBlock(file).block);
    files::Convert(file, folder_ / "copied.h5");
    files::Convert(folder_ / "copied.h5", folder_ / "back");
    const std::string bytes = Content(folder_ / "back" / "observations.csv");
    if (threads == 1) first = bytes;
    EXPECT_GT(bytes.size(), 1U << 20);
    EXPECT_TRUE(bytes == first);
    std::filesystem::remove(file);
    std::filesystem::remove(folder_ / "copied.h5");
    std::filesystem::remove_all(folder_ / "back");
  }
}

// Hand values: the parts behind the first give no squint.
TEST_F(ParallelReadingTest, AColumnThatTheFirstRowAloneGivesHasAValueForEveryLook) {
  std::vector<std::string> rows;
  for (std::size_t point = 0; point < kManyPoints; ++point) {
    rows.push_back("A1,POINT-" + std::to_string(100000 + point) + ",3.5,9001.25," +
                   (point == 0 ? "1.5" : "") + ",\n");
  }
  PutBlock(rows);
  files::Convert(folder_, folder_ / "large.h5");
  for (const std::filesystem::path& from : {folder_, folder_ / "large.h5"}) {
    const Block block = files::ReadBlock(from).block;
    ASSERT_EQ(block.looks.cone.size(), kManyPoints);
    EXPECT_GT(block.looks.cone.front(), 0.0);
    EXPECT_EQ(std::count(block.looks.cone.begin(), block.looks.cone.end(), 0.0),
              static_cast<std::ptrdiff_t>(kManyPoints - 1));
  }
}

// Texts of a slab stand far apart: the points of the file are numbered in another order.
TEST_F(ParallelReadingTest, IdsInNoOrderComeBackWithTheSameBytes) {  // round trip
  std::vector<std::string> rows;
  for (const bool second : {false, true}) {
    for (std::size_t k = 0; k < kManyPoints; ++k) {
      const std::size_t point = second ? ShuffledPoint(k) : k;
      rows.push_back(std::string(second ? "A2" : "A1") + ",POINT-" +
                     std::to_string(100000 + point) + ",3.5,9001.25,,\n");
    }
  }
  PutBlock(rows);
  for (const Compression compression : {Compression::kNone, Compression::kGzip}) {
    files::Convert(folder_, folder_ / "large.h5", compression);
    files::Convert(folder_ / "large.h5", folder_ / "copied.h5");
    files::Convert(folder_ / "copied.h5", folder_ / "back");
    EXPECT_TRUE(Content(folder_ / "back" / "observations.csv") == TableOfRows(rows));
    for (const char* name : {"large.h5", "copied.h5", "back"}) {
      std::filesystem::remove_all(folder_ / name);
    }
  }
}

TEST_F(ParallelReadingTest, TheFirstBadRowOfAFileIsNamedWhateverComesBehindIt) {
  std::vector<std::string> rows = LargeRows();
  rows[55001] = "A2,LATE,3.5,-2,,\n";
  rows[40000] = "A3,EARLY,3.5,9001.25,,\n";  // another part
  PutBlock(rows);
  const std::filesystem::path file = folder_ / "large.h5";
  files::Convert(folder_, file);
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    EXPECT_THAT(test::MessageOf<InputError>([&] { return files::ReadBlock(file); }),
                HasSubstr("large.h5: /observations/pass[40000]: block.toml has no pass 'A3'"));
  }
  rows[40000] = "A1,EARLY,3.5,9001.25,,\n";
  PutBlock(rows);
  std::filesystem::remove(file);
  files::Convert(folder_, file);
  EXPECT_THAT(
      test::MessageOf<InputError>([&] { return files::ReadBlock(file); }),
      HasSubstr("large.h5: /observations/range_m[55001]: must be a number above 0, got -2"));
}

TEST_F(ParallelReadingTest, TheFirstBadRowIsNamedByConvert) {
  std::vector<std::string> rows = LargeRows();
  rows[55001] = "A2,LATE,3.5,far,,\n";
  rows[40000] = ",EARLY,3.5,9001.25,,\n";
  PutBlock(rows);
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    EXPECT_THAT(
        test::MessageOf<InputError>([&] { return files::Convert(folder_, folder_ / "a.h5"); }),
        HasSubstr("observations.csv:40002: pass: is empty, a name is needed"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "a.h5"));
  }
}

/// A table of points: tie points with and without coordinates, some control points among them.
std::vector<std::string> PointRows() {
  std::vector<std::string> rows;
  for (std::size_t point = 0; point < kManyPoints; ++point) {
    const std::string id = "POINT-" + std::to_string(100000 + ShuffledPoint(point));
    const std::string place = std::to_string(0.25 * static_cast<double>(point)) + ",9000.5,0.125,";
    rows.push_back(id + (point % 1000 == 7   ? ",control," + place + "0.5,0.25,\n"
                         : point % 3 == 0    ? ",tie," + place + ",,\n"
                         : point % 2000 == 1 ? ",tie,,,,,,1.5\n"
                                             : ",,,,,,,\n"));
  }
  return rows;
}

std::string TableOfPoints(const std::vector<std::string>& rows) {
  std::string text = "point,role,x_m,y_m,z_m,sigma_e_m,sigma_n_m,sigma_u_m\n";
  for (const std::string& row : rows) text += row;
  return text;
}

// Closed form, whatever the threads and the kind of file.
TEST_F(ParallelReadingTest, PointsAreReadInTheirOrderByEveryThreadCount) {
  PutBlock(LargeRows());
  Put("points.csv", TableOfPoints(PointRows()));
  files::Convert(folder_, folder_ / "large.h5");
  for (const std::filesystem::path& from : {folder_, folder_ / "large.h5"}) {
    for (const int threads : {1, 2, 8}) {
      const ThreadLimit limit(threads);
      const files::BlockFile read = files::ReadBlock(from);
      const Points& points = read.block.points;
      ASSERT_EQ(points.size(), kManyPoints);
      ASSERT_EQ(points.known.size(), 45U);  // 7, 1007 to 44007
      for (std::size_t point = 0; point < kManyPoints; ++point) {
        ASSERT_EQ(points.ids[point], "POINT-" + std::to_string(100000 + ShuffledPoint(point)));
        const bool control = point % 1000 == 7;
        ASSERT_EQ(points.role[point] == PointRole::kControl, control);
        if (control || point % 3 == 0) {
          ASSERT_EQ(points.given_m[point],
                    Eigen::Vector3d(0.25 * static_cast<double>(point), 9000.5, 0.125));
        } else {
          ASSERT_TRUE(points.given_m[point].array().isNaN().all());
        }
      }
      EXPECT_EQ(points.known[3].point, 3007U);
      EXPECT_EQ(points.known[3].covariance_enu_m2(1, 1), 0.0625);
      ASSERT_FALSE(read.warnings.empty());
      // 23 tie points are named 1, 2001, ... 44001; eight, 2001, 8001, ..., give no sigma.
      EXPECT_THAT(read.warnings[0], HasSubstr("standard deviations of 15 tie points are ignored"));
    }
  }
}

// Two routes: as text and as columns. A point that stands twice comes before what is wrong behind
// it.
TEST_F(ParallelReadingTest, TheFirstBadPointIsNamedWhateverComesBehindIt) {
  std::vector<std::string> rows = PointRows();
  const std::string good = rows[30011];
  rows[40001] = "LATE,tie,1.5,,,,,\n";
  for (const auto& [row, of_text, of_file] :
       {std::tuple{rows[17], "points.csv:30013: point: 'POINT-", "/points/point[30011]: 'POINT-"},
        std::tuple{std::string("EARLY,tie,1.5,2e12,3.5,,,\n"),
                   "points.csv:30013: y_m: must be at most",
                   "/points/y_m[30011]: must be at most"},
        std::tuple{std::string("EARLY,ty,,,,,,\n"),
                   "points.csv:30013: role: 'ty' is not known",
                   "/points/role[30011]: 'ty' is not known"},
        std::tuple{good,
                   "points.csv:40003: y_m: is empty, all three",
                   "/points/y_m[40001]: is empty, all three"}}) {
    rows[30011] = row;
    PutBlock(LargeRows());
    Put("points.csv", TableOfPoints(rows));
    files::Convert(folder_, folder_ / "large.h5");
    for (const int threads : {1, 2, 8}) {
      const ThreadLimit limit(threads);
      EXPECT_THAT(Refusal(threads), HasSubstr(of_text));
      EXPECT_THAT(
          test::MessageOf<InputError>([&] { return files::ReadBlock(folder_ / "large.h5"); }),
          HasSubstr(of_file));
    }
    std::filesystem::remove(folder_ / "large.h5");
  }
}

}  // namespace
}  // namespace sarblock
