// SPDX-License-Identifier: Apache-2.0
// The command `import` on an annotation of our own and on real products (docs/import.md).
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

using test::ColumnOf;
using test::ProgramRun;
using test::RowsOf;
using test::RunProgram;
using testing::HasSubstr;

class ImportTest : public test::CliTest {
 protected:
  Path Own(const std::string& name) const {
    return Path(SARBLOCK_FUZZ_CORPUS) / "product" / (name + ".xml");
  }
  ProgramRun Import(const std::vector<Path>& files,
                    const std::string& block,
                    const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"import", "sentinel1"};
    for (const Path& file : files) arguments.push_back(file);
    arguments.insert(arguments.end(), {"-o", folder_ / block});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }
  std::vector<std::vector<std::string>> Table(const std::string& file) const {
    return RowsOf(Content(folder_ / file));
  }
  /// Largest absolute value of a column over the looks that take part.
  double Largest(const std::string& result, const std::string& column) const {
    const auto rows = Table(result + "/residuals.csv");
    const std::size_t value = ColumnOf(rows, column), rejected = ColumnOf(rows, "rejected");
    double largest = 0.0;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      if (rows[i][rejected] == "1" || rows[i][value].empty()) continue;  // empty: point not solved
      largest = std::max(largest, std::abs(std::stod(rows[i][value])));
    }
    return largest;
  }
  struct Correction {
    double value = 0.0, sigma = 0.0;
  };
  /// Of passes.csv, by pass and parameter.
  std::map<std::string, Correction> Corrections(const std::string& result) const {
    const auto rows = Table(result + "/passes.csv");
    std::map<std::string, Correction> all;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      all[rows[i][ColumnOf(rows, "pass")] + " " + rows[i][ColumnOf(rows, "parameter")]] = {
          std::stod(rows[i][ColumnOf(rows, "value")]), std::stod(rows[i][ColumnOf(rows, "sigma")])};
    }
    return all;
  }
};

TEST_F(ImportTest, ABlockIsNamedAsItsFolderOrItsFileUnlessItHasAName) {
  for (const auto& [output, name] : std::map<std::string, std::string>{
           {"north", "north"}, {"south/", "south"}, {"both.h5", "both"}}) {
    ASSERT_EQ(Import({Own("slant")}, output).exit_code, 0);
    const ProgramRun run = RunProgram({"check", folder_ / output, "--json"});
    EXPECT_EQ(nlohmann::json::parse(run.out)["block"], name) << run.err;
  }
  ASSERT_EQ(Import({Own("slant")}, "west.h5", {"--name", "coast"}).exit_code, 0);
  EXPECT_EQ(
      nlohmann::json::parse(RunProgram({"check", folder_ / "west.h5", "--json"}).out)["block"],
      "coast");
}

