// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>
#include <vector>

#include "support/folder_test.h"
#include "tables/csv.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr Columns kColumns{{
    {"point", ColumnNeed::kRequired, CellKind::kPoint},
    {"x_m"},
    {"y_m"},
    {"flag", ColumnNeed::kOptional, CellKind::kFlag},
    {"n", ColumnNeed::kOptional, CellKind::kCount},
}};
constexpr std::size_t kPoint = kColumns("point"), kX = kColumns("x_m"), kY = kColumns("y_m");

/// A row as it was read.
struct ReadRow {
  std::string point;
  double x_m, y_m;
  std::size_t line;
};

std::vector<ReadRow> Rows(TableReader* table) {
  std::vector<ReadRow> rows;
  ForRows(table, [&](const Row& row) {
    rows.push_back({std::string(row.Text(kPoint)), row.Number(kX), row.Number(kY), row.line()});
  });
  return rows;
}
std::vector<ReadRow> RowsOf(std::string_view text) {
  return Rows(ReadCsvText("t.csv", text, kColumns).get());
}

// Reads every cell of every row; what is thrown on the way, if anything.
std::string CsvError(std::string_view text) {
  return test::MessageOf<InputError>([&] {
    ForRows(ReadCsvText("t.csv", text, kColumns).get(), [](const Row& row) {
      static_cast<void>(row.Id(kPoint));
      static_cast<void>(row.Numbers(kColumns("x_m", "y_m")));
      static_cast<void>(row.Flag(kColumns("flag")));
      static_cast<void>(row.Count(kColumns("n")));
    });
    return 0;
  });
}

TEST(CsvReaderTest, TakesColumnsInAnyOrder) {
  const std::vector<ReadRow> rows = RowsOf("y_m,point,x_m\n-2.75,P1,1e3\n");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].point, "P1");
  EXPECT_EQ(rows[0].x_m, 1000.0);
  EXPECT_EQ(rows[0].y_m, -2.75);
}

TEST(CsvReaderTest, ReadsWhatRealFilesHold) {  // mark, CRLF, comments, blanks, no last newline
  const auto table =
      ReadCsvText("t.csv",
                  "\xEF\xBB\xBF# made by hand\r\npoint,x_m\r\n\r\n#A,1\r\n A , +4.5 \r\n  \r\nB,",
                  kColumns);
  EXPECT_FALSE(table->Has(kY));
  const std::vector<ReadRow> rows = Rows(table.get());
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].line, 5U);
  EXPECT_EQ(rows[0].point, "A");
  EXPECT_EQ(rows[0].x_m, 4.5);
  EXPECT_TRUE(std::isnan(rows[0].y_m));
  EXPECT_EQ(rows[1].line, 7U);
  EXPECT_EQ(rows[1].point, "B");
  EXPECT_TRUE(std::isnan(rows[1].x_m));
}

TEST(CsvReaderTest, DistinguishesEmptyCellsFromGivenOnes) {
  std::string given;
  ForRows(ReadCsvText("t.csv", "point,x_m,flag,n\nA,,1,\nB,0,,7\n", kColumns).get(),
          [&](const Row& row) {
            for (std::size_t i = 0; i < kColumns.size(); ++i) given += row.Given(i) ? '1' : '0';
            given += row.Flag(kColumns("flag")) ? " flagged " : " ";
            given += std::to_string(row.Count(kColumns("n"))) + "; ";
          });
  EXPECT_EQ(given, "10010 flagged 0; 11001 7; ");
}

TEST(CsvReaderTest, UnquotesCells) {
  const std::vector<ReadRow> rows = RowsOf("\"point\",x_m\n\"a,\"\"b\"\"\" ,\"7.5\"\n\"\"\"\",\n");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].point, "a,\"b\"");
  EXPECT_EQ(rows[0].x_m, 7.5);
  EXPECT_EQ(rows[1].point, "\"");
}

TEST(CsvReaderTest, CollectsUnknownColumns) {
  EXPECT_THAT(ReadCsvText("t.csv", "colour,point,,x\n", kColumns)->unknown_columns(),
              ElementsAre("colour", "", "x"));
}

