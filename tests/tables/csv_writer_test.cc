// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/threads.h"
#include "support/folder_test.h"
#include "tables/csv.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;
using CsvWriterTest = test::FolderTest;
using AtomicFileTest = test::FolderTest;

constexpr Columns kWritten{{
    {"name", ColumnNeed::kRequired, CellKind::kText},
    {"x_m"},
    {"n", ColumnNeed::kOptional, CellKind::kCount},
    {"y_m"},
}};
constexpr std::array<std::string_view, 2> kNoMore{"n", "y_m"};

void AddNamed(std::string_view name, double x_m, Batch* batch) {
  NewRow(batch).Text(kWritten("name"), name).Number(kWritten("x_m"), x_m);
}

// Hand values. Cells are set in any order, and some are not.
TEST_F(CsvWriterTest, WritesShortestNumbersAndEmptyCells) {
  const auto table = WriteCsv(folder_ / "t.csv", kWritten);
  WriteRows(4, table.get(), [](std::size_t, std::size_t, Batch* batch) {
    NewRow(batch)
        .Integer(kWritten("n"), 100000)
        .Text(kWritten("name"), "A")
        .Number(kWritten("y_m"), kNaN)
        .Number(kWritten("x_m"), 0.1);
    NewRow(batch).Number(kWritten("y_m"), 1e22);
    AddNamed("B,\"c\"", 100000.0, batch);
    AddNamed("#d", -0.0, batch);
  });
  table->Commit();
  EXPECT_EQ(Content(folder_ / "t.csv"),
            "name,x_m,n,y_m\nA,0.1,100000,\n,,,1e+22\n\"B,\"\"c\"\"\",1e+05,,\n\"#d\",-0,,\n");
}

TEST_F(CsvWriterTest, LeavesOutColumns) {
  const auto table = WriteCsv(folder_ / "t.csv", kWritten, Compression::kNone, kNoMore);
  WriteEach(2, table.get(), [](std::size_t i, Batch* batch) {
    AddNamed(i == 0 ? "A" : "B", 0.5, batch);
    NewRow(batch).Number(kWritten("y_m"), 3.0);
  });
  table->Commit();
  EXPECT_EQ(Content(folder_ / "t.csv"), "name,x_m\nA,0.5\n,\nB,0.5\n,\n");
}

// Invariance: what is written depends neither on the threads nor on the rows of a piece.
TEST_F(CsvWriterTest, RowsOfPiecesAreInTheirOrderWhateverTheThreads) {
  const auto write = [&](std::size_t per_piece, Compression compression) {
    const auto table = WriteCsv(folder_ / "t.csv", kWritten, compression, kNoMore);
    const auto rows = [](std::size_t begin, std::size_t end, Batch* batch) {
      for (std::size_t i = begin; i < end; ++i) {
        AddNamed("p" + std::to_string(i), std::sqrt(0.37 + static_cast<double>(i)), batch);
      }
    };
    WriteRows(10007, table.get(), rows, per_piece);
    table->Commit();
    return Content(folder_ / "t.csv");
  };
  for (const Compression compression : {Compression::kNone, Compression::kGzip}) {
    const std::string whole = write(10007, compression);
    for (const int threads : {1, 2, 3, 8}) {
      const ThreadLimit limit(threads);
      EXPECT_EQ(write(64, compression), whole) << threads;
    }
  }
}

