// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/intersection.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/sight_scene.h"
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing_scene::FixPath;
using testing_scene::Station;
using testing_scene::View;

using IntersectionOutcome::kDetermined;

// Hand values: heights 12 km over the datum, ground distances 35 km and 5 km (35-12-37, 5-12-13).
TEST(IntersectTest, FindsAPythagoreanPointFromTheSameSide) {
  const std::array<FixedPathLook, 2> observations = {Station(-317.25, 0.0, 12e3, 37e3, +1),
                                                     Station(-317.25, 30e3, 12e3, 13e3, +1)};
  const Intersection result = Intersect(observations, Frame::Local());
  ASSERT_EQ(result.outcome, kDetermined);
  // The range in the last place is 7e-12 m; the geometry (B/H = 2.5) keeps it.
  EXPECT_LT((result.position_m - Eigen::Vector3d(-317.25, 35e3, 0.0)).norm(), 1e-10);
  EXPECT_LT(result.weighted_square_sum, 1e-18);
  // tan(theta') = 35/12, tan(theta'') = 5/12: tan of the difference is 360/319.
  EXPECT_NEAR(result.intersection_rad, std::atan2(360.0, 319.0), 1e-14);
}

TEST(IntersectTest, HasNoCovarianceWhereNoneIsAskedFor) {
  const std::array<FixedPathLook, 2> observations = {Station(-317.25, 0.0, 12e3, 37e3, +1),
                                                     Station(-317.25, 30e3, 12e3, 13e3, +1)};
  IntersectionOptions options;
  const Intersection whole = Intersect(observations, Frame::Local(), options);
  options.with_covariance = false;
  const Intersection place = Intersect(observations, Frame::Local(), options);
  EXPECT_EQ(place.outcome, kDetermined);
  EXPECT_EQ(place.position_m, whole.position_m);
  EXPECT_GT(whole.covariance_m2.trace(), 0.0);
  EXPECT_TRUE(std::isnan(place.covariance_m2.trace()));
  EXPECT_TRUE(std::isnan(place.intersection_rad));
}

// Opposite side: 35-12-37 and 9-12-15, the second antenna looks to the right.
TEST(IntersectTest, FindsAPythagoreanPointFromOppositeSides) {
  const std::array<FixedPathLook, 2> observations = {Station(55.5, 0.0, 12e3, 37e3, +1),
                                                     Station(55.5, 44e3, 12e3, 15e3, -1)};
  const Intersection result = Intersect(observations, Frame::Local());
  ASSERT_EQ(result.outcome, kDetermined);
  EXPECT_LT((result.position_m - Eigen::Vector3d(55.5, 35e3, 0.0)).norm(), 1e-10);
  // tan(theta') = 35/12, tan(theta'') = -9/12: the sum of both look angles.
  EXPECT_NEAR(result.intersection_rad, std::atan2(35.0, 12.0) + std::atan2(9.0, 12.0), 1e-14);
}

// A cross-wise flight: the second antenna flies along +y, 9 km west of the point at 12 km height,
// and looks to the right (+x). Its plane alone fixes y.
TEST(IntersectTest, FindsAPythagoreanPointFromCrossingTracks) {
  FixedPathLook crossing = Station(-8.0e3, 35e3, 12e3, 15e3, -1);
  crossing.velocity_mps = {0.0, 181.0, 0.0};
  const std::array<FixedPathLook, 2> observations = {Station(1e3, 0.0, 12e3, 37e3, +1), crossing};
  const Intersection result = Intersect(observations, Frame::Local());
  ASSERT_EQ(result.outcome, kDetermined);
  EXPECT_LT((result.position_m - Eigen::Vector3d(1e3, 35e3, 0.0)).norm(), 1e-10);
}

