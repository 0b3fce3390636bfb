// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/simulate/simulate.h"

#include <cmath>

#include "geometry/track_axes.h"
#include "simulate/true_path.h"
#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

Scene OrbitScene() {
  SceneFlight flight;
  flight.id = "O";
  flight.pattern = SceneFlight::Pattern::kOrbit;
  flight.side = LookSide::kRight;
  flight.height_m = 693000.0;
  flight.length_m = 110000.0;
  flight.inclination_rad = 98.18 * kRadPerDeg;
  flight.swath = {SwathKind::kLookAngle, {29.0 * kRadPerDeg, 39.0 * kRadPerDeg}};
  Scene scene;
  scene.name = "orbit";
  scene.frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  scene.centre = {45.63 * kRadPerDeg, 10.28 * kRadPerDeg, 0.0};
  scene.flights.push_back(flight);
  scene.looks.range_sigma_m = 0.5;
  scene.looks.azimuth.azimuth = 1.0;
  scene.points.count = 20;
  scene.points.min_looks = 1;
  scene.points.east_m = {-21000.0, 21000.0};
  scene.points.north_m = {-21000.0, 21000.0};
  return scene;
}

Motion MiddleOf(const Pass& pass) { return *pass.path.At(0.5 * (pass.start_s + pass.end_s)); }

TEST(OrbitTest, SeesItsAimAtTheMiddleOfTheStrip) {  // definition of the pattern
  for (const bool descending : {false, true}) {
    for (const LookSide side : {LookSide::kLeft, LookSide::kRight}) {
      for (const double lat_deg : {45.63, -37.1, 0.2}) {
        Scene scene = OrbitScene();
        scene.centre.lat_rad = lat_deg * kRadPerDeg;
        scene.flights[0].descending = descending;
        scene.flights[0].side = side;
        scene.flights[0].squint_rad = 0.04;
        const SimulatedBlock simulated = Simulate(scene);
        const Motion motion = MiddleOf(simulated.block.passes[0]);
        const Eigen::Vector3d aim_m = FrameFromPlane(scene, {0.0, 0.0}, 0.0);
        const Eigen::Matrix3d axes = TrackAxesOf(scene.frame, motion).axes;
        const Eigen::Vector3d d = aim_m - motion.position_m;
        // Nominal states every second are interpolated to some nanometres: 1e-8 rad is 1 cm.
        EXPECT_NEAR(motion.velocity_mps.normalized().dot(d), d.norm() * std::sin(0.04), 0.02);
        const double across_m = d.dot(axes.col(1)) * static_cast<double>(side);
        EXPECT_NEAR(std::atan2(across_m, -d.dot(axes.col(2))), 34.0 * kRadPerDeg, 1e-8);
        EXPECT_EQ(motion.velocity_mps.z() < 0.0, descending);
        EXPECT_EQ(simulated.block.looks.size(), 20u);
      }
    }
  }
}

// Spherical triangle of axis, aim and the normal of the orbit's plane, which is 90 degrees less the
// distance of the aim from the track: law of sines from look angle 34, 7.0711e6 m and 6.3568e6 m.
TEST(OrbitTest, SeesAimsBesideThePoles) {
  const double look_rad = 34.0 * kRadPerDeg;
  const double off_rad = std::asin(7071137.0 / 6356900.0 * std::sin(look_rad)) - look_rad;
  for (const double lat_deg : {89.9, 89.5, 88.0, -86.0, -88.0, -89.0, -89.5, -89.9}) {
    for (const LookSide side : {LookSide::kLeft, LookSide::kRight}) {
      for (const double part : {-0.9, 0.0, 0.9}) {
        Scene scene = OrbitScene();
        const double lat_rad = lat_deg * kRadPerDeg, from_pole_rad = 0.5 * M_PI - std::abs(lat_rad);
        // A normal that is off to the aim's side of the axis at that pole.
        const double toward = static_cast<double>(side) * std::copysign(1.0, lat_deg);
        scene.flights[0].inclination_rad = 0.5 * M_PI - toward * off_rad + part * from_pole_rad;
        scene.centre.lat_rad = lat_rad;
        scene.flights[0].side = side;
        scene.points.min_looks = 0;
        const SimulatedBlock simulated = Simulate(scene);
        const Motion motion = MiddleOf(simulated.block.passes[0]);
        const Eigen::Vector3d d = FrameFromPlane(scene, {0.0, 0.0}, 0.0) - motion.position_m;
        const Eigen::Matrix3d axes = TrackAxesOf(scene.frame, motion).axes;
        EXPECT_NEAR(motion.velocity_mps.normalized().dot(d), 0.0, 0.02) << lat_deg << ' ' << part;
        const double across_m = d.dot(axes.col(1)) * static_cast<double>(side);
        EXPECT_NEAR(std::atan2(across_m, -d.dot(axes.col(2))), look_rad, 1e-8);
      }
    }
  }
}

