// SPDX-License-Identifier: Apache-2.0
// Blocks and results in one HDF5 file: round trips against the folder, and what is refused.
#include "sarblock/files/result.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <fstream>

#include "files/convert.h"
#include "files/result_fixture.h"
#include "fuzz/container_fuzz_targets.h"
#include "tables/hdf5_file.h"
#include "tables/open.h"
#include <gmock/gmock.h>
#include <sys/wait.h>

// Asked by AddressSanitizer: libhdf5 keeps memory where it gives up on a damaged file; nothing of
// ours does.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace sarblock {
namespace {

using test::MessageOf;
using testing::ElementsAre;
using testing::HasSubstr;

class ContainerTest : public test::ResultFolderTest {
 protected:
  // Every table and text of folder `a` stands in `b` with the same bytes.
  void ExpectSameFiles(const std::string& a, const std::string& b) const {
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / a)) {
      const std::string name = entry.path().filename().string();
      if (name == "points.geojson") continue;
      EXPECT_EQ(Content(entry.path()), Content(folder_ / b / name)) << name;
      ++files;
    }
    EXPECT_GE(files, 3u);
  }
  // What is said of a small block whose file was damaged by these lines (container_edit.h).
  std::string Refusal(std::string_view lines) const {
    const std::filesystem::path file = folder_ / "damaged.h5";
    fuzz::WriteSmallContainer(file);
    fuzz::ContainerEdit(file, lines);
    const std::string message = MessageOf<InputError>([&] { return files::ReadBlock(file); });
    EXPECT_TRUE(message.starts_with(file.string() + ": ")) << message;
    return message.substr(std::min(message.size(), file.string().size() + 2));
  }
  // A block with every optional column of looks that can stand beside the others.
  void PutBlock(const std::string& folder) const {
    std::filesystem::create_directories(folder_ / folder);
    Put(folder + "/block.toml", std::string(test::kToml) + "wavelength_m = 0.03\n");
    Put(folder + "/trajectories.csv", test::kPaths);
    Put(folder + "/observations.csv",
        "pass,point,time_s,range_m,squint_deg,doppler_hz,range_sigma_m,azimuth_sigma_m,"
        "time_sigma_s,rejected\n"
        "A,P,12.5,800000,,,,,,0\nB,P,12.5,800100.125,,-3.5,,2.5,,1\n"
        "A,\"Q,1\",13.5,0.1e6,1.5,,0.3,,0.001,\n");
    Put(folder + "/points.csv",
        "point,role,x_m,y_m,z_m,sigma_e_m,sigma_n_m,sigma_u_m,cov_en_m2,cov_eu_m2,cov_nu_m2\n"
        "P,control,6371000.5,95000.25,1000.125,0.5,,0.1,,0.01,\n\"Q,1\",,,,,,,,,,\n");
  }
};

void AddTruth(const std::string& point, const std::array<double, 3>& position_m, Batch* batch) {
  NewRow(batch)
      .Text(kTruthColumns("point"), point)
      .Numbers(kTruthColumns("x_m", "y_m", "z_m"), position_m);
}

TEST_F(ContainerTest, BlockComesBackWithTheSameBytes) {  // round trip
  PutBlock("given");
  const files::BlockFile read = files::ReadBlock(folder_ / "given");
  Truth truth;
  truth.points_m = {Eigen::Vector3d(1.5, 2.5, 3.5), Eigen::Vector3d::Constant(kNotGiven)};
  truth.paths = {read.block.passes[0].path, read.block.passes[1].path};
  files::WriteBlock(folder_ / "written", read.block, read.adjust, &truth);
  const files::ConversionReport report = files::Convert(folder_ / "written", folder_ / "b.h5");
  EXPECT_EQ(report.kind, "block");
  EXPECT_EQ(report.tables, 5u);
  EXPECT_EQ(report.rows, 4u + 3u + 2u + 1u + 4u);
  files::Convert(folder_ / "b.h5", folder_ / "back");
  ExpectSameFiles("written", "back");
  // Written without the folder between, and deflated.
  files::WriteBlock(folder_ / "direct.h5", read.block, read.adjust, &truth, Compression::kGzip);
  files::Convert(folder_ / "direct.h5", folder_ / "back_of_direct");
  ExpectSameFiles("written", "back_of_direct");
}

