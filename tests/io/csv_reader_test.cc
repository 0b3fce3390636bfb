// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "io/io_fixture.h"
#include "tables/csv.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::array<TableColumn, 3> kColumns{{{"point", ColumnNeed::kRequired}, {"x_m"}, {"y_m"}}};
enum { kPoint, kX, kY };

CsvReader Reader(std::string_view text) { return CsvReader("t.csv", text, kColumns); }

// Reads every cell of every row; what is thrown on the way, if anything.
std::string CsvError(std::string_view text) {
  return test::MessageOf<InputError>([&] {
    CsvReader reader = Reader(text);
    while (reader.Next()) {
      static_cast<void>(reader.Id(kPoint));
      static_cast<void>(reader.Number(kX));
      static_cast<void>(reader.Number(kY));
    }
  });
}

TEST(CsvReaderTest, TakesColumnsInAnyOrder) {
  CsvReader reader = Reader("y_m,point,x_m\n-2.75,P1,1e3\n");
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.Text(kPoint), "P1");
  EXPECT_EQ(reader.Number(kX), 1000.0);
  EXPECT_EQ(reader.Number(kY), -2.75);
  EXPECT_FALSE(reader.Next());
}

TEST(CsvReaderTest, ReadsWhatRealFilesHold) {  // mark, CRLF, comments, blanks, no last newline
  CsvReader reader =
      Reader("\xEF\xBB\xBF# made by hand\r\npoint,x_m\r\n\r\n#A,1\r\n A , +4.5 \r\n  \r\nB,");
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.line(), 5u);
  EXPECT_EQ(reader.Text(kPoint), "A");
  EXPECT_EQ(reader.Number(kX), 4.5);
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.line(), 7u);
  EXPECT_FALSE(reader.Given(kX));
  EXPECT_TRUE(std::isnan(reader.Number(kX)));
  EXPECT_FALSE(reader.Has(kY));
  EXPECT_TRUE(std::isnan(reader.Number(kY)));
  EXPECT_FALSE(reader.Next());
}

TEST(CsvReaderTest, UnquotesCells) {
  CsvReader reader = Reader("\"point\",x_m\n\"a,\"\"b\"\"\" ,\"7.5\"\n\"\"\"\",\n");
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.Text(kPoint), "a,\"b\"");
  EXPECT_EQ(reader.Number(kX), 7.5);
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.Text(kPoint), "\"");
}

TEST(CsvReaderTest, CollectsUnknownColumns) {
  EXPECT_THAT(Reader("colour,point,,x\n").unknown_columns(), ElementsAre("colour", "", "x"));
}

TEST(CsvReaderTest, ReadsLinesLongerThanItsBuffer) {  // and rows across the ends of the buffer
  std::string text = "point,x_m,note\n";
  const std::string note(700001, 'n');
  for (int i = 0; i < 5; ++i) text += "P" + std::to_string(i) + "," + std::to_string(i) + ",\n";
  text += "L,77.125," + note + note + "\n";
  for (int i = 0; i < 90000; ++i) text += "Q," + std::to_string(i) + ".5,abc\n";
  CsvReader reader = Reader(text);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.Text(kPoint), "P4");
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.Number(kX), 77.125);
  for (int i = 0; i < 90000; ++i) {
    ASSERT_TRUE(reader.Next());
    ASSERT_EQ(reader.Number(kX), i + 0.5);
  }
  EXPECT_FALSE(reader.Next());
}

struct BadText {
  const char* text;
  const char* message;
};

TEST(CsvReaderTest, NamesPlaceAndProblemOfWhatItRefuses) {
  const BadText cases[] = {
      {"", "t.csv: has no header row with column names"},
      {"# only\n\n", "t.csv:2: has no header row with column names"},
      {"x_m,y_m\n", "t.csv:1: point: the column is missing; the header has x_m,y_m"},
      {"point,x_m,x_m\n", "t.csv:1: x_m: the column stands twice in the header"},
      {"point,x_m\nA,1\nB\n", "t.csv:3: the row has 1 cell, the header has 2 columns"},
      {"point,x_m\nA,1,2\n", "t.csv:2: the row has 3 cells, the header has 2 columns"},
      {"point,x_m\nA,tall\n",
       "t.csv:2: x_m: 'tall' is not a number, a decimal number with a point is allowed"},
      {"point,x_m\nA,1.5m\n",
       "t.csv:2: x_m: '1.5m' is not a number, a decimal number with a point is allowed"},
      {"point,x_m\nA,0x10\n",
       "t.csv:2: x_m: '0x10' is not a number, a decimal number with a point is allowed"},
      {"point,x_m\nA,+-1\n",
       "t.csv:2: x_m: '+-1' is not a number, a decimal number with a point is allowed"},
      {"point,x_m\nA,NaN\n", "t.csv:2: x_m: 'NaN' is not allowed, a finite number is"},
      {"point,x_m\nA,-inf\n", "t.csv:2: x_m: '-inf' is not allowed, a finite number is"},
      {"point,x_m\nA,1e999\n",
       "t.csv:2: x_m: '1e999' is out of range, a number of magnitude 1e-307 to 1e308 (or 0) is "
       "allowed"},
      {"point,x_m\n,4\n", "t.csv:2: point: is empty, a name is needed"},
      {"point,x_m\nA\x01,4\n",
       "t.csv:2: point: the name holds a control character, which is not allowed"},
      {"point,x_m\n\"A,4\n",
       "t.csv:2: a quoted cell does not end on its line, a closing \" is needed"},
      {"point,x_m\n\"A\"B,4\n", "t.csv:2: text follows a closing quote, a comma is needed"},
  };
  for (const BadText& bad : cases) EXPECT_EQ(CsvError(bad.text), bad.message) << bad.text;
}

