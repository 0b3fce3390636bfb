// SPDX-License-Identifier: Apache-2.0
// Every command that writes files keeps those of others: run on an output that holds a file of a
// name it would write, it is refused and every byte is kept; --force goes on.
#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cli/cli_fixture.h"
#include "fuzz/nisar_file.h"
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using test::ProgramRun;
using test::RunProgram;
using testing::HasSubstr;

/// A command that writes, without its -o.
struct Writer {
  std::string command;  ///< as the manual calls it
  std::vector<std::string> arguments;
  std::string file;           ///< -o names this file; empty: a folder
  std::string option = "-o";  ///< empty: the output is the last word
};

class ForeignFilesTest : public test::CliTest {
 protected:
  static constexpr const char* kForeign = "years of work\n";

  [[nodiscard]] std::vector<Writer> Writers() const {
    const std::string scenes = std::string(SARBLOCK_DATASETS) + "/scenes/";
    const std::string block = folder_ / "block", result = folder_ / "result";
    const std::string imported = folder_ / "imported_result";
    const Path corpus = SARBLOCK_FUZZ_CORPUS;
    const std::string annotation = corpus / "product" / "slant.xml";
    const std::string head = "format = \"sarblock-study 1\"\nstudy = ";
    const std::string small =
        "scene = \"" + scenes + "cross-wise.toml\"\nset = [\"points.count=60\"]\n";
    const std::string densification =
        Put("densification.toml",
            head + "\"densification\"\n" + small +
                "[[axis]]\nkey = \"control.layout\"\nvalues = [\"perimeter\"]\n"
                "[[axis]]\nkey = \"control.count\"\nvalues = [3, 5]\n[goal]\nsigma_u_m = 100\n");
    const std::string design =
        Put("design.toml",
            head + "\"design\"\n" + small +
                "[[axis]]\nkey = \"control.count\"\nvalues = [3, 4]\n[cost]\npass = 7\n");
    const std::string tradeoff =
        Put("tradeoff.toml",
            head + "\"tradeoff\"\nscene = \"" + scenes + "block-12-strips.toml\"\nrepeats = 1\n" +
                "[[size]]\npoints = 60\nset = [\"points.count=60\"]\n"
                "[[choice]]\nstage = \"model\"\nname = \"given\"\nreference = true\n"
                "[[choice]]\nstage = \"covariance\"\nname = \"block\"\nreference = true\n");
    const std::string stability = Put(
        "stability.toml", head + "\"stability\"\n[[family]]\nname = \"degree\"\nvalues = [1]\n");
    return {
        {"simulate", {"simulate", scenes + "leberl-aircraft.toml"}, ""},
        {"import sentinel1", {"import", "sentinel1", annotation}, ""},
        {"import isis",
         {"import",
          "isis",
          corpus / "network/moon.net",
          corpus / "cube/one.cub",
          corpus / "cube/two.cub",
          "--range-sigma-m",
          "4",
          "--azimuth-sigma-m",
          "6"},
         ""},
        {"import csm",
         {"import",
          "csm",
          corpus / "network/moon.net",
          corpus / "isd/one.json",
          corpus / "isd/two.json",
          "--range-sigma-m",
          "4",
          "--azimuth-sigma-m",
          "6"},
         ""},
        {"import nisar", {"import", "nisar", folder_ / "rslc.h5", "--grid", "check"}, ""},
        {"import sicd", {"import", "sicd", corpus / "sicd/plain.xml"}, ""},
        {"import terrasarx", {"import", "terrasarx", corpus / "terrasarx/whole.xml"}, ""},
        {"import iceye", {"import", "iceye", corpus / "iceye/plain.xml"}, ""},
        {"import images", {"import", "images", annotation, folder_ / "rslc.h5"}, ""},
        {"convert", {"convert", block}, "", ""},
        {"convert", {"convert", result}, "one.h5", ""},
        {"intersect", {"intersect", block, "--report"}, ""},
        {"predict", {"predict", block, "--gzip"}, ""},
        {"adjust", {"adjust", block, "--report", "--set", "pairs=neighbours"}, ""},
        {"report", {"report", result}, "page.html"},
        {"report", {"report", result, result}, "page.html"},
        {"export", {"export", imported, "--format", "geojson"}, "out.geojson"},
        {"export", {"export", imported, "--format", "kml"}, "out.kml"},
        {"export", {"export", imported, "--format", "gpkg"}, "out.gpkg"},
        {"export", {"export", imported, "--format", "sinex"}, "out.snx"},
        {"export", {"export", imported, "--format", "isis"}, ""},
        {"export", {"export", imported, "--format", "eof", "--mission", "Sentinel-1A"}, ""},
        {"export",
         {"export",
          folder_ / "moon_result",
          "--format",
          "csm",
          "--image",
          "one=" + (corpus / "isd/one.json").string(),
          "--image",
          "two=" + (corpus / "isd/two.json").string()},
         ""},
        {"export",
         {"export",
          folder_ / "sicd_result",
          "--format",
          "sicd",
          "--image",
          "one=" + (corpus / "sicd/offsets.xml").string()},
         ""},
        {"study densification", {"study", "densification", densification}, ""},
        {"study design", {"study", "design", design}, ""},
        {"study tradeoff", {"study", "tradeoff", tradeoff}, ""},
        {"study stability", {"study", "stability", stability}, ""},
        {"study join", {"study", "join", folder_ / "part1", folder_ / "part2"}, ""},
        {"leberl validity", {"leberl", "validity"}, ""},
        {"leberl differences",
         {"leberl",
          "differences",
          "--base-m",
          "8000",
          "--height-m",
          "10000",
          "--ground-range-m",
          "13000",
          "--dy-m",
          "1000",
          "--dz-m",
          "0",
          "--db",
          "10",
          "--far-ground-range-m",
          "25000"},
         ""},
    };
  }