// Leberl (1979), Eq. 25, is the exact covariance of the paper's pair at z = 0; the flight direction
// separates: two azimuths of sigma_a average.
TEST(IntersectTest, CovarianceIsEquation25InThePaperGeometry) {
  struct Configuration {
    double base_m, height_m, near_m, far_m, sigma_m;
  };
  for (const Configuration& c : {Configuration{8e3, 10e3, 13e3, 25e3, 7.3},
                                 Configuration{40e3, 375e3, 365e3, 425e3, 100.0}}) {
    for (int i = 0; i <= 6; ++i) {
      const double y = c.near_m + (c.far_m - c.near_m) * i / 6.0;
      const double b = c.base_m, h = c.height_m;
      const double r1 = std::hypot(h, y), r2 = std::hypot(h, y - b);
      std::array<FixedPathLook, 2> observations = {Station(0.0, 0.0, h, r1, +1),
                                                   Station(0.0, b, h, r2, +1)};
      for (FixedPathLook& observation : observations) {
        observation.range_sigma_m = c.sigma_m;
        observation.azimuth_sigma = 3.9;
      }
      const Intersection result = Intersect(observations, Frame::Local());
      ASSERT_EQ(result.outcome, kDetermined) << y;
      const double sigma_y_m = c.sigma_m * std::hypot(r1, r2) / b;
      const double sigma_z_m = c.sigma_m * std::hypot(r1 * (y - b), r2 * y) / (b * h);
      EXPECT_NEAR(std::sqrt(result.covariance_m2(0, 0)), 3.9 / std::numbers::sqrt2, 1e-11);
      EXPECT_NEAR(std::sqrt(result.covariance_m2(1, 1)), sigma_y_m, 1e-9 * sigma_y_m) << y;
      EXPECT_NEAR(std::sqrt(result.covariance_m2(2, 2)), sigma_z_m, 1e-9 * sigma_z_m) << y;
      EXPECT_NEAR(result.covariance_m2(0, 2), 0.0, 1e-9 * sigma_z_m);
    }
  }
}

// Random geometries without noise: the point the looks were built from comes back. Same and
// opposite side, squints to 60 degrees, crossing tracks, climbing flight, both cone kinds.
TEST(IntersectTest, RecoversThePointOfRandomGeometries) {
  int determined = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    RandomStream random(417, seed);
    const auto between = [&random](double lower, double upper) {
      return lower + (upper - lower) * random.Uniform();
    };
    const Eigen::Vector3d p(between(-5e3, 5e3), between(-5e3, 5e3), between(-400.0, 3e3));
    const bool crossing = seed % 4 == 3;
    const bool opposite = seed % 2 == 1;
    const double height_m = between(4e3, 11e3);
    const double first_look_rad = between(0.35, 1.15);
    std::array<FixedPathLook, 2> observations;
    for (std::size_t k = 0; k < 2; ++k) {
      View view;
      view.heading_rad = k == 1 && crossing ? between(-3.0, 3.0) : 0.7;
      view.climb_rad = crossing ? between(-0.05, 0.05) : 0.0;
      view.look_rad = k == 0
                          ? first_look_rad
                          : (opposite ? between(0.35, 1.15) : first_look_rad - between(0.02, 0.3));
      view.side = k == 1 && opposite ? -1 : +1;
      view.squint_rad = between(-1.0, 1.0) * std::numbers::pi / 3.0;
      // Near-equal heights (a base tilted by 3 degrees at most): the mirror point of parallel
      // tracks then lies above the antennas.
      view.range_m = height_m * between(0.9995, 1.0005) /
                     (std::cos(view.look_rad) * std::cos(view.squint_rad));
      observations[k] = FixPath(p, view);
      observations[k].range_sigma_m = 0.31;
      observations[k].azimuth_sigma = 0.22;
      if (seed % 5 == 0) {
        observations[k].cone.kind = Cone::Kind::kDoppler;
        observations[k].cone.closing_mps =
            observations[k].velocity_mps.dot(p - observations[k].antenna_m) /
            observations[k].range_m;
      }
    }
    const Intersection result = Intersect(observations, Frame::Local());
    ASSERT_EQ(result.outcome, kDetermined) << seed << ": " << NameOf(result.outcome);
    const double angle_rad = IntersectionAngle(p, observations[0], observations[1]);
    // Rounding of the range (4e-12 m) over the angle of intersection, with room for the chain.
    const double tolerance_m = crossing ? 1e-6 : 1e-9 + 1e-14 * observations[0].range_m / angle_rad;
    EXPECT_LT((result.position_m - p).norm(), tolerance_m) << seed;
    ++determined;
  }
  EXPECT_EQ(determined, 2000);
}

