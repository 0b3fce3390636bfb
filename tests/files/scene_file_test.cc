// SPDX-License-Identifier: Apache-2.0
#include "sarblock/files/scene_file.h"

#include "sarblock/core/error.h"

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "support/folder_test.h"
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

TEST(SceneFileTest, AScenePassedAsTextHasNoWanderTable) {
  EXPECT_EQ(test::MessageOf<InputError>([] {
              return files::ParseScene(std::string(kText) + "[wander]\ntable = \"w.csv\"\n",
                                       "two.toml");
            }),
            "two.toml:27: wander.table: is for scenes that are files, whose folder it counts from");
}

using WanderTableTest = test::FolderTest;

TEST_F(WanderTableTest, IsInTheFolderOfTheScene) {
  Put("w.csv", "time_s,up_m,across_m,along_m\n-5,1,2,3\n40,4,5,6\n");
  const Scene scene =
      files::ReadScene(Put("two.toml", std::string(kText) + "[wander]\ntable = \"w.csv\"\n"));
  EXPECT_EQ(scene.trajectory_error.table_time_s, (std::vector{-5.0, 40.0}));
  EXPECT_EQ(scene.trajectory_error.table_m[1], Eigen::Vector3d(6.0, 5.0, 4.0));
}

}  // namespace
}  // namespace sarblock