TEST_F(ImportTest, AnOwnAnnotationBecomesABlockThatAdjusts) {
  const ProgramRun run =
      Import({Own("slant"), Own("ground")},
             "block",
             {"--grid", "control", "--grid-sigma-m", "0.5", "--id", "one", "two", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto summary = nlohmann::json::parse(run.out);
  EXPECT_EQ(summary["passes"], 2);
  EXPECT_EQ(summary["looks"], 18);
  EXPECT_EQ(summary["faulty_rows"].size(), 0u);
  // One flight: its path errors are one shared position correction.
  ASSERT_EQ(summary["data_takes"].size(), 1u);
  EXPECT_EQ(summary["data_takes"][0]["path_sigma_m"], 0.1);
  EXPECT_THAT(Content(folder_ / "block/block.toml"), HasSubstr("shared = true"));
  EXPECT_THAT(Content(folder_ / "block/block.toml"),
              HasSubstr("epoch_utc = \"2022-10-16T23:59:50Z\""));
  const ProgramRun adjusted =
      Run("adjust", folder_ / "block", "result", {"--set", "correction.time.bias=true"});
  EXPECT_EQ(adjusted.exit_code, 0) << adjusted.err;
  const auto corrections = Corrections("result");
  ASSERT_EQ(corrections.size(), 5u);
  for (const auto& [name, correction] : corrections) {  // a closed form: 5e-5 m along track
    EXPECT_LT(std::abs(correction.value), name.ends_with("time.bias") ? 1e-8 : 5e-5) << name;
  }
}

TEST_F(ImportTest, FaultyRowsAreOnStandardErrorAndInTheJson) {
  const ProgramRun run = Import({Own("faulty")}, "block");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.err, HasSubstr("geolocationGrid line 2000 (row 3): 3 of 3 points do not fit"));
  EXPECT_THAT(run.err, HasSubstr("geolocationGrid line 1000 (row 2): 3 of 3 points do not fit"));
  EXPECT_THAT(run.err, HasSubstr("--orbit-through positions avoids it"));
  const ProgramRun quiet = Import({Own("faulty")}, "block", {"--quiet", "--json"});
  EXPECT_EQ(quiet.err, "");
  EXPECT_EQ(nlohmann::json::parse(quiet.out)["faulty_rows"][1]["line"], 2000);
}

/// Real products; skipped where they are not beside the project.
class RealProductsTest : public ImportTest {
 protected:
  void SetUp() override {
    const Path folder = Path(SARBLOCK_SHARED_DATA) / "sentinel1";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string name = entry.path().filename();
      if (name.starts_with("s1a-iw2-slc-vv-")) los_angeles_.push_back(entry.path());
      if (name.starts_with("S1A_IW_SLC__1SDV_2021")) bougainville_.push_back(entry.path());
      if (name.starts_with("s1a-iw3-slc-vv-2019")) faulty_.push_back(entry.path());
      if (name.ends_with(".EOF")) orbit_ = entry.path();
    }
    for (auto* files : {&los_angeles_, &bougainville_}) {
      std::sort(files->begin(), files->end());
      ASSERT_EQ(files->size(), 2u);
    }
    ASSERT_EQ(faulty_.size(), 1u);
  }
  std::vector<Path> los_angeles_, bougainville_, faulty_;
  Path orbit_;
};