// A pair of orbits, 850 km range, right-looking, repeat-pass stereo with converging tracks and
// squint, a dozen places on the Earth: round trip through the geometry.
TEST(IntersectTest, RecoversAPointFromOrbit) {
  const Frame frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    RandomStream random(1978, seed);
    const Geodetic place = {2.6 * (random.Uniform() - 0.5), 6.2 * (random.Uniform() - 0.5), 417.3};
    const Eigen::Vector3d p = frame.FrameFromGeodetic(place);
    const Eigen::Matrix3d enu = frame.EnuFromFrame(p);
    View steep, flat;
    steep.heading_rad = 1.77;
    steep.look_rad = 0.41;
    steep.squint_rad = 0.021;
    steep.range_m = 851234.5;
    steep.speed_mps = 7543.2;
    steep.side = -1;
    flat = steep;
    flat.heading_rad = 1.71;
    flat.look_rad = 0.77;
    flat.squint_rad = -0.013;
    flat.range_m = 1034567.8;
    const std::array<FixedPathLook, 2> observations = {FixPath(p, steep, enu),
                                                       FixPath(p, flat, enu)};
    const Intersection result = Intersect(observations, frame);
    ASSERT_EQ(result.outcome, kDetermined) << seed;
    // Coordinates of 7e6 m are known to 1e-9 m; the intersection of 20 degrees triples that.
    EXPECT_LT((result.position_m - p).norm(), 2e-8) << seed;
  }
}

// A base of a hundred-thousandth of the height with ranges good to a tenth of a millimetre.
TEST(IntersectTest, KeepsAPointOfATinyBase) {
  const double h = 9871.3, y = 13417.9, b = 1e-5 * h;
  std::array<FixedPathLook, 2> observations = {Station(0.0, 0.0, h, std::hypot(h, y), +1),
                                               Station(0.0, b, h, std::hypot(h, y - b), +1)};
  for (FixedPathLook& observation : observations) {
    observation.range_sigma_m = 1e-4;
    observation.azimuth_sigma = 1e-3;
  }
  const Intersection result = Intersect(observations, Frame::Local());
  ASSERT_EQ(result.outcome, kDetermined);
  // Ranges rounded to 2e-12 m over an angle of 4e-6: 1e-6 m.
  EXPECT_LT((result.position_m - Eigen::Vector3d(0.0, y, 0.0)).norm(), 5e-6);
  const double sigma_z_m =
      1e-4 * std::hypot(std::hypot(h, y) * (y - b), std::hypot(h, y - b) * y) / (b * h);
  EXPECT_NEAR(std::sqrt(result.covariance_m2(2, 2)), sigma_z_m, 1e-6 * sigma_z_m);
}

std::vector<FixedPathLook> Fan(const Eigen::Vector3d& p, int looks) {
  std::vector<FixedPathLook> observations;
  for (int k = 0; k < looks; ++k) {
    View view;
    view.heading_rad = 0.01 * k;
    view.look_rad = 0.5 + 0.4 * k / looks;
    view.squint_rad = 0.003 * (k % 7);
    view.range_m = 9137.0 / std::cos(view.look_rad);
    observations.push_back(FixPath(p, view));
    observations.back().range_sigma_m = 0.9 + 0.1 * (k % 3);
  }
  return observations;
}

// More looks than the pair search and the stack hold: the information only grows, and the order of
// the looks does not matter.
TEST(IntersectTest, UsesAnyNumberOfLooks) {
  const Eigen::Vector3d p(812.5, -273.75, 91.0);
  double last_trace_m2 = 1e30;
  for (const int looks : {2, 3, 8, 9, 16, 17, 64, 65, 200}) {
    std::vector<FixedPathLook> observations = Fan(p, looks);
    const Intersection result = Intersect(observations, Frame::Local());
    ASSERT_EQ(result.outcome, kDetermined) << looks;
    EXPECT_LT((result.position_m - p).norm(), 1e-9) << looks;
    std::reverse(observations.begin(), observations.end());
    const Intersection reversed = Intersect(observations, Frame::Local());
    EXPECT_LT((reversed.covariance_m2 - result.covariance_m2).norm(),
              1e-10 * result.covariance_m2.norm());
    EXPECT_NEAR(reversed.intersection_rad, result.intersection_rad, 1e-12) << looks;
    if (looks >= 8) {
      EXPECT_LT(result.covariance_m2.trace(), last_trace_m2) << looks;
    }
    last_trace_m2 = result.covariance_m2.trace();
  }
}