TEST(CsvReaderTest, ReadsLinesLongerThanWhatIsReadAtOnce) {  // and rows across its ends
  std::string text = "point,x_m,note\n";
  const std::string note(700001, 'n');
  for (int i = 0; i < 5; ++i) text += "P" + std::to_string(i) + "," + std::to_string(i) + ",\n";
  text += "L,77.125," + note + note + "\n";
  for (int i = 0; i < 90000; ++i) text += "Q," + std::to_string(i) + ".5,abc\n";
  const std::vector<ReadRow> rows = RowsOf(text);
  ASSERT_EQ(rows.size(), 90006U);
  EXPECT_EQ(rows[4].point, "P4");
  EXPECT_EQ(rows[5].x_m, 77.125);
  for (std::size_t i = 0; i < 90000; ++i) {
    ASSERT_EQ(rows[6 + i].x_m, static_cast<double>(i) + 0.5);
    ASSERT_EQ(rows[6 + i].line, 8 + i);
  }
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
      {"point,x_m,x_m\n", "t.csv:1: x_m: the header has this column twice"},
      {"point,x_m\nA,1\nB\n", "t.csv:3: the row has 1 cell, the header has 2 columns"},
      {"point,x_m\nA,1,2\n", "t.csv:2: the row has 3 cells, the header has 2 columns"},
      {"point,x_m\nA,tall\n", "t.csv:2: x_m: must be a decimal number with a point, got 'tall'"},
      {"point,x_m\nA,1.5m\n", "t.csv:2: x_m: must be a decimal number with a point, got '1.5m'"},
      {"point,x_m\nA,0x10\n", "t.csv:2: x_m: must be a decimal number with a point, got '0x10'"},
      {"point,x_m\nA,+-1\n", "t.csv:2: x_m: must be a decimal number with a point, got '+-1'"},
      {"point,x_m\nA,NaN\n", "t.csv:2: x_m: must be a finite number, got 'NaN'"},
      {"point,x_m\nA,-inf\n", "t.csv:2: x_m: must be a finite number, got '-inf'"},
      {"point,x_m\nA,1e999\n",
       "t.csv:2: x_m: must be a number of magnitude 1e-307 to 1e308 (or 0), got '1e999'"},
      {"point,flag\nA,1.0\n", "t.csv:2: flag: must be 0 or 1, got '1.0'"},
      {"point,n\n\nA,1.5\n", "t.csv:3: n: must be an integer of 0 or more, got 1.5"},
      {"point,n\nA,\"1,5\"\n", "t.csv:2: n: must be a decimal number with a point, got '1,5'"},
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
  EXPECT_EQ(test::MessageOf<InputError>([] {
              ForRows(ReadCsvText("t.csv", "point,x_m\nA,\n", kColumns).get(),
                      [](const Row& row) { static_cast<void>(row.RequiredNumber(kX)); });
              return 0;
            }),
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
  const std::vector<ReadRow> plain = Rows(ReadCsv(Put("t.csv", text), kColumns).get());
  const std::vector<ReadRow> gzip = Rows(ReadCsv(PutGzip("t.csv.gz", text), kColumns).get());
  ASSERT_EQ(plain.size(), 30011U);
  ASSERT_EQ(gzip.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    ASSERT_EQ(plain[i].point, gzip[i].point);
    ASSERT_EQ(plain[i].x_m, gzip[i].x_m);
    ASSERT_EQ(plain[i].line, gzip[i].line);
  }
}

TEST_F(CsvFileTest, RefusesATruncatedGzipFileAtTheLineWhereItEnds) {
  const auto whole = PutGzip("whole.csv.gz", ManyRows(30011));
  const std::string bytes = Content(whole);
  const auto cut = Put("cut.csv.gz", std::string_view(bytes).substr(0, bytes.size() / 2));
  std::size_t last_line = 0;
  const std::string message = test::MessageOf<InputError>([&] {
    ForRows(ReadCsv(cut, kColumns).get(), [&](const Row& row) { last_line = row.line(); });
    return 0;
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
  const std::string message =
      test::MessageOf<InputError>([&] { return Rows(ReadCsv(file, kColumns).get()); });
  EXPECT_THAT(message, HasSubstr("the gzip data are damaged"));
}

TEST_F(CsvFileTest, RefusesPlainTextUnderAGzipName) {
  const auto file = Put("t.csv.gz", "point,x_m\nA,1\n");
  EXPECT_EQ(test::MessageOf<InputError>([&] { return ReadCsv(file, kColumns); }),
            file.string() + ":1: is not gzip data, which the name's ending .gz promises");
}

TEST_F(CsvFileTest, RefusesAMissingFileAndAFolder) {
  EXPECT_THAT(test::MessageOf<InputError>([&] { return ReadCsv(folder_ / "no.csv", kColumns); }),
              HasSubstr("no.csv: cannot be opened: No such file or directory"));
  EXPECT_THAT(test::MessageOf<InputError>([&] { return ReadCsv(folder_, kColumns); }),
              HasSubstr("cannot be read: Is a directory"));
}

}  // namespace
}  // namespace sarblock
