// SPDX-License-Identifier: Apache-2.0
// Every kind of input that cannot be used, through the program: exit code 3, the message names
// file, line and field, and nothing is written.
#include <functional>
#include <string>

#include "cli/cli_fixture.h"
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

const char kToml[] = R"(format = "sarblock-block 1"
name = "pair"
[frame]
kind = "local"
[sigma]
range_m = 1.3
azimuth_m = 0.9
[[pass]]
id = "A"
look = "left"
[[pass]]
id = "B"
look = "left"
)";
const char kPaths[] =
    "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\n"
    "A,0,-700,0,9100,173,0,0\n"
    "A,70,11410,0,9100,173,0,0\n"
    "B,0,-700,7900,9300,173,0,0\n"
    "B,70,11410,7900,9300,173,0,0\n";
const char kLooks[] =
    "pass,point,time_s,range_m\n"
    "A,P1,31.25,17601.5\n"
    "B,P1,31.25,11723.25\n"
    "A,P2,47.5,19412.75\n"
    "B,P2,47.5,13127.5\n";
const char kPoints[] =
    "point,role,x_m,y_m,z_m,sigma_e_m,sigma_n_m,sigma_u_m\n"
    "P1,tie,4700,15000,90,,,\n";

struct Fault {
  const char* file;
  const char* from;
  const char* to;
  const char* message;  ///< after the block's folder and a slash
};

const Fault kFaults[] = {
    {"block.toml", "sarblock-block 1", "sarblock-block 7", "block.toml:1: format: "},
    {"block.toml", "name = ", "name == ", "block.toml:2: is not valid TOML"},
    {"block.toml", "kind = \"local\"", "kind = \"lokal\"", "block.toml:4: frame.kind: "},
    {"block.toml", "range_m = 1.3", "range_m = -1.3", "block.toml:6: sigma.range_m: "},
    {"block.toml", "range_m = 1.3", "range_m = \"1.3\"", "block.toml:6: sigma.range_m: "},
    {"block.toml", "look = \"left\"", "look = \"up\"", "block.toml:10: pass[0].look: "},
    {"block.toml", "id = \"B\"", "id = \"A\"", "block.toml:12: pass[1].id: "},
    {"block.toml",
     "[[pass]]",
     "[adjust]\nrobust = \"huebr\"\n[[pass]]",
     "block.toml:9: adjust.robust: "},
    {"block.toml",
     "[[pass]]",
     "[adjust]\nrobst = \"huber\"\n[[pass]]",
     "block.toml:9: adjust.robst: "},
    {"trajectories.csv", "A,70", "A,seventy", "trajectories.csv:3: time_s: "},
    {"trajectories.csv", "A,70", "A,0", "trajectories.csv:3: time_s: "},
    {"trajectories.csv", "A,70", "A,nan", "trajectories.csv:3: time_s: "},
    {"trajectories.csv", "A,70", "C,70", "trajectories.csv:3: pass: "},
    {"trajectories.csv", ",vz_mps", ",vz", "trajectories.csv:1: vz_mps: "},
    {"trajectories.csv", "173,0,0", "0,0,0", "trajectories.csv:2: "},
    {"trajectories.csv", "A,0,-700", "A,0,-1e308", "trajectories.csv:2: x_m: "},
    {"trajectories.csv", "173,0,0", "173,0,3e8", "trajectories.csv:2: vz_mps: "},
    {"observations.csv", "17601.5", "1e308", "observations.csv:2: range_m: "},
    {"observations.csv", "17601.5", "", "observations.csv:2: range_m: "},
    {"observations.csv", "17601.5", "-17601.5", "observations.csv:2: range_m: "},
    {"observations.csv", "17601.5", "1e999", "observations.csv:2: range_m: "},
    {"observations.csv", "31.25", "71.25", "observations.csv:2: time_s: "},
    {"observations.csv", "A,P2", "A,P1", "observations.csv:4: "},
    {"observations.csv", "range_m", "range", "observations.csv:1: range_m: "},
    {"observations.csv", "A,P1,31.25", "Z,P1,31.25", "observations.csv:2: pass: "},
    {"observations.csv", "B,P1,31.25,11723.25", "B,P1,31.25", "observations.csv:3: "},
    {"points.csv", "tie", "tied", "points.csv:2: role: "},
    {"points.csv",
     "P1,tie,4700,15000,90,,,",
     "P1,control,4700,15000,90,0,1,1",
     "points.csv:2: sigma_e_m: "},
    {"points.csv", "P1,tie,4700", "P1,control,", "points.csv:2: x_m: "},
    {"points.csv", "P1,tie,4700,15000", "P1,check,4700,1e308", "points.csv:2: y_m: "},
    {"points.csv", "P1,tie,4700,15000,90", "P1,check,4700,15000,-1e13", "points.csv:2: z_m: "},
};

class BadInputTest : public test::CliTest {
 protected:
  Path Block() const {
    const Path block = folder_ / "block";
    std::filesystem::create_directories(block);
    Put("block/block.toml", kToml);
    Put("block/trajectories.csv", kPaths);
    Put("block/observations.csv", kLooks);
    Put("block/points.csv", kPoints);
    return block;
  }
};

TEST_F(BadInputTest, TheBlockWithoutAFaultIsAccepted) {
  const test::ProgramRun check = test::RunProgram({"check", Block()});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_EQ(check.err, "");
  EXPECT_EQ(Run("adjust", Block(), "result").exit_code, 0);
}