// The outcome does not depend on where the frame's origin is: shift by 10 000 km.
TEST(IntersectTest, IsInvariantUnderAShift) {
  const Eigen::Vector3d p(812.5, -273.75, 91.0);
  const Eigen::Vector3d shift(8388608.0, -4194304.0, 524288.0);  // powers of two: exact sums
  std::vector<FixedPathLook> observations = Fan(p, 5);
  for (FixedPathLook& observation : observations) {
    observation.antenna_m = (observation.antenna_m * 1024.0).array().round().matrix() / 1024.0;
  }
  const Intersection here = Intersect(observations, Frame::Local());
  for (FixedPathLook& observation : observations) {
    observation.antenna_m += shift;
  }
  const Intersection there = Intersect(observations, Frame::Local());
  EXPECT_LT((there.position_m - shift - here.position_m).norm(), 4e-9);  // 2 units of 1e7 m
  EXPECT_EQ(there.covariance_m2, here.covariance_m2);
}

// Second route: the covariance at the solution by dense matrices, weights of that place. The looks
// contradict by decametres, so that weights of the start would differ by 1e-3.
TEST(IntersectTest, CovarianceHasTheWeightsOfTheSolution) {
  View near, far;
  near.squint_rad = 0.6;
  far.look_rad = 0.9;
  far.squint_rad = -0.5;
  const Eigen::Vector3d p(812.5, -273.75, 91.0);
  std::array<FixedPathLook, 2> observations = {FixPath(p, near), FixPath(p, far)};
  for (FixedPathLook& observation : observations) {
    observation.range_sigma_m = 37.0;
    observation.azimuth_in_seconds = true;
    observation.azimuth_sigma = 0.31;
  }
  observations[0].antenna_m[0] += 91.25;
  observations[1].range_m += 48.5;
  const Intersection result = Intersect(observations, Frame::Local());
  ASSERT_EQ(result.outcome, kDetermined);
  Eigen::Matrix<double, 4, 3> jacobian;
  Eigen::Vector4d errors;
  for (Eigen::Index k = 0; k < 2; ++k) {
    const FixedPathLook& observation = observations[static_cast<std::size_t>(k)];
    LookEquations look;
    ASSERT_TRUE(EvaluateLookEquations(result.position_m,
                                      observation.antenna_m,
                                      observation.velocity_mps,
                                      observation.cone,
                                      0.0,
                                      &look));
    const Whitening w = WhitenTime(observation.range_sigma_m,
                                   observation.azimuth_sigma,
                                   LookTimeRates(result.position_m,
                                                 observation.antenna_m,
                                                 observation.velocity_mps,
                                                 observation.acceleration_mps2,
                                                 observation.cone));
    jacobian.row(2 * k) = w.w00 * look.drho_dp;
    jacobian.row(2 * k + 1) = w.w10 * look.drho_dp + w.w11 * look.ded_dp;
    errors.segment<2>(2 * k) = w.Apply(look.rho_m - observation.range_m, look.doppler_error_m);
  }
  const Eigen::Matrix3d covariance_m2 = (jacobian.transpose() * jacobian).inverse();
  // The last step may move the point by parts of a metre after the weights were formed: 1e-4.
  EXPECT_LT((result.covariance_m2 - covariance_m2).norm(), 1e-4 * covariance_m2.norm());
  EXPECT_NEAR(result.weighted_square_sum, errors.squaredNorm(), 1e-4 * errors.squaredNorm());
  EXPECT_GT(errors.squaredNorm(), 0.5);
}

}  // namespace
}  // namespace sarblock
