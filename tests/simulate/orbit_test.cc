// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/simulate/scene.h"

#include <cmath>
#include <vector>

#include "geometry/track_axes.h"
#include "simulate/nominal_paths.h"
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

/// A lunar orbit by its node, 100 km high.
Scene NodeScene() {
  Scene scene = OrbitScene();
  scene.frame = Frame::Geocentric(NamedEllipsoid("Moon"));
  scene.centre = {-90.0 * kRadPerDeg, 0.0, 0.0};
  SceneFlight& flight = scene.flights[0];
  flight.height_m = 100e3;
  flight.length_m = 90e3;
  flight.inclination_rad = 90.0 * kRadPerDeg;
  flight.node_lon_rad = 0.0;
  flight.argument_of_latitude_rad = 90.0 * kRadPerDeg;
  flight.swath = {SwathKind::kLookAngle, {25.0 * kRadPerDeg, 55.0 * kRadPerDeg}};
  return scene;
}

// Hand arithmetic: inclination 90 and node 0 lie in the plane y = 0, from +x over +z. A quarter
// later the pass is over the north pole and flies along -x, less the turning of the frame, which
// there is none of on the axis.
TEST(OrbitByNodeTest, PassesOverThePoleAQuarterAfterItsNode) {
  Scene scene = NodeScene();
  scene.centre.lat_rad = 90.0 * kRadPerDeg;
  scene.flights[0].swath.limits = {0.01, 55.0 * kRadPerDeg};
  const Motion motion = MiddleOf(Simulate(scene).block.passes[0]);
  // States of a second apart are interpolated: 1e-4 m over r n^4 / 384 = 2e-9 m.
  EXPECT_LT((motion.position_m - Eigen::Vector3d(0.0, 0.0, 1837.4e3)).norm(), 1e-4);
  EXPECT_NEAR(motion.velocity_mps.normalized().x(), -1.0, 1e-9);
}

// Closed form: sin(latitude) = sin i sin u; the longitude from the node has tan = cos i tan u.
TEST(OrbitByNodeTest, IsAtItsArgumentOfLatitudeAtTheMiddleOfTheStrip) {
  Scene scene = NodeScene();
  SceneFlight& flight = scene.flights[0];
  flight.count = 3;
  flight.node_spacing_rad = 41.0 * kRadPerDeg;
  flight.node_lon_rad = 17.0 * kRadPerDeg;
  for (const double i_deg : {0.0, 28.6, 87.2, 131.0, 180.0}) {
    for (const double u_deg : {-70.0, 13.0, 155.0, 270.0}) {
      const double i = i_deg * kRadPerDeg, u = u_deg * kRadPerDeg;
      flight.inclination_rad = i;
      flight.argument_of_latitude_rad = u;
      const std::vector<NominalPass> planned = PlanPasses(scene);
      ASSERT_EQ(planned.size(), 3U);
      for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3d p = MiddleOf(planned[k].pass).position_m.normalized();
        EXPECT_NEAR(p.z(), std::sin(i) * std::sin(u), 1e-10) << i_deg << ' ' << u_deg;
        const double node = (17.0 + 41.0 * static_cast<double>(k)) * kRadPerDeg;
        const double longitude = node + std::atan2(std::cos(i) * std::sin(u), std::cos(u));
        EXPECT_NEAR(std::remainder(std::atan2(p.y(), p.x()) - longitude, 2.0 * M_PI), 0.0, 1e-9);
      }
    }
  }
}

// Closed form: while the pass flies from its node to the middle, u/n, the body turns by w u/n.
TEST(OrbitByNodeTest, CrossesItsNodeAtALongitudeFartherEastByTheTurningOfTheBody) {
  Scene scene = OrbitScene();
  SceneFlight& flight = scene.flights[0];
  flight.node_lon_rad = -0.3;
  flight.argument_of_latitude_rad = 0.02;
  flight.length_m = 700e3;
  const Pass pass = PlanPasses(scene)[0].pass;
  const double r_m = 6378137.0 + 693000.0;
  const double after_s = 0.02 / std::sqrt(3.986004418e14 / (r_m * r_m * r_m));
  const Motion motion = *pass.path.At(0.5 * (pass.start_s + pass.end_s) - after_s);
  EXPECT_NEAR(motion.position_m.z(), 0.0, 1e-3);
  const double crossing = std::atan2(motion.position_m.y(), motion.position_m.x());
  EXPECT_NEAR(crossing, -0.3 + 7.292115e-5 * after_s, 1e-10);
}

// Two routes: node, argument and inclination of an aimed orbit by the vectors of its middle state.
TEST(OrbitByNodeTest, GivesTheStatesOfTheSameOrbitByItsAim) {
  for (const bool descending : {false, true}) {
    Scene scene = OrbitScene();
    SceneFlight& flight = scene.flights[0];
    flight.descending = descending;
    const Pass aimed = PlanPasses(scene)[0].pass;
    const Motion middle = MiddleOf(aimed);
    const Eigen::Vector3d rotation(0.0, 0.0, 7.292115e-5);
    const Eigen::Vector3d normal =
        middle.position_m
            .cross(middle.velocity_mps + Eigen::Vector3d(rotation.cross(middle.position_m)))
            .normalized();
    const Eigen::Vector3d node = Eigen::Vector3d::UnitZ().cross(normal).normalized();
    flight.descending = false;
    flight.node_lon_rad = std::atan2(node.y(), node.x());
    flight.argument_of_latitude_rad =
        std::atan2(middle.position_m.dot(normal.cross(node)), middle.position_m.dot(node));
    const Pass by_node = PlanPasses(scene)[0].pass;
    const auto& states = aimed.path.states();
    ASSERT_EQ(by_node.path.states().size(), states.size());
    for (std::size_t i = 0; i < states.size(); ++i) {
      const StateVector& state = by_node.path.states()[i];
      EXPECT_LT((state.position_m - states[i].position_m).norm(), 1e-3);
      EXPECT_LT((state.velocity_mps - states[i].velocity_mps).norm(), 1e-6);
    }
  }
}

// Hand arithmetic: look 40 off nadir from 1837.4 km meets the ground, 1737.4 km, at an incidence of
// 42.83 and 2.83 degrees beside the track, which is that far from the pole.
TEST(OrbitByNodeTest, PassesAllRoundAPoleSeeItAndPredict) {
  for (const double lat_deg : {-90.0, -89.9}) {
    Scene scene = NodeScene();
    scene.centre.lat_rad = lat_deg * kRadPerDeg;
    SceneFlight& flight = scene.flights[0];
    flight.inclination_rad = 87.17 * kRadPerDeg;
    flight.argument_of_latitude_rad = 270.0 * kRadPerDeg;
    flight.count = 12;
    flight.node_spacing_rad = 30.0 * kRadPerDeg;
    const SimulatedBlock simulated = Simulate(scene);
    ASSERT_EQ(simulated.block.points.size(), 20U);
    EXPECT_EQ(simulated.block.looks.size(), 20U * 12U);
    AdjustOptions options;
    options.corrections = CorrectionChoice::kNone;
    const AdjustResult result =
        Predict(simulated.block, options, simulated.truth.points_m, {}, nullptr);
    for (std::size_t point = 0; point < 20; ++point) {
      EXPECT_EQ(result.points.status[point], PointStatus::kPredicted);
      // Twelve looks of 1 m along and 0.5 m in range from all sides are better than one of them.
      EXPECT_LT(result.points.covariance_m2[point][2], 0.25);
    }
  }
}

}  // namespace
}  // namespace sarblock