// Real data: positions held, no corrections, so the residual is the misfit of the processor's own
// grid. Range 1 mm; along track 15 mm, two units of the time stamps (7 mm a microsecond).
TEST_F(RealProductsTest, LosAngelesFitsItsOrbits) {
  const ProgramRun run = Import(los_angeles_,
                                "la",
                                {"--grid",
                                 "control",
                                 "--grid-sigma-m",
                                 "1e-6",
                                 "--sigma-range-m",
                                 "0.001",
                                 "--sigma-azimuth-m",
                                 "0.01"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  ASSERT_EQ(Run("adjust", folder_ / "la", "held").exit_code, 0);
  EXPECT_EQ(Table("held/residuals.csv").size(), 421u);
  EXPECT_LT(Largest("held", "range_residual_m"), 1e-3);
  EXPECT_LT(Largest("held", "azimuth_residual_m"), 15e-3);
  EXPECT_GT(Largest("held", "azimuth_residual_m"), 1e-3);  // what microseconds leave
}

// With the standard deviations of a line and a pixel every bias is zero within its own.
TEST_F(RealProductsTest, LosAngelesNeedsNoCorrections) {
  ASSERT_EQ(Import(los_angeles_, "la", {"--grid", "control", "--grid-sigma-m", "0.01"}).exit_code,
            0);
  ASSERT_EQ(Run("adjust",
                folder_ / "la",
                "result",
                {"--set", "correction.time.bias=true", "--set", "correction.range.bias=true"})
                .exit_code,
            0);
  const auto corrections = Corrections("result");
  ASSERT_EQ(corrections.size(), 4u);
  for (const auto& [name, correction] : corrections) {
    EXPECT_GT(correction.sigma, 0.0) << name;
    EXPECT_LT(std::abs(correction.value), correction.sigma) << name;
  }
}

// On-board orbits: the mean misfit along track, 0.74 and 0.50 m at 6.8 km/s of the ground, becomes
// a time bias. Two ways to interpolate the orbit agree on it within the standard deviation of the
// worse.
TEST_F(RealProductsTest, BougainvilleHasATimeBiasForEachPass) {
  const auto corrections_of = [this](const std::string& through, const std::string& sigma_m) {
    const ProgramRun run = Import(bougainville_,
                                  through,
                                  {"--grid",
                                   "control",
                                   "--grid-sigma-m",
                                   "1e-6",
                                   "--sigma-range-m",
                                   "0.01",
                                   "--sigma-azimuth-m",
                                   sigma_m,
                                   "--orbit-through",
                                   through,
                                   "--id",
                                   "A",
                                   "B"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err.find("contradict") != std::string::npos ||
                  run.err.find("differ from the motion") != std::string::npos,
              through == "states");
    EXPECT_EQ(
        Run("adjust", folder_ / through, "r-" + through, {"--set", "correction.time.bias=true"})
            .exit_code,
        0);
    return Corrections("r-" + through);
  };
  auto states = corrections_of("states", "0.5");
  auto positions = corrections_of("positions", "0.05");
  for (const char* pass : {"A time.bias", "B time.bias"}) {
    const Correction &a = states[pass], &b = positions[pass];
    EXPECT_GT(a.value, 10.0 * a.sigma) << pass;
    EXPECT_LT(a.value * 6.8e3, 1.5) << pass;  // at most the metre and a half of the misfit
    EXPECT_LT(std::abs(a.value - b.value), a.sigma) << pass;
    EXPECT_NEAR(a.sigma, 0.5 / 6.82e3 / std::sqrt(210.0), 0.02 * a.sigma) << pass;  // closed form
  }
  EXPECT_LT(Largest("r-states", "azimuth_residual_m"), 1.0);
  EXPECT_LT(Largest("r-positions", "azimuth_residual_m"), 0.12);
  EXPECT_LT(Largest("r-states", "range_residual_m"), 0.01);
}

TEST_F(RealProductsTest, TheFaultyRowIsNamedAndTheRestIsGood) {
  const ProgramRun run = Import(faulty_,
                                "faulty",
                                {"--grid",
                                 "control",
                                 "--grid-sigma-m",
                                 "0.001",
                                 "--sigma-range-m",
                                 "0.01",
                                 "--sigma-azimuth-m",
                                 "0.01",
                                 "--json"});
  ASSERT_EQ(run.exit_code, 0);
  const auto rows = nlohmann::json::parse(run.out)["faulty_rows"];
  ASSERT_EQ(rows.size(), 9u);
  std::size_t positions = 0;
  for (const auto& row : rows) {
    if (row["fault"] == "height") {
      EXPECT_LT(std::abs(row["along_m"][0].get<double>()), 1.0);
      continue;
    }
    ++positions;
    EXPECT_EQ(row["line"], 13652);
    EXPECT_EQ(row["row"], 10);
    EXPECT_EQ(row["points"], 21);
    EXPECT_NEAR(row["along_m"][0].get<double>(), 19.5e3, 50.0);
    EXPECT_NEAR(row["along_m"][1].get<double>(), 19.5e3, 50.0);
  }
  EXPECT_EQ(positions, 1u);
  EXPECT_THAT(run.err, HasSubstr("geolocationGrid line 13652 (row 10): 21 of 21 points"));
  ASSERT_EQ(Run("adjust", folder_ / "faulty", "result").exit_code, 0);
  EXPECT_LT(Largest("result", "range_residual_m"), 0.04);
  EXPECT_LT(Largest("result", "azimuth_residual_m"), 0.015);
  const auto points = Table("result/points.csv");
  const std::size_t height = ColumnOf(points, "h_m"), status = ColumnOf(points, "status");
  std::size_t solved = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i][status] != "adjusted") continue;
    ++solved;
    EXPECT_NEAR(std::stod(points[i][height]), 688.0, 0.1) << points[i][0];  // one height for all
  }
  EXPECT_EQ(solved, 189u);
}