  /// What the rows above read: a result in a local frame and one of an import, with epochs,
  /// and the parts of a study.
  void MakeInputs() const {
    const Path block = Simulated("leberl-aircraft", "block");
    ASSERT_EQ(Run("adjust", block, "result").exit_code, 0);
    test::NisarFile{}.Write(folder_ / "rslc.h5");
    const Path corpus = Path(SARBLOCK_FUZZ_CORPUS) / "product";
    const ProgramRun import = RunProgram({"import",
                                          "sentinel1",
                                          corpus / "slant.xml",
                                          corpus / "ground.xml",
                                          "--grid",
                                          "control",
                                          "--grid-sigma-m",
                                          "0.5",
                                          "--id",
                                          "one",
                                          "two",
                                          "-o",
                                          folder_ / "imported"});
    ASSERT_EQ(import.exit_code, 0) << import.err;
    ASSERT_EQ(Run("adjust", folder_ / "imported", "imported_result").exit_code, 0);
    const Path root = SARBLOCK_FUZZ_CORPUS;
    const ProgramRun moon = RunProgram({"import",
                                        "csm",
                                        root / "network/moon.net",
                                        root / "isd/one.json",
                                        root / "isd/two.json",
                                        "--range-sigma-m",
                                        "4",
                                        "--azimuth-sigma-m",
                                        "6",
                                        "-o",
                                        folder_ / "moon"});
    ASSERT_EQ(moon.exit_code, 0) << moon.err;
    ASSERT_EQ(Run("adjust", folder_ / "moon", "moon_result").exit_code, 0);
    const ProgramRun sicd = RunProgram({"import",
                                        "sicd",
                                        root / "sicd/offsets.xml",
                                        "--id",
                                        "one",
                                        "--grid",
                                        "control",
                                        "--grid-sigma-m",
                                        "100",
                                        "--max-misfit-m",
                                        "100",
                                        "-o",
                                        folder_ / "sicd"});
    ASSERT_EQ(sicd.exit_code, 0) << sicd.err;
    ASSERT_EQ(Run("adjust", folder_ / "sicd", "sicd_result").exit_code, 0);
    const std::string study =
        Put("parts.toml",
            "format = \"sarblock-study 1\"\nstudy = \"stability\"\n[[family]]\n"
            "name = \"degree\"\nvalues = [1, 2]\n");
    for (const char* part : {"1", "2"}) {
      const ProgramRun run = RunProgram({"study",
                                         "stability",
                                         study,
                                         "--part",
                                         std::string(part) + "/2",
                                         "-o",
                                         folder_ / (std::string("part") + part)});
      ASSERT_EQ(run.exit_code, 0) << run.err;
    }
  }