TEST(CsvReaderTest, RefusesAnEmptyCellWhereANumberIsNeeded) {
  CsvReader reader = Reader("point,x_m\nA,\n");
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(test::MessageOf<InputError>([&] { static_cast<void>(reader.RequiredNumber(kX)); }),
            "t.csv:2: x_m: is empty, a number is needed");
}

using CsvFileTest = test::FolderTest;

// Rows whose digits do not repeat, so that deflate keeps some tens of kilobytes.
std::string ManyRows(int count) {
  std::string text = "point,x_m,y_m\n";
  for (int i = 0; i < count; ++i) {
    text += "P" + std::to_string(i) + "," + std::to_string(std::sin(i) * 1e5) + "," +
            std::to_string(std::cos(i * i) * 1e5) + "\n";
  }
  return text;
}

TEST_F(CsvFileTest, GzipReadsLikePlain) {  // two routes
  const std::string text = ManyRows(30011);
  CsvReader plain(Put("t.csv", text), kColumns), gzip(PutGzip("t.csv.gz", text), kColumns);
  int rows = 0;
  while (plain.Next()) {
    ASSERT_TRUE(gzip.Next());
    ASSERT_EQ(plain.Text(kPoint), gzip.Text(kPoint));
    ASSERT_EQ(plain.Number(kX), gzip.Number(kX));
    ASSERT_EQ(plain.line(), gzip.line());
    ++rows;
  }
  EXPECT_EQ(rows, 30011);
  EXPECT_FALSE(gzip.Next());
}

TEST_F(CsvFileTest, RefusesATruncatedGzipFileAtTheLineWhereItEnds) {
  const auto whole = PutGzip("whole.csv.gz", ManyRows(30011));
  const std::string bytes = Content(whole);
  const auto cut = Put("cut.csv.gz", std::string_view(bytes).substr(0, bytes.size() / 2));
  std::size_t last_line = 0;
  const std::string message = test::MessageOf<InputError>([&] {
    CsvReader reader(cut, kColumns);
    while (reader.Next()) last_line = reader.line();
  });
  EXPECT_GT(last_line, 1000u);
  EXPECT_EQ(message,
            cut.string() + ":" + std::to_string(last_line + 1) +
                ": the gzip data end too early; the file was cut off");
}

TEST_F(CsvFileTest, RefusesDamagedGzipData) {
  const auto file = PutGzip("t.csv.gz", ManyRows(3001));
  std::string bytes = Content(file);
  for (std::size_t i = 2000; i < 2050; ++i) bytes[i] = static_cast<char>(~bytes[i]);
  Put("t.csv.gz", bytes);
  const std::string message = test::MessageOf<InputError>([&] {
    CsvReader reader(file, kColumns);
    while (reader.Next()) {
    }
  });
  EXPECT_THAT(message, HasSubstr("the gzip data are damaged"));
}

TEST_F(CsvFileTest, RefusesPlainTextUnderAGzipName) {
  const auto file = Put("t.csv.gz", "point,x_m\nA,1\n");
  EXPECT_EQ(test::MessageOf<InputError>([&] { CsvReader reader(file, kColumns); }),
            file.string() + ":1: is not gzip data, which the name's ending .gz promises");
}

TEST_F(CsvFileTest, RefusesAMissingFileAndAFolder) {
  EXPECT_THAT(test::MessageOf<InputError>([&] { CsvReader(folder_ / "no.csv", kColumns); }),
              HasSubstr("no.csv: cannot be opened: No such file or directory"));
  EXPECT_THAT(test::MessageOf<InputError>([&] { CsvReader(folder_, kColumns); }),
              HasSubstr("cannot be read: Is a directory"));
}

}  // namespace
}  // namespace sarblock
