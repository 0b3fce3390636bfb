// SPDX-License-Identifier: Apache-2.0
#include "sarblock/files/scene_file.h"

#include "sarblock/core/error.h"

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "io/io_fixture.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

const char kText[] = R"(format = "sarblock-scene 1"
name = "two"
seed = 5
[[flight]]
id = "A"
heading_deg = 90
height_m = 9100
length_m = 21000
speed_mps = 173
swath_look_deg = [31.5, 67]
[looks]
range_sigma_m = 0.7
azimuth_sigma_s = 0.01
[points]
count = 7
east_m = [700, 19700]
north_m = [13100, 24900]
[control]
count = 2
sigma_m = [1, 2, 3]
components = ["u"]
[adjust]
robust = "huber"
[adjust.correction.range]
bias_sigma_m = 5.0
)";

std::string MessageOf(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    (void)files::ParseScene(text, "two.toml", overrides);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string Replaced(const std::string& from, const std::string& to) {
  std::string text = kText;
  return text.replace(text.find(from), from.size(), to);
}

TEST(SceneFileTest, ReadsEveryTable) {
  const Scene scene = files::ParseScene(kText, "two.toml");
  EXPECT_EQ(scene.name, "two");
  EXPECT_EQ(scene.seed, 5u);
  ASSERT_EQ(scene.flights.size(), 1u);
  EXPECT_DOUBLE_EQ(scene.flights[0].swath.limits[0], 31.5 * kRadPerDeg);
  EXPECT_EQ(scene.looks.azimuth.azimuth_unit, AzimuthUnit::kSeconds);
  EXPECT_EQ(scene.looks.azimuth.azimuth, 0.01);
  EXPECT_EQ(scene.points.count, 7u);
  EXPECT_EQ(scene.control.layout, SceneControl::Layout::kCorners);
  EXPECT_EQ(scene.control.fixed, (std::array<bool, 3>{false, false, true}));
  EXPECT_EQ(scene.check.layout, SceneControl::Layout::kNone);
}

TEST(SceneFileTest, AnOrbitIsGivenByItsAimOrByItsNode) {
  const std::vector<std::string> orbit = {"frame.kind=geocentric",
                                          "frame.ellipsoid=Moon",
                                          "flight.0.pattern=orbit",
                                          "flight.0.inclination_deg=87",
                                          "flight.0.count=3",
                                          "flight.0.node_lon_deg=-20",
                                          "flight.0.argument_of_latitude_deg=270",
                                          "flight.0.node_spacing_deg=30"};
  const SceneFlight flight = files::ParseScene(kText, "two.toml", orbit).flights[0];
  EXPECT_DOUBLE_EQ(flight.node_lon_rad, -20.0 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(flight.argument_of_latitude_rad, 270.0 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(flight.node_spacing_rad, 30.0 * kRadPerDeg);
  const auto message = [&](const std::string& other) {
    std::vector<std::string> overrides = orbit;
    overrides.push_back(other);
    return MessageOf(kText, overrides);
  };
  for (const char* other :
       {"aim_m=[0,0]", "aim_look_deg=40", "direction=descending", "spacing_m=100"}) {
    const std::string key(other, std::string(other).find('='));
    EXPECT_THAT(message(std::string("flight.0.") + other),
                HasSubstr("node_lon_deg: excludes " + key +
                          "; an orbit is given by its aim or by its node"));
  }
  EXPECT_THAT(message("flight.0.inclination_deg=180.1"), HasSubstr("from 0 to 180"));
  EXPECT_THAT(message("flight.0.pattern=strips"), HasSubstr("is for orbits only"));
  const auto without = [&](std::size_t left_out) {
    std::vector<std::string> overrides = orbit;
    overrides.erase(overrides.begin() + static_cast<std::ptrdiff_t>(left_out));
    return MessageOf(kText, overrides);
  };
  EXPECT_THAT(without(5), HasSubstr("node_lon_deg: must be given"));
  EXPECT_THAT(without(6), HasSubstr("argument_of_latitude_deg: must be given"));
  EXPECT_THAT(without(7), HasSubstr("node_spacing_deg: must be given and finite where count"));
}

TEST(SceneFileTest, PassesTheAdjustTableOnAsText) {
  const Scene scene = files::ParseScene(kText, "two.toml", {"adjust.robust=cauchy"});
  EXPECT_THAT(scene.adjust_toml, HasSubstr("[adjust]"));
  EXPECT_THAT(scene.adjust_toml, HasSubstr("[adjust.correction.range]"));
  EXPECT_THAT(scene.adjust_toml, HasSubstr("bias_sigma_m = 5.0"));
  EXPECT_THAT(scene.adjust_toml, HasSubstr("cauchy"));
  EXPECT_THAT(scene.adjust_toml, testing::Not(HasSubstr("huber")));
}

TEST(SceneFileTest, TakesOverridesOfKeysNewKeysAndListElements) {
  const Scene scene = files::ParseScene(kText,
                                        "two.toml",
                                        {"points.count=11",
                                         "flight.0.height_m=8000.5",
                                         "points.east_m.1=19000",
                                         "terrain.kind=rolling",
                                         "terrain.relief_m=40"});
  EXPECT_EQ(scene.points.count, 11u);
  EXPECT_EQ(scene.flights[0].height_m, 8000.5);
  EXPECT_EQ(scene.points.east_m[1], 19000.0);
  EXPECT_EQ(scene.terrain.kind, SceneTerrain::Kind::kRolling);
  EXPECT_EQ(scene.terrain.relief_m, 40.0);
}

TEST(SceneFileTest, CountsPointsFromADensity) {  // 19.0 km x 11.8 km x 0.5 = 112.1
  const Scene scene = files::ParseScene(Replaced("count = 7", "density_per_km2 = 0.5"), "two.toml");
  EXPECT_EQ(scene.points.count, 112u);
}

TEST(SceneFileTest, NamesFileLineAndFieldOfAnError) {
  EXPECT_EQ(MessageOf(Replaced("height_m = 9100", "height_m = -9100")),
            "two.toml:7: flight.0.height_m: must be given and positive");
  EXPECT_THAT(MessageOf(Replaced("length_m = 21000", "length_m = \"long\"")),
              HasSubstr("two.toml:8: flight.0.length_m: is a text, a number is needed"));
  // A key that does not stand: the line of its table.
  EXPECT_THAT(MessageOf(Replaced("length_m = 21000", "")),
              HasSubstr("two.toml:4: flight.0.length"));
  EXPECT_THAT(
      MessageOf(Replaced("count = 7", "count = 7.5")),
      HasSubstr("two.toml:15: points.count: is a number, an integer of 0 or more is needed"));
  EXPECT_THAT(
      MessageOf(Replaced("[31.5, 67]", "[31.5]")),
      HasSubstr(
          "two.toml:10: flight.0.swath_look_deg: is a list of 1, a list of 2 numbers is needed"));
  EXPECT_THAT(MessageOf(Replaced("seed = 5", "seed = ")), HasSubstr("two.toml:3: "));
  EXPECT_THAT(MessageOf(Replaced("sarblock-scene 1", "sarblock-scene 2")),
              HasSubstr("two.toml:1: format: "));
}

TEST(SceneFileTest, RefusesUnknownKeysWithTheNearestOne) {
  EXPECT_THAT(MessageOf(Replaced("speed_mps", "sped_mps")),
              testing::AllOf(HasSubstr("two.toml:9: flight.0.sped_mps: "),
                             HasSubstr("did you mean speed_mps?")));
  EXPECT_THAT(MessageOf(std::string(kText) + "[terain]\nrelief_m = 3\n"),
              HasSubstr("did you mean terrain?"));
  EXPECT_THAT(MessageOf(kText, {"points.conut=3"}), HasSubstr("points.conut"));
}

TEST(SceneFileTest, RefusesBadChoicesAndContradictions) {
  EXPECT_THAT(MessageOf(Replaced("id = \"A\"", "id = \"A\"\nlook = \"up\"")),
              HasSubstr("two.toml:6: flight.0.look: 'up' is not known, left or right is allowed"));
  EXPECT_THAT(
      MessageOf(Replaced("azimuth_sigma_s = 0.01", "azimuth_sigma_s = 0.01\nazimuth_sigma_m = 1")),
      HasSubstr("two.toml:13: looks.azimuth_sigma_s: excludes azimuth_sigma_m"));
  EXPECT_THAT(
      MessageOf(Replaced("azimuth_sigma_s = 0.01", "azimuth_sigma_s = 0.01\ndoppler_sigma_hz = 1")),
      HasSubstr("looks.doppler_sigma_hz: excludes azimuth_sigma_s"));
  EXPECT_THAT(MessageOf(Replaced("azimuth_sigma_s = 0.01", "doppler_sigma_hz = 1")),
              HasSubstr("looks.doppler_sigma_hz: needs cone = \"doppler\""));
  EXPECT_THAT(MessageOf(Replaced("swath_look_deg", "swath_ground_m = [1, 2]\nswath_look_deg")),
              HasSubstr("two.toml:10: flight.0.swath_ground_m: excludes swath_look_deg"));
  EXPECT_THAT(
      MessageOf(Replaced("swath_look_deg = [31.5, 67]", "swath_range_m = [5, 4]")),
      HasSubstr("two.toml:10: flight.0.swath_range_m: must be near and far, 0 <= near < far, "
                "got 5 and 4"));
  EXPECT_EQ(MessageOf(Replaced("swath_look_deg = [31.5, 67]", "swath_slant_m = [4, 5]")),
            "accepted");
  EXPECT_THAT(MessageOf(Replaced("components = [\"u\"]", "components = [\"h\"]")),
              HasSubstr("control.components[0]: 'h' is not known, e, n or u is allowed"));
  EXPECT_THAT(MessageOf(kText, {"points.count"}), HasSubstr("KEY=VALUE"));
  EXPECT_THAT(MessageOf(kText, {"flight.3.count=1"}), HasSubstr("no element 3"));
}

TEST(SceneFileTest, ReadsWanderAndRecorder) {
  const Scene scene = files::ParseScene(std::string(kText) + R"([wander]
rms_m = [1, 2, 3]
time_constant_s = [4, 5, 6]
[recorder]
rate_hz = 50
noise_m = 0.02
noise_mps = 0.01
drift_sigma_mps = [0.1, 0.2, 0.3]
velocity_bias_sigma_mps = [0.4, 0.5, 0.6]
jump_m = 0.7
jump_interval_s = 8
time_offset_s = -0.9
through = "smooth"
sigma_m = 0.03
sigma_mps = 0.04
)",
                                        "two.toml");
  EXPECT_EQ(scene.trajectory_error.rms_m, (std::array{1.0, 2.0, 3.0}));
  EXPECT_EQ(scene.trajectory_error.time_constant_s, (std::array{4.0, 5.0, 6.0}));
  ASSERT_TRUE(scene.recorder.has_value());
  EXPECT_EQ(scene.recorder->rate_hz, 50.0);
  EXPECT_EQ(scene.recorder->noise_m, 0.02);
  EXPECT_EQ(scene.recorder->noise_mps, 0.01);
  EXPECT_EQ(scene.recorder->drift_sigma_mps, (std::array{0.1, 0.2, 0.3}));
  EXPECT_EQ(scene.recorder->velocity_bias_sigma_mps, (std::array{0.4, 0.5, 0.6}));
  EXPECT_EQ(scene.recorder->jump_m, 0.7);
  EXPECT_EQ(scene.recorder->jump_interval_s, 8.0);
  EXPECT_EQ(scene.recorder->time_offset_s, -0.9);
  EXPECT_EQ(scene.recorder->reading.through, PathThrough::kSmooth);
  EXPECT_EQ(scene.recorder->reading.sigma.position_m, 0.03);
  EXPECT_EQ(scene.recorder->reading.sigma.velocity_mps, 0.04);
  EXPECT_FALSE(files::ParseScene(kText, "two.toml").recorder.has_value());
}

TEST(SceneFileTest, NamesTheLineOfAWrongRecorder) {
  EXPECT_EQ(MessageOf(std::string(kText) + "[recorder]\nrate_hz = 500\n"),
            "two.toml:27: recorder.rate_hz: must be from 0.01 to 200");
  EXPECT_THAT(MessageOf(std::string(kText) + "[recorder]\nthrough = \"points\"\n"),
              HasSubstr("two.toml:27: recorder.through: 'points' is not known"));
  EXPECT_THAT(MessageOf(std::string(kText) + "[recorder]\nnoise = 0.1\n"),
              HasSubstr("did you mean noise_m"));
  EXPECT_THAT(MessageOf(std::string(kText) + "[wander]\ntable = \"w.csv\"\n"),
              HasSubstr("two.toml:27: wander.table: is for scenes that are files"));
}

class WanderTableTest : public test::FolderTest {
 protected:
  std::string Message(const std::string& table) const {
    Put("w.csv", table);
    try {
      (void)files::ReadScene(Put("two.toml", std::string(kText) + "[wander]\ntable = \"w.csv\"\n"));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }
};

TEST_F(WanderTableTest, StandsInTheFolderOfTheScene) {
  Put("w.csv", "time_s,up_m,across_m,along_m\n-5,1,2,3\n40,4,5,6\n");
  const Scene scene =
      files::ReadScene(Put("two.toml", std::string(kText) + "[wander]\ntable = \"w.csv\"\n"));
  EXPECT_EQ(scene.trajectory_error.table_time_s, (std::vector{-5.0, 40.0}));
  EXPECT_EQ(scene.trajectory_error.table_m[1], Eigen::Vector3d(6.0, 5.0, 4.0));
}

TEST_F(WanderTableTest, IsRefusedWhereItIsNoTableOfOffsets) {
  const std::string head = "time_s,along_m,across_m,up_m\n";
  EXPECT_THAT(Message(head + "0,0,0,0\n0,1,1,1\n"), HasSubstr("w.csv:3: time_s: times must"));
  EXPECT_THAT(Message(head + "0,0,0,0\n"), HasSubstr("wander.table: has fewer than two rows"));
  EXPECT_THAT(Message("pass," + head), HasSubstr("wander.table: has a column 'pass'"));
  EXPECT_THAT(Message("time_s,along_m,across_m\n"), HasSubstr("up_m"));
  EXPECT_THAT(Message(head + "0,0,,0\n"), HasSubstr("w.csv:2: across_m"));
  std::filesystem::remove(folder_ / "w.csv");
  EXPECT_THROW((void)files::ReadScene(folder_ / "two.toml"), InputError);
}

TEST(SceneFileTest, RefusesAFileThatIsNotThere) {
  EXPECT_THROW((void)files::ReadScene("no/such/scene.toml"), InputError);
  EXPECT_THROW((void)files::ReadScene(SARBLOCK_DATASETS), InputError);  // a folder
}

}  // namespace
}  // namespace sarblock