TEST_F(CsvWriterTest, InfinityInAPieceLeavesNoFile) {
  {
    const auto table = WriteCsv(folder_ / "t.csv", kWritten);
    EXPECT_THAT(test::MessageOf<InputError>([&] {
                  WriteEach(20000, table.get(), [](std::size_t i, Batch* batch) {
                    AddNamed("p", i == 17777 ? HUGE_VAL : 0.3, batch);
                  });
                  return 0;
                }),
                HasSubstr("t.csv: a number became infinite"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

// A device that is always full: the error names the file, wherever among the pieces it comes.
TEST_F(CsvWriterTest, AFullDiskInThePiecesIsReported) {
  const auto table = WriteCsv("/dev/full", kWritten);
  EXPECT_THAT(test::MessageOf<InputError>([&] {
                WriteEach(400000, table.get(), [](std::size_t i, Batch* batch) {
                  AddNamed("p", 0.3 + static_cast<double>(i), batch);
                });
                return 0;
              }),
              HasSubstr("/dev/full: writing failed: "));
}

TEST_F(CsvWriterTest, NumbersAndNamesReadBackTheSame) {  // round trip, seeded
  const char* const names[] = {
      "a", " b ", "c,d", "\"", "e\"\"f", "#g", "\xEF\xBB\xBFh", "\xC3\xA9"};
  for (const Compression compression : {Compression::kNone, Compression::kGzip}) {
    const auto file = folder_ / (compression == Compression::kNone ? "t.csv" : "t.csv.gz");
    RandomStream random(71, 3);
    std::vector<double> values;
    for (int i = 0; i < 4003; ++i) {
      values.push_back(random.Normal() * std::pow(10.0, 40.0 * random.Uniform() - 20.0));
    }
    const auto table = WriteCsv(file, kWritten, compression);
    WriteEach(values.size(), table.get(), [&](std::size_t i, Batch* batch) {
      AddNamed(names[i % 8], values[i], batch);
    });
    table->Commit();
    std::size_t read = 0;
    ForRows(ReadCsv(file, kWritten).get(), [&](const Row& row) {
      ASSERT_EQ(row.Text(kWritten("name")), names[read % 8]);
      ASSERT_EQ(row.Number(kWritten("x_m")), values[read++]);
    });
    EXPECT_EQ(read, values.size());
  }
}

TEST(NewRowTest, ARowWithoutItsIdIsAnErrorOfOurs) {
  IdTable ids;
  ids.Append("P");
  Batch batch;
  batch.Begin(kTruthColumns);
  NewRow(&batch).Id(kTruthColumns("point"), ids, 0);
  NewRow(&batch).Number(kTruthColumns("x_m"), 1.5);
  EXPECT_THROW(batch.End(), std::logic_error);
}

TEST_F(AtomicFileTest, AppearsOnlyAtCommit) {
  AtomicFile file(folder_ / "a.txt");
  file.Write("whole");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.txt"));
  const auto temporary = std::filesystem::directory_iterator(folder_)->path().filename().string();
  EXPECT_TRUE(temporary.starts_with(".a.txt.tmp-")) << temporary;
  EXPECT_NE(TemporaryName(folder_ / "b").name(), TemporaryName(folder_ / "b").name());
  file.Commit();
  EXPECT_EQ(Content(folder_ / "a.txt"), "whole");
  EXPECT_EQ(FileCount(), 1u);
}

TEST_F(AtomicFileTest, LeavesTheOldFileAndNothingElseAfterAnException) {
  Put("a.txt", "old");
  try {
    AtomicFile file(folder_ / "a.txt");
    file.Write(std::string(1000003, 'x'));  // more than is buffered
    throw Interrupted("write");
  } catch (const Interrupted&) {
  }
  EXPECT_EQ(Content(folder_ / "a.txt"), "old");
  EXPECT_EQ(FileCount(), 1u);
}

TEST_F(AtomicFileTest, MovingKeepsOneOwner) {
  AtomicFile file(folder_ / "a.txt");
  file.Write("kept ");
  AtomicFile moved = std::move(file);
  moved.Write("together");
  moved.Commit();
  EXPECT_EQ(Content(folder_ / "a.txt"), "kept together");
}

TEST_F(AtomicFileTest, ASignalHandlerCanRemoveWhatIsOpen) {
  AtomicFile done(folder_ / "done.txt");
  done.Commit();
  AtomicFile plain(folder_ / "a.txt"), gzip(folder_ / "b.gz", Compression::kGzip);
  EXPECT_EQ(FileCount(), 3u);
  RemoveOpenTemporaryFiles();
  EXPECT_EQ(FileCount(), 1u);
}

TEST_F(AtomicFileTest, ReportsAFullDisk) {  // /dev/full refuses every write with ENOSPC
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  for (const Compression compression : {Compression::kNone, Compression::kGzip}) {
    EXPECT_THAT(test::MessageOf<InputError>([&] {
                  AtomicFile file("/dev/full", compression);
                  file.Write("text");
                  file.Commit();
                }),
                HasSubstr("/dev/full: writing failed: No space left on device"));
    EXPECT_NE("", test::MessageOf<InputError>([&] {
                AtomicFile file("/dev/full", compression);
                for (int i = 0; i < 64; ++i) file.Write(std::string(100003, static_cast<char>(i)));
                for (int i = 0; i < 64; ++i) file.Write(std::to_string(i * i * 7919));
                file.Commit();
              }));
  }
}

TEST_F(AtomicFileTest, NamesAFolderThatIsNotThere) {
  EXPECT_THAT(test::MessageOf<InputError>([&] { AtomicFile file(folder_ / "no" / "a.txt"); }),
              HasSubstr("no/a.txt: cannot be written: No such file or directory"));
}

TEST_F(AtomicFileTest, MakesFoldersAndNamesWhatIsInTheWay) {
  MakeFolder(folder_ / "b" / "c");
  MakeFolder(folder_ / "b" / "c");
  EXPECT_TRUE(std::filesystem::is_directory(folder_ / "b" / "c"));
  const auto file = Put("f", "");
  EXPECT_THAT(test::MessageOf<InputError>([&] { MakeFolder(file); }),
              HasSubstr("f: cannot be made a folder"));
}

}  // namespace
}  // namespace sarblock