TEST_F(BadInputTest, EveryFaultIsNamedWithItsPlaceAndNothingIsWritten) {
  for (const Fault& fault : kFaults) {
    const Path block = Block();
    Edit(block / fault.file, fault.from, fault.to);
    const std::string message = (block / fault.message).string();
    SCOPED_TRACE(message);
    for (const std::string command : {"check", "adjust", "intersect"}) {
      const test::ProgramRun run =
          command == "check" ? test::RunProgram({command, block}) : Run(command, block, "result");
      EXPECT_EQ(run.exit_code, 3) << command;
      EXPECT_THAT(run.err, HasSubstr(message)) << command;
      EXPECT_EQ(run.out, "") << command;
    }
    EXPECT_FALSE(std::filesystem::exists(folder_ / "result"));
    EXPECT_EQ(FilesOf(block).size(), 4u);
  }
}

TEST_F(BadInputTest, MissingFilesAndFoldersAreNamed) {
  for (const char* name : {"block.toml", "trajectories.csv", "observations.csv"}) {
    const Path block = Block();
    std::filesystem::remove(block / name);
    const test::ProgramRun run = Run("adjust", block, "result");
    EXPECT_EQ(run.exit_code, 3) << name;
    EXPECT_THAT(run.err, HasSubstr((block / name).string()));
  }
  const test::ProgramRun none = Run("adjust", folder_ / "no such block", "result");
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_THAT(none.err, HasSubstr("no such block"));
  const test::ProgramRun file = Run("adjust", Block() / "points.csv", "result");
  EXPECT_EQ(file.exit_code, 3);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "result"));
}

TEST_F(BadInputTest, ADamagedGzipIsRefused) {
  const Path block = Block();
  PutGzip("block/observations.csv.gz", kLooks);
  std::filesystem::remove(block / "observations.csv");
  std::string bytes = Content(block / "observations.csv.gz");
  EXPECT_EQ(test::RunProgram({"check", block}).exit_code, 0);
  Put("block/observations.csv.gz", bytes.substr(0, bytes.size() - 9));
  const test::ProgramRun run = Run("adjust", block, "result");
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("observations.csv.gz"));
}

TEST_F(BadInputTest, OverridesAreCheckedLikeTheFile) {
  for (const char* set : {"robust=huebr",
                          "robst=huber",
                          "max_iterations=0",
                          "max_iterations=x",
                          "correction.position.degree=-1",
                          "robust",
                          "=huber"}) {
    const test::ProgramRun run = Run("adjust", Block(), "result", {"--set", set});
    EXPECT_EQ(run.exit_code, 3) << set;
    EXPECT_THAT(run.err, HasSubstr("--set")) << set;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "result")) << set;
  }
}

TEST_F(BadInputTest, AResultFolderThatCannotBeMadeIsNamed) {
  const Path block = Block();
  Put("taken", "a file\n");
  const test::ProgramRun run = Run("adjust", block, "taken/result");
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("taken"));
  EXPECT_EQ(Content(folder_ / "taken"), "a file\n");
}

TEST_F(BadInputTest, AFaultyPairListIsNamed) {
  const Path block = Block();
  Put("block/pairs.csv", "point_a,point_b\nP1,P2\nP1,P9\n");
  const test::ProgramRun run = Run("adjust", block, "result", {"--set", "pairs=pairs.csv"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("pairs.csv:3: point_b: "));
}

TEST_F(BadInputTest, AFaultySceneIsNamedAndNoBlockIsLeft) {
  const Path scene = Put("scene.toml", "format = \"sarblock-scene 1\"\n[points]\ncuont = 3\n");
  const test::ProgramRun run = test::RunProgram({"simulate", scene, "-o", folder_ / "block"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr(scene.string() + ":3: points.cuont: "));
  EXPECT_EQ(run.out, "");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "block"));
}

// What refuses these knows no files: the simulation, the adjustment.
TEST_F(BadInputTest, ErrorsOfTheLibraryNameTheFileWorkedOn) {
  const Path scene = std::filesystem::path(SARBLOCK_DATASETS) / "scenes/venus-magellan.toml";
  const test::ProgramRun far =
      test::RunProgram({"simulate", scene, "-o", folder_ / "b", "--set", "flight.0.length_m=1e12"});
  EXPECT_EQ(far.exit_code, 3);
  EXPECT_THAT(far.err, HasSubstr(scene.string() + ": flight C1-: "));
  const Path block = Block();
  const test::ProgramRun run = Run(
      "adjust", block, "result", {"--set", "robust=huber", "--set", "quality.snooping=iterative"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr(block.string() + ": adjust.quality.snooping: "));
}

// Leberl (1979), Fig. 5: forward and backward squinted looks from one flight line.
TEST_F(BadInputTest, ABlockThatCannotBeDeterminedExitsWithFourAndTheReason) {
  const Path block = Simulated("single-flight-squint", "squinted");
  const test::ProgramRun run = Run("adjust", block, "result");
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err, HasSubstr("single flight line"));
  EXPECT_THAT(run.err, HasSubstr("K1"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "result"));
  EXPECT_EQ(test::RunProgram({"check", block}).exit_code, 0);  // nothing wrong with its files
}

}  // namespace
}  // namespace sarblock