TEST(OrbitTest, IsACircleFlownAtTheSpeedOfItsRadius) {
  // Closed form: inertial speed sqrt(GM/r) with GM = 3.986004418e14, body rotation 7.292115e-5.
  const SimulatedBlock simulated = Simulate(OrbitScene());
  const double r_m = 6378137.0 + 693000.0;
  const Eigen::Vector3d rotation_rad_per_s(0.0, 0.0, 7.292115e-5);
  const double inclination = std::cos(98.18 * kRadPerDeg);
  for (const StateVector& state : simulated.block.passes[0].path.states()) {
    EXPECT_NEAR(state.position_m.norm(), r_m, 1e-7);
    const Eigen::Vector3d inertial_mps =
        state.velocity_mps + rotation_rad_per_s.cross(state.position_m);
    EXPECT_NEAR(inertial_mps.norm(), std::sqrt(3.986004418e14 / r_m), 1e-8);
    const Eigen::Vector3d normal = state.position_m.cross(inertial_mps).normalized();
    EXPECT_NEAR(normal.z(), inclination, 1e-12);
  }
}

TEST(OrbitTest, VelocityIsTheDerivativeOfPosition) {  // central difference of neighbouring states
  const SimulatedBlock simulated = Simulate(OrbitScene());
  const auto& states = simulated.block.passes[0].path.states();
  const std::size_t i = states.size() / 2;
  const double span_s = states[i + 1].time_s - states[i - 1].time_s;
  const Eigen::Vector3d slope_mps = (states[i + 1].position_m - states[i - 1].position_m) / span_s;
  // Third derivative r n^3 = 8 mm/s^3, over h^2/6 = 1/6 s^2: 1.4 mm/s.
  EXPECT_LT((slope_mps - states[i].velocity_mps).norm(), 2e-3);
}

TEST(OrbitTest, TruePathTurnsWithTheTrackAxes) {
  // Numerical route: central differences over 0.1 s inside one interval of the nominal states, of
  // the shift from the nominal path, so that the orbit itself (7 km/s) drops out.
  Scene scene = OrbitScene();
  scene.navigation.constant_sigma_m = {310.0, 470.0, 290.0};
  scene.navigation.drift_sigma_m = {370.0, 530.0, 230.0};
  const SimulatedBlock simulated = Simulate(scene);
  const Pass& pass = simulated.block.passes[0];
  const TruePath path(simulated.block.frame, pass, simulated.errors[0], kNotGiven);
  const auto& states = pass.path.states();
  const double middle_s = 0.5 * (states[9].time_s + states[10].time_s);
  const auto shift = [&](double t_s) {
    const auto truth = path.At(t_s), nominal = pass.path.At(t_s);
    Motion motion;
    motion.position_m = truth->position_m - nominal->position_m;
    motion.velocity_mps = truth->velocity_mps - nominal->velocity_mps;
    motion.acceleration_mps2 = truth->acceleration_mps2 - nominal->acceleration_mps2;
    return motion;
  };
  const Motion before = shift(middle_s - 0.05), at = shift(middle_s),
               after = shift(middle_s + 0.05);
  // Positions of 7e6 m round at 1e-9 m, velocities at 1e-12 m/s; both over 0.1 s.
  EXPECT_LT(((after.position_m - before.position_m) / 0.1 - at.velocity_mps).norm(), 1e-7);
  EXPECT_LT(((after.velocity_mps - before.velocity_mps) / 0.1 - at.acceleration_mps2).norm(), 1e-8);
  EXPECT_GT(at.acceleration_mps2.norm(), 1e-3);
}

TEST(OrbitTest, ShiftsTheAimByTheSpacing) {
  Scene scene = OrbitScene();
  scene.flights[0].count = 3;
  scene.flights[0].spacing_m = 14000.0;
  const SimulatedBlock simulated = Simulate(scene);
  const Motion first = MiddleOf(simulated.block.passes[0]);
  const Motion last = MiddleOf(simulated.block.passes[2]);
  // The base between tracks: 28 km east, scaled by r/a, by cos of the track's angle to north.
  const double base_m = std::abs(
      (last.position_m - first.position_m).dot(TrackAxesOf(scene.frame, first).axes.col(1)));
  const double angle_rad = std::asin(std::cos(98.18 * kRadPerDeg) / std::cos(45.63 * kRadPerDeg));
  // Curvature and the different latitude of track and aim change it by some percent.
  EXPECT_NEAR(base_m, 28000.0 * 7071137.0 / 6378137.0 * std::cos(angle_rad), 1500.0);
}

TEST(OrbitTest, RefusesAnAimItCannotSee) {
  Scene scene = OrbitScene();
  scene.flights[0].inclination_rad = 20.0 * kRadPerDeg;  // reaches 20 degrees north
  try {
    (void)Simulate(scene);
    FAIL() << "simulated";
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("flight O"), std::string::npos) << text;
    // The aim is 44.56 degrees (geocentric) from the axis, the normal of a plane 4.39 degrees
    // beside it 94.39 from the aim.
    EXPECT_NE(text.find("inclinations from 49.8"), std::string::npos) << text;
    EXPECT_NE(text.find(" to 139 degrees"), std::string::npos) << text;
  }
}

TEST(OrbitTest, NeedsSpeedAndRotationForABodyGivenByNumbers) {
  Scene scene = OrbitScene();
  scene.frame = Frame::Geocentric({"", 6378137.0, 0.00335});
  EXPECT_THROW((void)Simulate(scene), InputError);
  scene.flights[0].speed_mps = 7500.0;
  scene.rotation_rad_per_s = 0.0;
  EXPECT_EQ(Simulate(scene).block.looks.size(), 20u);
}

}  // namespace
}  // namespace sarblock