/// What a host program may have asked of libhdf5: to be told of errors in its own way.
int g_told = 0;
herr_t TellHost(hid_t, void*) {
  ++g_told;
  return 0;
}

// The definition: what the host asked of libhdf5 holds again after every call, whatever it met, and
// meanwhile nothing of ours reaches it.
TEST_F(ContainerTest, LeavesTheErrorHandlerOfTheHostAsItWas) {
  PutBlock("given");
  const files::BlockFile read = files::ReadBlock(folder_ / "given");
  static_cast<void>(Refusal("delete /observations/range_m"));  // writes damaged.h5
  H5E_auto2_t before = nullptr;
  void* data = nullptr;
  H5Eget_auto2(H5E_DEFAULT, &before, &data);
  g_told = 0;
  H5Eset_auto2(H5E_DEFAULT, TellHost, &g_told);
  const auto holds = [] {
    H5E_auto2_t now = nullptr;
    void* its = nullptr;
    H5Eget_auto2(H5E_DEFAULT, &now, &its);
    return now == TellHost && its == &g_told;
  };
  files::WriteBlock(folder_ / "b.h5", read.block, read.adjust);
  EXPECT_TRUE(holds());
  EXPECT_EQ(files::ReadBlock(folder_ / "b.h5").block.looks.size(), read.block.looks.size());
  EXPECT_TRUE(holds());
  EXPECT_THROW(static_cast<void>(files::ReadBlock(folder_ / "damaged.h5")), InputError);
  EXPECT_TRUE(holds());
  Put("short.h5", "\x89HDF\r\n\x1a\n and nothing that follows");
  EXPECT_THROW(static_cast<void>(files::ReadBlock(folder_ / "short.h5")), InputError);
  EXPECT_EQ(ContentOf(folder_ / "short.h5"), std::nullopt);
  EXPECT_TRUE(holds());
  EXPECT_EQ(g_told, 0);
  EXPECT_LT(H5Fopen((folder_ / "short.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), 0);
  EXPECT_GT(g_told, 0) << "the host is not told of its own errors";
  H5Eset_auto2(H5E_DEFAULT, before, data);
}

std::atomic<int> g_children{0};
void CountChild(int) { ++g_children; }

// A handler of SIGCHLD sees every child that ends.
TEST_F(ContainerTest, StartsNoProcessWhereTheHostWantsNone) {
  PutBlock("given");
  const files::BlockFile read = files::ReadBlock(folder_ / "given");
  files::WriteBlock(folder_ / "b.h5", read.block, read.adjust);
  struct sigaction counting {};
  struct sigaction before {};
  counting.sa_handler = CountChild;
  counting.sa_flags = SA_RESTART;
  sigaction(SIGCHLD, &counting, &before);
  static_cast<void>(files::ReadBlock(folder_ / "b.h5"));
  EXPECT_GT(g_children, 0) << "nothing to count";
  g_children = 0;
  TryHdf5Apart(false);
  EXPECT_EQ(files::ReadBlock(folder_ / "b.h5").block.looks.size(), read.block.looks.size());
  TryHdf5Apart(true);
  EXPECT_EQ(g_children, 0);
  sigaction(SIGCHLD, &before, nullptr);
}

TEST_F(ContainerTest, ResultComesBackWithTheSameBytes) {  // round trip
  files::WriteResult(folder_ / "result", block_, options_, result_, context_);
  files::Convert(folder_ / "result", folder_ / "r.h5");
  files::Convert(folder_ / "r.h5", folder_ / "back");
  ExpectSameFiles("result", "back");
  files::WriteResult(folder_ / "direct.h5", block_, options_, result_, context_);
  files::Convert(folder_ / "direct.h5", folder_ / "back_of_direct");
  for (const TableDescription& table : TablesOf(FolderContent::kResult)) {
    const std::string name = std::string(table.name) + ".csv";
    EXPECT_EQ(Content(folder_ / "result" / name), Content(folder_ / "back_of_direct" / name));
  }
}

TEST_F(ContainerTest, ReadsTheSameFromFileAndFolder) {  // two routes inside the project
  files::WriteResult(folder_ / "result", block_, options_, result_, context_);
  files::Convert(folder_ / "result", folder_ / "r.h5");
  const files::ResultFile a = files::ReadResult(folder_ / "result"),
                          b = files::ReadResult(folder_ / "r.h5");
  EXPECT_EQ(a.summary.json, b.summary.json);
  EXPECT_EQ(a.points.ids[1], b.points.ids[1]);
  EXPECT_EQ(a.points.results.status, b.points.results.status);
  EXPECT_EQ(a.points.results.covariance_m2[0], b.points.results.covariance_m2[0]);
  EXPECT_EQ(a.points.results.reason, b.points.results.reason);
  EXPECT_EQ(a.parameters[0].name, b.parameters[0].name);
  EXPECT_EQ(a.parameters[1].value, b.parameters[1].value);
  EXPECT_EQ(a.parameter_covariance.size(), b.parameter_covariance.size());
  EXPECT_EQ(a.looks.point, b.looks.point);
  EXPECT_EQ(a.looks.rejected, b.looks.rejected);
  EXPECT_EQ(a.looks.weight, b.looks.weight);
  EXPECT_EQ(a.passes[1].path.states()[1].position_m, b.passes[1].path.states()[1].position_m);
}

TEST_F(ContainerTest, SameBlockGivesTheSameBytes) {
  files::WriteBlock(folder_ / "a.h5", block_, options_);
  files::WriteBlock(folder_ / "b.h5", block_, options_);
  EXPECT_EQ(Content(folder_ / "a.h5"), Content(folder_ / "b.h5"));
}

TEST_F(ContainerTest, HoldsNoTimeOfDay) {
  files::WriteBlock(folder_ / "a.h5", block_, options_);
  const Hdf5Id file(H5Fopen((folder_ / "a.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  int objects = 0;
  const auto visit = [](hid_t, const char* name, const H5O_info_t* info, void* count) -> herr_t {
    for (const time_t time : {info->atime, info->mtime, info->ctime, info->btime}) {
      EXPECT_EQ(time, 0) << name;
    }
    ++*static_cast<int*>(count);
    return 0;
  };
  ASSERT_GE(H5Ovisit2(file.get(), H5_INDEX_NAME, H5_ITER_NATIVE, visit, &objects, H5O_INFO_TIME),
            0);
  EXPECT_GT(objects, 10);  // the root, groups and columns
}

TEST_F(ContainerTest, KeepsColumnsOfOthersAsText) {
  PutBlock("given");
  Put("given/truth.csv", "note,z_m,point,y_m,x_m\n# a comment\n\"so, so\",3,P,2,1.50\n");
  const files::ConversionReport report = files::Convert(folder_ / "given", folder_ / "b.h5");
  EXPECT_THAT(report.left_out, ElementsAre());
  files::Convert(folder_ / "b.h5", folder_ / "back", Compression::kNone);
  EXPECT_EQ(Content(folder_ / "back/truth.csv"), "point,x_m,y_m,z_m,note\nP,1.5,2,3,\"so, so\"\n");
}

TEST_F(ContainerTest, NamesWhatIsLeftOutOfAFolder) {
  PutBlock("given");
  Put("given/pairs.csv", "point_a,point_b\nP,Q\n");
  EXPECT_THAT(files::Convert(folder_ / "given", folder_ / "b.h5").left_out,
              ElementsAre("pairs.csv"));
}

TEST_F(ContainerTest, ListsBesideTheFileAreRead) {
  PutBlock("given");
  files::Convert(folder_ / "given", folder_ / "b.h5");
  Put("pairs.csv", "point_a,point_b\nP,\"Q,1\"\n");
  Put("out.csv", "pass,point,rejected\nA,P,1\n");
  Block block = files::ReadBlock(folder_ / "b.h5").block;
  EXPECT_EQ(files::ReadPairs(folder_ / "b.h5", "pairs.csv", block).size(), 1u);
  EXPECT_EQ(files::ApplyRejections(folder_ / "b.h5", "out.csv", &block), 1u);
}

TEST_F(ContainerTest, RefusalsNameDatasetRowAndValue) {
  EXPECT_EQ(Refusal("set /observations/range_m 1 -5"),
            "/observations/range_m[1]: must be a number above 0, got -5");
  EXPECT_EQ(Refusal("set /observations/range_m 1 inf"),
            "/observations/range_m[1]: must be a finite number, got inf");
  EXPECT_EQ(Refusal("set /observations/time_s 0 nan"),
            "/observations/time_s[0]: is empty, a number is needed");
  EXPECT_EQ(Refusal("set /observations/point 1 7"),
            "/observations/point[1]: must be an index below 1, the number of its texts, got 7");
  EXPECT_THAT(Refusal("set /observations/time_s 1 4000"),
              HasSubstr("/observations/time_s[1]: 4000 is outside the flight path of pass 'B'"));
  EXPECT_THAT(Refusal("set /trajectories/time_s 1 0"),
              HasSubstr("/trajectories/time_s[1]: pass 'A' has two states at 0 s, one is allowed; "
                        "the state before, on row 0, is at 0 s"));
  EXPECT_THAT(Refusal("set /observations/pass 1 0"),
              HasSubstr("/observations/point[1]: pass 'A' sees point 'P' twice, first on row 0"));
  EXPECT_THAT(Refusal("text block_toml format = 7"), HasSubstr("block_toml:1: format: "));
}

TEST_F(ContainerTest, RefusalsNameDatasetsThatCannotBe) {
  EXPECT_THAT(Refusal("delete /observations/range_m"),
              HasSubstr("/observations/range_m: the column is missing; the group has "
                        "pass,point,time_s"));
  EXPECT_THAT(Refusal("delete /observations"), HasSubstr("/observations: is missing"));
  EXPECT_THAT(Refusal("delete /point_id"), HasSubstr("/point_id: the dataset is missing"));
  EXPECT_THAT(Refusal("floats /observations/range_m 5"),
              HasSubstr("/observations/range_m: has 5 rows where /observations/pass has 2"));
  EXPECT_THAT(Refusal("matrix /observations/range_m 2"),
              HasSubstr("/observations/range_m: has 2 dimensions, one is needed"));
  EXPECT_THAT(Refusal("words /observations/range_m 2"),
              HasSubstr("/observations/range_m: holds no numbers"));
  EXPECT_THAT(Refusal("floats /observations/point 2"),
              HasSubstr("/observations/point: holds no integers"));
  EXPECT_THAT(Refusal("words /point_id 1"), HasSubstr("/point_id: is no dataset of strings"));
  EXPECT_THAT(Refusal("link /observations/range_m /observations/time_s"),
              HasSubstr("range_m: is a link"));
  EXPECT_THAT(Refusal("external /observations/range_m 2"),
              HasSubstr("/observations/range_m: has its values in another file"));
  EXPECT_THAT(Refusal("floats /observations/rejected 2\nset /observations/rejected 1 2"),
              HasSubstr("/observations/rejected[1]: must be 0 or 1, got '2'"));
}

TEST_F(ContainerTest, RefusesRowsThatAreNotStored) {
  std::string all;
  for (const char* name : {"pass", "point", "time_s", "range_m"}) {
    all += std::string("extend /observations/") + name + " 1000000000000\n";
  }
  EXPECT_THAT(Refusal(all), HasSubstr("has 1000000000000 rows, not all of which are in the file"));
  EXPECT_THAT(Refusal("cut 6000"), HasSubstr("cannot be opened as an HDF5 file"));
  EXPECT_THAT(Refusal("cut 5"), HasSubstr("is a file that is no HDF5 file"));
}

TEST_F(ContainerTest, ColumnsWithoutValuesTakeNoRoom) {
  const auto write = [&](const char* name, double y_m) {
    WriteTables(
        FolderContent::kBlock, folder_ / name, Compression::kNone, {}, [&](TableSink* sink) {
          const auto table = sink->Open("truth", kTruthColumns);
          WriteEach(100000, table.get(), [&](std::size_t, Batch* batch) {
            AddTruth("P", {1.0, y_m, y_m}, batch);
          });
          table->Commit();
          sink->WriteText("block.toml", "");
        });
    return std::filesystem::file_size(folder_ / name);
  };
  // Two columns of 100000 values of 8 bytes, less what a file of its own may take.
  EXPECT_LT(write("empty.h5", kNotGiven) + 1500000, write("full.h5", 2.0));
  EXPECT_EQ(files::Convert(folder_ / "empty.h5", folder_ / "back").rows, 100000u);
}

// Two routes inside: from file to file rows are copied as columns, into a folder cell by cell.
TEST_F(ContainerTest, ConvertRefusesColumnsAsItRefusesCells) {
  for (const char* lines : {"set /observations/range_m 1 inf",
                            "set /observations/pass 1 7",
                            "set /observations/point 1 4000",
                            "set /observations/rejected 0 2",
                            "set /points/role 0 9"}) {
    PutBlock("given");
    const std::filesystem::path file = folder_ / "damaged.h5";
    files::Convert(folder_ / "given", file);
    fuzz::ContainerEdit(file, lines);
    const std::string columns =
        MessageOf<InputError>([&] { return files::Convert(file, folder_ / "a.h5"); });
    EXPECT_THAT(columns, HasSubstr("must be ")) << lines;
    EXPECT_EQ(columns, MessageOf<InputError>([&] { return files::Convert(file, folder_ / "a"); }));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "a.h5"));
    std::filesystem::remove(file);
  }
}

TEST_F(ContainerTest, DistinguishesABlockFromAResult) {
  files::WriteResult(folder_ / "r.h5", block_, options_, result_, context_);
  files::WriteBlock(folder_ / "b.h5", block_, options_);
  EXPECT_THAT(MessageOf<InputError>([&] { return files::ReadBlock(folder_ / "r.h5"); }),
              HasSubstr("is a result, not a block"));
  EXPECT_THAT(MessageOf<InputError>([&] { return files::ReadResult(folder_ / "b.h5"); }),
              HasSubstr("is a block, not a result"));
  EXPECT_THAT(
      MessageOf<InputError>([&] { return files::Convert(folder_ / "none", folder_ / "x.h5"); }),
      HasSubstr("none: does not exist"));
  EXPECT_THAT(
      MessageOf<InputError>([&] { return files::Convert(folder_ / "b.h5", folder_ / "b.h5"); }),
      HasSubstr("b.h5: is what is converted"));
}

TEST_F(ContainerTest, RefusesToConvertASummaryThatIsNoJsonAndABlockThatIsNoToml) {
  files::WriteResult(folder_ / "r", block_, options_, result_, context_);
  Put("r/summary.json", "{\n\"format\": 1,\n}");
  EXPECT_THAT(
      MessageOf<InputError>([&] { return files::Convert(folder_ / "r", folder_ / "r.h5"); }),
      HasSubstr("r/summary.json:3: "));
  files::WriteBlock(folder_ / "b", block_, options_);
  Put("b/block.toml", "name = \"one\"\n[frame");
  EXPECT_THAT(
      MessageOf<InputError>([&] { return files::Convert(folder_ / "b", folder_ / "b.h5"); }),
      HasSubstr("b/block.toml:2: "));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "r.h5"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "b.h5"));
}

TEST_F(ContainerTest, RefusesToReplaceAFileOfOthers) {
  const auto require = [&](FolderContent content) {
    return MessageOf<InputError>([&] {
      RequireFolderFor(content, folder_ / "x.h5", ForeignFiles::kRefuse);
      return 0;
    });
  };
  EXPECT_EQ(require(FolderContent::kBlock), "");
  files::WriteBlock(folder_ / "x.h5", block_, options_);
  EXPECT_EQ(require(FolderContent::kBlock), "");
  EXPECT_THAT(require(FolderContent::kResult), HasSubstr("is no result that sarblock wrote"));
  Put("x.h5", "text");
  EXPECT_THAT(require(FolderContent::kBlock), HasSubstr("is no block that sarblock wrote"));
}

TEST_F(ContainerTest, LeavesNothingWhereWritingEndsEarly) {
  const auto write = [&] {
    WriteTables(
        FolderContent::kBlock, folder_ / "x.h5", Compression::kNone, {}, [](TableSink* sink) {
          const auto table = sink->Open("truth", kTruthColumns);
          WriteEach(1, table.get(), [](std::size_t, Batch* batch) {
            AddTruth("P", {1.0, HUGE_VAL, 3.0}, batch);
          });
          table->Commit();
        });
    return 0;
  };
  EXPECT_THAT(MessageOf<InputError>(write), HasSubstr("x.h5: a number became infinite"));
  EXPECT_EQ(FileCount(), 0u);
}

TEST_F(ContainerTest, KilledWriterLeavesNoFileUnderTheName) {
  const pid_t child = ::fork();
  if (child == 0) {
    WriteTables(
        FolderContent::kBlock, folder_ / "x.h5", Compression::kNone, {}, [](TableSink* sink) {
          const auto table = sink->Open("truth", kTruthColumns);
          WriteEach(40000, table.get(), [](std::size_t, Batch* batch) {
            AddTruth("P", {1.0, 2.0, 3.0}, batch);
          });
          ::kill(::getpid(), SIGKILL);
        });
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x.h5"));
  files::WriteBlock(folder_ / "x.h5", block_, options_);  // clears away what was left
  EXPECT_EQ(FileCount(), 1u);
}

TEST_F(ContainerTest, LongTablesAreReadInSlabs) {  // round trip over more than two slabs
  constexpr int kRows = 40000;
  const auto text = [](int row) { return std::to_string(row % 7); };
  WriteTables(
      FolderContent::kBlock, folder_ / "x.h5", Compression::kGzip, {}, [&](TableSink* sink) {
        const auto table = sink->Open("truth", kTruthColumns);
        WriteEach(kRows, table.get(), [&](std::size_t row, Batch* batch) {
          const auto number = static_cast<double>(row);
          AddTruth(text(static_cast<int>(row)), {number, -number, kNotGiven}, batch);
        });
        table->Commit();
        sink->WriteText("block.toml", "");
      });
  files::Convert(folder_ / "x.h5", folder_ / "back");
  test::CsvRows reader(folder_ / "back/truth.csv", kTruthColumns);
  for (int row = 0; row < kRows; ++row) {
    ASSERT_TRUE(reader.Next());
    ASSERT_EQ(reader.Text(0), text(row));
    ASSERT_EQ(reader.Number(1), row);
    ASSERT_EQ(reader.Number(2), -row);
    ASSERT_FALSE(reader.Given(3));
  }
  EXPECT_FALSE(reader.Next());
}

// libhdf5 1.10 crashes on some of these, and one never ends: whatever comes of a changed byte, it
// is a block or a refusal. A byte in 167 of the structure, two ways each, and a byte too many.
TEST_F(ContainerTest, AnyChangedByteIsReadOrRefused) {  // invariance
  const std::filesystem::path file = folder_ / "whole.h5", damaged = folder_ / "damaged.h5";
  fuzz::WriteSmallContainer(file);
  const std::string whole = Content(file);
  std::size_t refused = 0, fatal = 0, tried = 0;
  const auto try_it = [&](const std::string& bytes) {
    std::ofstream(damaged, std::ios::binary) << bytes;
    ++tried;
    try {
      static_cast<void>(files::ReadBlock(damaged));
    } catch (const InputError& error) {
      ++refused;
      fatal += std::string(error.what()).find("is damaged: libhdf5") != std::string::npos ? 1U : 0U;
    }
  };
  for (std::size_t i = 0; i < std::min<std::size_t>(whole.size(), 12000); i += 167) {
    for (const unsigned flip : {0x40U, 0x01U}) {
      std::string bytes = whole;
      bytes[i] = static_cast<char>(static_cast<unsigned char>(bytes[i]) ^ flip);
      try_it(bytes);
    }
    if (i % 501 == 0) try_it(whole.substr(0, i) + 'x' + whole.substr(i));
  }
  std::printf(
      "%zu changes: %zu refused, %zu of them after libhdf5 failed\n", tried, refused, fatal);
  EXPECT_GT(refused, tried / 20);
  EXPECT_GT(fatal, 0U);
}

}  // namespace
}  // namespace sarblock