  [[nodiscard]] ProgramRun Write(const Writer& writer,
                                 const std::string& folder,
                                 const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = writer.arguments;
    const Path out = folder_ / folder;
    if (!writer.option.empty()) arguments.push_back(writer.option);
    arguments.push_back(writer.file.empty() ? out : out / writer.file);
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

  /// Names of the files it writes, on an empty folder.
  [[nodiscard]] std::set<std::string> NamesOf(const Writer& writer) const {
    std::filesystem::create_directory(folder_ / "fresh");
    const ProgramRun run = Write(writer, "fresh");
    EXPECT_EQ(run.exit_code, 0) << writer.command << "\n" << run.err;
    const std::set<std::string> names = FilesOf(folder_ / "fresh");
    std::filesystem::remove_all(folder_ / "fresh");
    return names;
  }

  void MakeForeign(const std::set<std::string>& names) const {
    std::filesystem::remove_all(folder_ / "foreign");
    std::filesystem::create_directory(folder_ / "foreign");
    for (const std::string& name : names) Put("foreign/" + name, kForeign);
  }

  void ExpectForeign(const std::set<std::string>& names, const std::string& of) const {
    EXPECT_EQ(FilesOf(folder_ / "foreign"), names) << of;
    for (const std::string& name : names) {
      EXPECT_EQ(Content(folder_ / "foreign" / name), kForeign) << of << ", " << name;
    }
  }
};

TEST_F(ForeignFilesTest, EveryCommandWithAnOutputHasARow) {
  std::set<std::string> writing, rows;
  std::istringstream manual(RunProgram({"--dump-manual", "markdown"}).out);
  std::string command;
  const std::string head = "## sarblock ";
  for (std::string line; std::getline(manual, line);) {
    if (line.starts_with(head)) command = line.substr(head.size());
    const bool writes = line.starts_with("| `-o, --output ") || line.starts_with("| `TO` ");
    if (writes) writing.insert(command);
  }
  for (const Writer& writer : Writers()) rows.insert(writer.command);
  EXPECT_EQ(writing, rows);
}

TEST_F(ForeignFilesTest, AFileOfOthersUnderAnyNameIsKeptAndForceGoesOn) {
  MakeInputs();
  for (const Writer& writer : Writers()) {
    const std::string of = testing::PrintToString(writer.arguments);
    const std::set<std::string> names = NamesOf(writer);
    ASSERT_FALSE(names.empty()) << of;
    std::vector<std::set<std::string>> outputs = {names};
    for (const std::string& name : names) outputs.push_back({name});
    for (const std::set<std::string>& output : outputs) {
      MakeForeign(output);
      const ProgramRun refused = Write(writer, "foreign");
      EXPECT_EQ(refused.exit_code, 3) << of << refused.err;
      EXPECT_THAT(refused.err, HasSubstr("foreign")) << of;
      EXPECT_THAT(refused.err, HasSubstr("sarblock")) << of;
      EXPECT_THAT(refused.err, HasSubstr("--force")) << of;
      EXPECT_EQ(refused.out, "") << of;
      ExpectForeign(output, of);
    }
    MakeForeign(names);
    Put("foreign/notes.txt", kForeign);
    const ProgramRun forced = Write(writer, "foreign", {"--force"});
    EXPECT_EQ(forced.exit_code, 0) << of << forced.err;
    EXPECT_EQ(Content(folder_ / "foreign/notes.txt"), kForeign) << of;
    for (const std::string& name : names) {
      EXPECT_NE(Content(folder_ / "foreign" / name), kForeign) << of << ", " << name;
    }
    std::filesystem::remove(folder_ / "foreign/notes.txt");
    const ProgramRun again = Write(writer, "foreign");  // now it is one of ours
    EXPECT_EQ(again.exit_code, 0) << of << again.err;
    EXPECT_EQ(FilesOf(folder_ / "foreign"), names) << of;
  }
}

TEST_F(ForeignFilesTest, AFileWhereAFolderIsNeededAndTheReverseAreRefused) {
  MakeInputs();
  for (const Writer& writer : Writers()) {
    const std::string of = testing::PrintToString(writer.arguments);
    std::filesystem::remove_all(folder_ / "wrong");
    if (writer.file.empty()) {
      Put("wrong", kForeign);
    } else {
      std::filesystem::create_directories(folder_ / "wrong" / writer.file);
    }
    const ProgramRun run = Write(writer, "wrong", {"--force"});
    EXPECT_EQ(run.exit_code, 3) << of;
    EXPECT_THAT(run.err,
                HasSubstr(writer.file.empty() ? "is a file, the name of a folder is needed"
                                              : "is a folder, the name of a file is needed"))
        << of;
  }
}

TEST_F(ForeignFilesTest, APageOfOthersInAResultIsNeitherReplacedNorRemoved) {
  const Path block = Simulated("leberl-aircraft", "block");
  ASSERT_EQ(Run("adjust", block, "result").exit_code, 0);
  for (const char* name : {"report.html", "comparison.html"}) {
    Put(std::string("result/") + name, kForeign);
  }
  EXPECT_EQ(RunProgram({"report", folder_ / "result"}).exit_code, 3);
  EXPECT_EQ(RunProgram({"report", folder_ / "result", folder_ / "result"}).exit_code, 3);
  ASSERT_EQ(Run("adjust", block, "result").exit_code, 0);
  for (const char* name : {"report.html", "comparison.html"}) {
    EXPECT_EQ(Content(folder_ / "result" / name), kForeign) << name;
  }
}

TEST_F(ForeignFilesTest, NoPageOfAnEarlierResultStaysBesideTheNewOne) {
  const Path block = Simulated("leberl-aircraft", "block");
  ASSERT_EQ(Run("adjust", block, "result", {"--report"}).exit_code, 0);
  const Path result = folder_ / "result";
  ASSERT_EQ(RunProgram({"report", result, result}).exit_code, 0);
  ASSERT_TRUE(FilesOf(result).contains("comparison.html"));
  ASSERT_EQ(Run("adjust", block, "result").exit_code, 0);
  EXPECT_FALSE(FilesOf(result).contains("report.html"));
  EXPECT_FALSE(FilesOf(result).contains("comparison.html"));
}

}  // namespace
}  // namespace sarblock