// Of another day than every product: refused by name. The file itself is read.
TEST_F(RealProductsTest, AnOrbitFileThatDoesNotCoverTheProductIsRefused) {
  const ProgramRun run = Import(faulty_, "block", {"--orbit", orbit_});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("no orbit file covers this product (S1A, 2019-08-09T16:40:50Z"));
  EXPECT_THAT(run.err, HasSubstr("2023-08-23T12:31:39Z to 2023-08-23T15:49:09Z"));
}

// The network and images of tests/truth/moon_images.py: points and measures agree to a millimetre.
TEST_F(ImportTest, AnOwnNetworkWithCubesOrIsdsBecomesABlockThatFits) {
  const Path corpus(SARBLOCK_FUZZ_CORPUS);
  const auto import = [&](const std::string& kind, const std::vector<std::string>& more) {
    const std::string ending = kind == "isis" ? ".cub" : ".json";
    const Path folder = corpus / (kind == "isis" ? "cube" : "isd");
    std::vector<std::string> arguments{"import", kind, corpus / "network/moon.net"};
    for (const char* name : {"one", "two"}) arguments.push_back(folder / (name + ending));
    arguments.insert(arguments.end(),
                     {"-o", folder_ / kind, "--range-sigma-m", "5", "--azimuth-sigma-m", "5"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  };
  const ProgramRun isis = import("isis", {"--json"});
  ASSERT_EQ(isis.exit_code, 0) << isis.err;
  const auto summary = nlohmann::json::parse(isis.out);
  EXPECT_EQ(summary["looks"], 24);
  EXPECT_EQ(summary["images"][1]["rejected"], 2);
  const ProgramRun csm = import("csm", {"--pixel-origin", "1"});
  ASSERT_EQ(csm.exit_code, 0) << csm.err;
  EXPECT_EQ(csm.err, "");
  for (const std::string kind : {"isis", "csm"}) {
    EXPECT_EQ(Run("adjust", folder_ / kind, kind + ".result").exit_code, 0);
    EXPECT_LT(Largest(kind + ".result", "range_residual_m"), 1e-3);
    EXPECT_LT(Largest(kind + ".result", "azimuth_residual_m"), 1e-3);
  }
  EXPECT_THAT(import("csm", {}).err, HasSubstr("--pixel-origin 1,1 takes it up"));
  const ProgramRun refused = import("csm", {"--pixel-origin", "1,x"});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err,
              HasSubstr("pixel-origin: must be a number or LINE,SAMPLE of -10 to 10, got '1,x'"));
}

TEST_F(ImportTest, ASerialListSaysWhichImageIsWhich) {
  const Path corpus(SARBLOCK_FUZZ_CORPUS);
  const auto import = [&](const std::string& list) {
    return RunProgram({"import",
                       "csm",
                       corpus / "network/moon.net",
                       "--serial-list",
                       Put("list.txt", list),
                       "-o",
                       folder_ / "block",
                       "--range-sigma-m",
                       "5",
                       "--azimuth-sigma-m",
                       "5",
                       "--pixel-origin",
                       "1"});
  };
  const std::string one =
      "LRO/MRFLRO/2012-03-04T05:06:07.890123=" + (corpus / "isd/one.json").string();
  const std::string two =
      "LRO/MRFLRO/2012-03-04T07:01:02.500000=" + (corpus / "isd/two.json").string();
  const ProgramRun run = import("# serial number and file\n" + one + "\n\n" + two + "\n");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(import(one + "\nno sign\n").err,
              HasSubstr("list.txt:2: 'no sign' is not SERIAL=FILE"));
  EXPECT_THAT(import(one + "\n").err, HasSubstr("1 of 2 have no image"));
}

}  // namespace
}  // namespace sarblock
