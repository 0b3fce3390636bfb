// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/intersection.h"

#include <array>
#include <cmath>
#include <limits>

#include "geometry/sight_scene.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing_scene::FixPath;
using testing_scene::Station;
using testing_scene::View;

// Hand values: 12 km above the wanted height, ranges 37 km and 13 km.
TEST(IntersectWithHeightTest, FindsPythagoreanPointsOnEitherSide) {
  const Intersection left =
      IntersectWithHeight(Station(7.5, 0.0, 12250.0, 37e3, +1), Frame::Local(), 250.0);
  ASSERT_EQ(left.outcome, IntersectionOutcome::kDetermined);
  EXPECT_LT((left.position_m - Eigen::Vector3d(7.5, 35e3, 250.0)).norm(), 1e-10);
  const Intersection right =
      IntersectWithHeight(Station(7.5, 0.0, 12250.0, 13e3, -1), Frame::Local(), 250.0);
  ASSERT_EQ(right.outcome, IntersectionOutcome::kDetermined);
  EXPECT_LT((right.position_m - Eigen::Vector3d(7.5, -5e3, 250.0)).norm(), 1e-10);
}

// Closed form with squint: R sin(tau) along, the rest of the range in the plane across.
TEST(IntersectWithHeightTest, PlacesASquintedLook) {
  FixedPathLook observation = Station(0.0, 0.0, 4812.5, 9123.75, +1);
  observation.cone.squint_rad = -0.43;
  const double x = 9123.75 * std::sin(-0.43);
  const double y = std::sqrt(9123.75 * 9123.75 - x * x - 4812.5 * 4812.5);
  const Intersection result = IntersectWithHeight(observation, Frame::Local(), 0.0);
  ASSERT_EQ(result.outcome, IntersectionOutcome::kDetermined);
  EXPECT_LT((result.position_m - Eigen::Vector3d(x, y, 0.0)).norm(), 1e-10);
}

TEST(IntersectWithHeightTest, SaysWhenTheCircleStaysAboveOrBelowTheSurface) {
  const FixedPathLook observation = Station(0.0, 0.0, 5000.25, 3000.5, +1);
  EXPECT_EQ(IntersectWithHeight(observation, Frame::Local(), 0.0).outcome,
            IntersectionOutcome::kCirclesDoNotMeet);
  EXPECT_EQ(IntersectWithHeight(observation, Frame::Local(), 8001.0).outcome,
            IntersectionOutcome::kCirclesDoNotMeet);
  EXPECT_EQ(IntersectWithHeight(observation, Frame::Local(), 1999.8).outcome,
            IntersectionOutcome::kDetermined);
}

// Round trip over bodies, places, sides, squints, climbs and cone kinds: the point a look was
// built from comes back.
TEST(IntersectWithHeightTest, RecoversPointsOnEllipsoids) {
  int found = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    RandomStream random(65, seed);
    const auto between = [&random](double lower, double upper) {
      return lower + (upper - lower) * random.Uniform();
    };
    const Frame frame =
        Frame::Geocentric(NamedEllipsoid(std::array{"WGS84", "Moon", "Venus", "Mars"}[seed % 4]));
    const Geodetic place = {between(-1.5, 1.5), between(-3.1, 3.1), between(-3e3, 5e3)};
    const Eigen::Vector3d p = frame.FrameFromGeodetic(place);
    const bool orbit = seed % 3 != 0;
    View view;
    view.heading_rad = between(-3.1, 3.1);
    view.climb_rad = between(-0.04, 0.04);
    view.squint_rad = between(-0.5, 0.5) * (orbit ? 0.2 : 1.0);
    view.look_rad = between(0.35, 1.0);
    view.side = seed % 2 == 0 ? +1 : -1;
    view.range_m = orbit ? between(3e5, 6e5) : between(6e3, 2e4);
    view.speed_mps = orbit ? 6789.0 : 123.0;
    const FixedPathLook observation = FixPath(p, view, frame.EnuFromFrame(p));
    const Intersection result = IntersectWithHeight(observation, frame, place.h_m);
    ASSERT_EQ(result.outcome, IntersectionOutcome::kDetermined) << seed;
    // Coordinates of 7e6 m hold 1e-9 m; a look angle of 20 degrees triples a height error.
    EXPECT_LT((result.position_m - p).norm(), 2e-8) << seed;
    ++found;
  }
  EXPECT_EQ(found, 300);
}

TEST(IntersectWithHeightTest, SaysWhenAnOrbitDoesNotReachTheEllipsoid) {
  const Frame frame = Frame::Geocentric(NamedEllipsoid("Venus"));
  FixedPathLook observation;
  observation.antenna_m = {6051.8e3 + 375e3, 0.0, 0.0};
  observation.velocity_mps = {0.0, 7101.5, 0.0};
  observation.range_m = 374.9e3;
  EXPECT_EQ(IntersectWithHeight(observation, frame, 0.0).outcome,
            IntersectionOutcome::kCirclesDoNotMeet);
  EXPECT_EQ(IntersectWithHeight(observation, frame, 101.0).outcome,
            IntersectionOutcome::kDetermined);
}

TEST(IntersectWithHeightTest, RefusesAHeightThatIsNotFinite) {
  EXPECT_THROW(static_cast<void>(IntersectWithHeight(Station(0.0, 0.0, 5e3, 7e3, +1),
                                                     Frame::Local(),
                                                     std::numeric_limits<double>::infinity())),
               InputError);
}

}  // namespace
}  // namespace sarblock
