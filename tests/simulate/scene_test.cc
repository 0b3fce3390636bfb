// SPDX-License-Identifier: Apache-2.0
#include "sarblock/simulate/scene.h"

#include "sarblock/core/error.h"

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "simulate/small_scene.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

TEST(SceneTest, AcceptsTheSmallScene) {
  EXPECT_FALSE(FindProblem(test::SmallScene()).has_value());
  EXPECT_NO_THROW(Validate(test::SmallScene()));
}

TEST(SceneTest, NamesTheFieldOfEveryProblem) {
  using Break = std::function<void(Scene*)>;
  const std::vector<std::pair<std::string, Break>> broken = {
      {"name", [](Scene* s) { s->name.clear(); }},
      {"flight", [](Scene* s) { s->flights.clear(); }},
      {"flight.0.id", [](Scene* s) { s->flights[0].id.clear(); }},
      {"flight.1.id", [](Scene* s) { s->flights.push_back(s->flights[0]); }},
      {"flight.0.count", [](Scene* s) { s->flights[0].count = 0; }},
      {"flight.0.height_m", [](Scene* s) { s->flights[0].height_m = -1.0; }},
      {"flight.0.length_m", [](Scene* s) { s->flights[0].length_m = kNotGiven; }},
      {"flight.0.speed_mps", [](Scene* s) { s->flights[0].speed_mps = 0.0; }},
      {"flight.0.heading_deg", [](Scene* s) { s->flights[0].heading_rad = kNotGiven; }},
      {"flight.0.spacing_m", [](Scene* s) { s->flights[0].spacing_m = kNotGiven; }},
      {"flight.0.overlap", [](Scene* s) { s->flights[0].overlap = 0.6; }},
      {"flight.0.squint_deg", [](Scene* s) { s->flights[0].squint_rad = 1.1; }},
      {"flight.0.swath",
       [](Scene* s) {
         s->flights[0].swath.limits = {5.0, 5.0};
       }},
      {"flight.0.state_spacing_s", [](Scene* s) { s->flights[0].state_spacing_s = 0.0; }},
      {"flight.0.wavelength_m", [](Scene* s) { s->looks.doppler = true; }},
      {"flight.0.pattern", [](Scene* s) { s->flights[0].pattern = SceneFlight::Pattern::kOrbit; }},
      {"looks.range_sigma_m", [](Scene* s) { s->looks.range_sigma_m = kNotGiven; }},
      {"looks.azimuth_sigma_m", [](Scene* s) { s->looks.azimuth.azimuth = 0.0; }},
      {"looks.blunder_fraction", [](Scene* s) { s->looks.blunder_fraction = 1.0; }},
      {"wander.rms_m", [](Scene* s) { s->trajectory_error.rms_m[1] = -1.0; }},
      {"wander.time_constant_s", [](Scene* s) { s->trajectory_error.rms_m[2] = 1.0; }},
      {"wander.table", [](Scene* s) { s->trajectory_error.table_time_s = {1.0}; }},
      {"wander.table",
       [](Scene* s) {
         s->trajectory_error.table_time_s = {1.0, 1.0};
         s->trajectory_error.table_m.resize(2, Eigen::Vector3d::Zero());
       }},
      {"recorder.rate_hz", [](Scene* s) { s->recorder.emplace().rate_hz = 0.0099; }},
      {"recorder.rate_hz", [](Scene* s) { s->recorder.emplace().rate_hz = 201.0; }},
      {"recorder.noise_m", [](Scene* s) { s->recorder.emplace().noise_m = -1.0; }},
      {"recorder.noise_mps", [](Scene* s) { s->recorder.emplace().noise_mps = kNotGiven; }},
      {"recorder.drift_sigma_mps",
       [](Scene* s) { s->recorder.emplace().drift_sigma_mps[0] = -1.0; }},
      {"recorder.velocity_bias_sigma_mps",
       [](Scene* s) { s->recorder.emplace().velocity_bias_sigma_mps[2] = -1.0; }},
      {"recorder.jump_m", [](Scene* s) { s->recorder.emplace().jump_m = -1.0; }},
      {"recorder.jump_interval_s", [](Scene* s) { s->recorder.emplace().jump_m = 1.0; }},
      {"recorder.sigma_m", [](Scene* s) { s->recorder.emplace().reading.sigma.position_m = 0.0; }},
      {"recorder.sigma_mps",
       [](Scene* s) { s->recorder.emplace().reading.sigma.velocity_mps = -1.0; }},
      {"recorder.time_offset_s", [](Scene* s) { s->recorder.emplace().time_offset_s = kNotGiven; }},
      {"navigation.curvature_sigma_m", [](Scene* s) { s->navigation.curvature_sigma_m[1] = -2.0; }},
      {"navigation.drift_sigma_m", [](Scene* s) { s->navigation.drift_sigma_m[2] = -1.0; }},
      {"navigation.knot_spacing_s",
       [](Scene* s) { s->navigation.process = SceneNavigation::Process::kRandomWalk; }},
      {"points.east_m",
       [](Scene* s) {
         s->points.east_m = {3.0, 3.0};
       }},
      {"terrain.relief_m", [](Scene* s) { s->terrain.relief_m = -2.0; }},
      {"control.sigma_m", [](Scene* s) { s->control.layout = SceneControl::Layout::kGrid; }},
      {"control.count",
       [](Scene* s) {
         s->control.layout = SceneControl::Layout::kCorners;
         s->control.count = 5;
       }},
      {"control.north_m",
       [](Scene* s) {
         s->control.layout = SceneControl::Layout::kGrid;
         s->control.sigma_m = {1, 1, 1};
         s->control.north_m = {14300.0, 14100.0};
       }},
      {"check.inset",
       [](Scene* s) {
         s->check.layout = SceneControl::Layout::kRandom;
         s->check.sigma_m = {1, 1, 1};
         s->check.inset = 0.5;
       }},
  };
  for (const auto& [field, change] : broken) {
    Scene scene = test::SmallScene();
    change(&scene);
    const auto problem = FindProblem(scene);
    ASSERT_TRUE(problem.has_value()) << field;
    EXPECT_EQ(problem->field, field);
    EXPECT_THROW(Validate(scene), InputError) << field;
  }
}

}  // namespace
}  // namespace sarblock
