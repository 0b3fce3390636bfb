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
#include "io/io_fixture.h"
#include "tables/csv.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;
using CsvWriterTest = test::FolderTest;
using AtomicFileTest = test::FolderTest;

TEST_F(CsvWriterTest, WritesShortestNumbersAndEmptyCells) {
  CsvWriter writer(folder_ / "t.csv", {"point", "x_m", "n", "y_m"});
  writer.Text("A").Number(0.1).Integer(-7).Number(kNaN).EndRow();
  writer.Text("B,\"c\"").Number(1e22).Integer(std::size_t{18}).Empty().EndRow();
  writer.Text("#d").Number(-0.0).Empty(2).EndRow();
  writer.Commit();
  EXPECT_EQ(Content(folder_ / "t.csv"),
            "point,x_m,n,y_m\nA,0.1,-7,\n\"B,\"\"c\"\"\",1e+22,18,\n\"#d\",-0,,\n");
}

// Invariance: rows that threads write in pieces are the bytes of rows written one after the other.
TEST_F(CsvWriterTest, RowsOfPiecesStandInTheirOrderWhateverTheThreads) {
  const auto rows = [](std::size_t begin, std::size_t end, TableWriter* out) {
    for (std::size_t i = begin; i < end; ++i) {
      out->Text("p" + std::to_string(i)).Number(std::sqrt(0.37 + static_cast<double>(i)));
      out->EndRow();
    }
  };
  for (const Compression compression : {Compression::kNone, Compression::kGzip}) {
    CsvWriter serial(folder_ / "serial", {"name", "x_m"}, compression);
    rows(0, 10007, &serial);
    serial.Commit();
    for (const int threads : {1, 2, 3, 8}) {
      const ThreadLimit limit(threads);
      CsvWriter pieces(folder_ / "pieces", {"name", "x_m"}, compression);
      WriteRows(10007, 64, &pieces, rows);
      pieces.Commit();
      EXPECT_EQ(Content(folder_ / "pieces"), Content(folder_ / "serial")) << threads;
    }
  }
}

TEST_F(CsvWriterTest, AnErrorInAPieceLeavesNoFile) {
  {
    CsvWriter writer(folder_ / "t.csv", {"x_m"});
    EXPECT_THROW(WriteRows(1000,
                           16,
                           &writer,
                           [](std::size_t begin, std::size_t end, TableWriter* out) {
                             for (std::size_t i = begin; i < end; ++i) {
                               out->Number(i == 777 ? HUGE_VAL : 0.3).EndRow();
                             }
                           }),
                 InputError);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

// A device that is always full: the error names the file, wherever among the pieces it comes.
TEST_F(CsvWriterTest, AFullDiskInThePiecesIsToldOf) {
  CsvWriter writer("/dev/full", {"x_m"});
  const auto rows = [](std::size_t begin, std::size_t end, TableWriter* out) {
    for (std::size_t i = begin; i < end; ++i) {
      out->Number(0.3 + static_cast<double>(i)).EndRow();
    }
  };
  try {
    WriteRows(400000, 2048, &writer, rows);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/dev/full: writing failed: "));
  }
}

TEST_F(CsvWriterTest, NumbersAndNamesReadBackTheSame) {  // round trip, seeded
  constexpr std::array<TableColumn, 2> columns{{{"name"}, {"x_m"}}};
  const char* const names[] = {
      "a", " b ", "c,d", "\"", "e\"\"f", "#g", "\xEF\xBB\xBFh", "\xC3\xA9"};
  for (const Compression compression : {Compression::kNone, Compression::kGzip}) {
    const auto file = folder_ / (compression == Compression::kNone ? "t.csv" : "t.csv.gz");
    RandomStream random(71, 3);
    std::vector<double> values;
    for (int i = 0; i < 4003; ++i) {
      values.push_back(random.Normal() * std::pow(10.0, 40.0 * random.Uniform() - 20.0));
    }
    CsvWriter writer(file, {"name", "x_m"}, compression);
    for (std::size_t i = 0; i < values.size(); ++i) {
      writer.Text(names[i % 8]).Number(values[i]).EndRow();
    }
    writer.Commit();
    CsvReader reader(file, columns);
    for (std::size_t i = 0; i < values.size(); ++i) {
      ASSERT_TRUE(reader.Next());
      ASSERT_EQ(reader.Text(0), names[i % 8]);
      ASSERT_EQ(reader.Number(1), values[i]);
    }
    EXPECT_FALSE(reader.Next());
  }
}

TEST_F(CsvWriterTest, RefusesRowsOfTheWrongLengthAndInfinity) {
  CsvWriter writer(folder_ / "t.csv", {"a", "b"});
  EXPECT_THROW(writer.Number(std::numeric_limits<double>::infinity()), InputError);
  writer.Text("only one");
  EXPECT_THROW(writer.EndRow(), std::logic_error);
}

TEST_F(AtomicFileTest, AppearsOnlyAtCommit) {
  AtomicFile file(folder_ / "a.txt");
  file.Write("whole");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.txt"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / (".a.txt.tmp-" + std::to_string(::getpid()))));
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

TEST_F(AtomicFileTest, MakesFoldersAndNamesWhatStandsInTheWay) {
  MakeFolder(folder_ / "b" / "c");
  MakeFolder(folder_ / "b" / "c");
  EXPECT_TRUE(std::filesystem::is_directory(folder_ / "b" / "c"));
  const auto file = Put("f", "");
  EXPECT_THAT(test::MessageOf<InputError>([&] { MakeFolder(file); }),
              HasSubstr("f: cannot be made a folder"));
}

}  // namespace
}  // namespace sarblock
