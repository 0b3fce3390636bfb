// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/intersection.h"

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "geometry/sight_scene.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing_scene::FixPath;
using testing_scene::Station;
using testing_scene::View;
using enum IntersectionOutcome;

IntersectionOutcome OutcomeOf(const std::vector<FixedPathLook>& observations) {
  return Intersect(observations, Frame::Local()).outcome;
}

TEST(IntersectionOutcomeTest, OneLookIsTooFew) {
  EXPECT_EQ(OutcomeOf({}), kTooFewLooks);
  EXPECT_EQ(OutcomeOf({Station(0.0, 0.0, 12e3, 37e3, +1)}), kTooFewLooks);
}

// Opposite-side antennas 44 km apart, ranges that sum to 40 km: 4 km short, sigma 1 m.
TEST(IntersectionOutcomeTest, RangesShorterThanTheBaseDoNotMeet) {
  const std::vector<FixedPathLook> observations = {Station(0.0, 0.0, 12e3, 21e3, +1),
                                                   Station(0.0, 44e3, 12e3, 19e3, -1)};
  const Intersection result = Intersect(observations, Frame::Local());
  EXPECT_EQ(result.outcome, kCirclesDoNotMeet);
  // The least-squares point shares the gap: 2 km for each of two ranges of sigma 1 m.
  EXPECT_NEAR(result.weighted_square_sum, 2.0 * 2e3 * 2e3, 1.0);
  EXPECT_NEAR(result.position_m[1], 23e3, 1e-3);
}

// One range sphere inside the other: 37 - 20 km is more than the base of 5 km.
TEST(IntersectionOutcomeTest, NestedCirclesDoNotMeet) {
  EXPECT_EQ(OutcomeOf({Station(0.0, 0.0, 12e3, 37e3, +1), Station(0.0, 5e3, 12e3, 20e3, +1)}),
            kCirclesDoNotMeet);
}

// Closed form: two planes 30 m apart share 15 m each; with sigma_a in metres v'Pv = 2 (15/sigma)^2.
// The chi-square quantile at 1 - 1e-6 with one degree of freedom is 23.93.
TEST(IntersectionOutcomeTest, PlanesApartAreWeighedAgainstTheirStandardDeviation) {
  std::vector<FixedPathLook> observations = {Station(0.0, 0.0, 12e3, 37e3, +1),
                                             Station(30.0, 30e3, 12e3, 13e3, +1)};
  for (FixedPathLook& observation : observations) {
    observation.azimuth_sigma = 4.3;  // 24.34
  }
  Intersection result = Intersect(observations, Frame::Local());
  EXPECT_EQ(result.outcome, kCirclesDoNotMeet);
  EXPECT_NEAR(result.weighted_square_sum, 450.0 / (4.3 * 4.3), 1e-9);
  EXPECT_NEAR(result.position_m[0], 15.0, 1e-9);  // still the best point there is
  for (FixedPathLook& observation : observations) {
    observation.azimuth_sigma = 4.4;  // 23.24
  }
  result = Intersect(observations, Frame::Local());
  EXPECT_EQ(result.outcome, kDetermined);
  EXPECT_NEAR(result.weighted_square_sum, 450.0 / (4.4 * 4.4), 1e-9);
}

// Tangent spheres: antennas 30 km apart, the point in line with both (3-4-5 direction), exactly
// touching and with ranges off by one standard deviation either way.
TEST(IntersectionOutcomeTest, CirclesInLineWithTheBaseTouch) {
  for (const double error_m : {0.0, 1.0, -1.0}) {
    const Intersection result =
        Intersect(std::vector<FixedPathLook>{Station(0.0, 0.0, 28e3, 35e3 + error_m, +1),
                                             Station(0.0, 12e3, 12e3, 15e3, +1)},
                  Frame::Local());
    EXPECT_EQ(result.outcome, kCirclesTouch) << error_m << ": " << NameOf(result.outcome);
    EXPECT_EQ(result.covariance_m2.norm(), 0.0);
    // Along the base the point is known to the ranges' sigma; across it to sqrt(2 R sigma).
    EXPECT_LT((result.position_m - Eigen::Vector3d(0.0, 21e3, 0.0)).norm(), 400.0);
  }
}

// Fore and aft squint from one straight line (Leberl's Fig. 5): the same circle twice.
TEST(IntersectionOutcomeTest, SingleFlightSquintedStereoCoincides) {
  const Eigen::Vector3d p(1234.5, 8765.25, 210.75);
  View fore, aft;
  fore.look_rad = aft.look_rad = 0.83;
  fore.squint_rad = 0.35;
  aft.squint_rad = -0.35;
  fore.range_m = aft.range_m = 12345.5;
  EXPECT_EQ(OutcomeOf({FixPath(p, fore), FixPath(p, aft)}), kCirclesCoincide);
  aft.squint_rad = -0.11;
  aft.range_m = 12345.5 * std::cos(0.35) / std::cos(-0.11);
  EXPECT_EQ(OutcomeOf({FixPath(p, fore), FixPath(p, aft)}), kCirclesCoincide);
  View middle = fore;
  middle.squint_rad = 0.0;
  middle.range_m = 12345.5 * std::cos(0.35);
  EXPECT_EQ(OutcomeOf({FixPath(p, fore), FixPath(p, aft), FixPath(p, middle)}), kCirclesCoincide);
}

// The same with noise, seeded: of 400 draws none may be taken for a determined point. A radius
// difference alone never meets; a decision at 5 sigma errs once in 1e6.
TEST(IntersectionOutcomeTest, NoisySingleFlightStereoCoincides) {
  const Eigen::Vector3d p(1234.5, 8765.25, 210.75);
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    RandomStream random(5, seed);
    std::vector<FixedPathLook> observations;
    for (const double squint_rad : {0.37, -0.29}) {
      View view;
      view.look_rad = 0.83;
      view.squint_rad = squint_rad;
      view.range_m = 11e3 / std::cos(squint_rad);
      FixedPathLook observation = FixPath(p, view);
      observation.range_sigma_m = 2.3;
      observation.azimuth_sigma = 1.7;
      observation.range_m += 2.3 * random.Normal();
      observation.antenna_m += 1.7 * random.Normal() * observation.velocity_mps.normalized();
      // Small errors of the path, well within the looks' noise.
      observation.antenna_m += Eigen::Vector3d(0.0, 0.1 * random.Normal(), 0.1 * random.Normal());
      observations.push_back(observation);
    }
    ASSERT_EQ(OutcomeOf(observations), kCirclesCoincide) << seed;
  }
}

TEST(IntersectionOutcomeTest, TheSameLookTwiceCoincides) {
  const FixedPathLook observation = Station(17.25, 0.0, 12e3, 37e3, +1);
  EXPECT_EQ(OutcomeOf({observation, observation}), kCirclesCoincide);
}

// Parallel single-flight circles of radii 500 m apart never meet.
TEST(IntersectionOutcomeTest, ConcentricCirclesOfDifferentRadiusDoNotMeet) {
  EXPECT_EQ(OutcomeOf({Station(0.0, 0.0, 12e3, 37e3, +1), Station(0.0, 0.0, 12e3, 36.5e3, +1)}),
            kCirclesDoNotMeet);
}

TEST(IntersectionOutcomeTest, APointOnTheOtherSideIsNamed) {
  EXPECT_EQ(OutcomeOf({Station(0.0, 0.0, 12e3, 37e3, -1), Station(0.0, 30e3, 12e3, 13e3, -1)}),
            kWrongSide);
  EXPECT_EQ(OutcomeOf({Station(0.0, 0.0, 12e3, 37e3, +1), Station(0.0, 30e3, 12e3, 13e3, -1)}),
            kWrongSide);
}

// A base falling 45 degrees towards the point, which lies 30 degrees off nadir: the mirror point at
// 60 degrees is as good. A third look from elsewhere decides.
TEST(IntersectionOutcomeTest, AMirrorPointOnTheSameSideIsAmbiguousUntilAThirdLookDecides) {
  const Eigen::Vector3d p(431.25, 0.0, 0.0);
  View high;
  high.look_rad = 0.524;
  high.range_m = 14321.75;
  std::vector<FixedPathLook> observations = {FixPath(p, high)};
  FixedPathLook low = observations[0];
  low.antenna_m += Eigen::Vector3d(0.0, 3e3, -3e3);
  low.range_m = (p - low.antenna_m).norm();
  observations.push_back(low);
  EXPECT_EQ(OutcomeOf(observations), kAmbiguous);
  FixedPathLook third = observations[0];
  third.antenna_m += Eigen::Vector3d(0.0, -2e3, 0.0);
  third.range_m = (p - third.antenna_m).norm();
  observations.push_back(third);
  const Intersection result = Intersect(observations, Frame::Local());
  ASSERT_EQ(result.outcome, kDetermined);
  EXPECT_LT((result.position_m - p).norm(), 1e-9);
}

// Vertical base: the mirror point is the same place on the other side; the look side decides.
TEST(IntersectionOutcomeTest, AVerticalBaseIsDecidedByTheLookSide) {
  for (const int side : {+1, -1}) {
    const Intersection result =
        Intersect(std::vector<FixedPathLook>{Station(0.0, 0.0, 12e3, 15e3, side),
                                             Station(0.0, 0.0, 40e3, 41e3, side)},
                  Frame::Local());
    ASSERT_EQ(result.outcome, kDetermined);
    EXPECT_LT((result.position_m - Eigen::Vector3d(0.0, 9e3 * side, 0.0)).norm(), 1e-9);
  }
}

TEST(IntersectionOutcomeTest, RunsOutOfIterations) {
  const Eigen::Vector3d p(431.25, 7.5, 0.0);
  View first, second;
  first.look_rad = 0.9;
  second.look_rad = 0.4;
  second.heading_rad = 0.3;
  std::vector<FixedPathLook> observations = {FixPath(p, first), FixPath(p, second)};
  observations[1].range_m += 0.75;
  observations[1].antenna_m[0] += 1.25;
  IntersectionOptions options;
  options.max_iterations = 1;
  EXPECT_EQ(Intersect(observations, Frame::Local(), options).outcome, kNotConverged);
  EXPECT_EQ(Intersect(observations, Frame::Local()).outcome, kDetermined);
}

// The option decides what counts as singular: a base of 1/8 has a reciprocal condition of about
// 0.1.
TEST(IntersectionOutcomeTest, TheConditionLimitIsTheCallersChoice) {
  const std::vector<FixedPathLook> observations = {
      Station(0.0, 0.0, 12e3, std::hypot(12e3, 9e3), +1),
      Station(0.0, 1.5e3, 12e3, std::hypot(12e3, 7.5e3), +1)};
  IntersectionOptions strict;
  strict.min_reciprocal_condition = 0.5;
  EXPECT_EQ(Intersect(observations, Frame::Local(), strict).outcome, kCirclesTouch);
  EXPECT_EQ(Intersect(observations, Frame::Local()).outcome, kDetermined);
}

TEST(IntersectionOutcomeTest, RefusesNonsenseByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  struct Case {
    const char* field;
    std::function<void(FixedPathLook*)> spoil;
  };
  const std::vector<Case> cases = {
      {"antenna_m", [nan](FixedPathLook* s) { s->antenna_m[1] = nan; }},
      {"velocity_mps", [](FixedPathLook* s) { s->velocity_mps.setZero(); }},
      {"acceleration_mps2", [nan](FixedPathLook* s) { s->acceleration_mps2[2] = nan; }},
      {"range_m", [](FixedPathLook* s) { s->range_m = -12.0; }},
      {"range_sigma_m", [](FixedPathLook* s) { s->range_sigma_m = 0.0; }},
      {"azimuth_sigma", [nan](FixedPathLook* s) { s->azimuth_sigma = nan; }},
      {"side", [](FixedPathLook* s) { s->side = 0; }},
      {"squint_rad", [](FixedPathLook* s) { s->cone.squint_rad = 1.6; }},
      {"closing_mps",
       [](FixedPathLook* s) {
         s->cone = {Cone::Kind::kDoppler, 0.0, 181.5};
       }},
  };
  for (const Case& spoiled : cases) {
    std::vector<FixedPathLook> observations = {Station(0.0, 0.0, 12e3, 37e3, +1),
                                               Station(0.0, 30e3, 12e3, 13e3, +1)};
    spoiled.spoil(&observations[1]);
    try {
      static_cast<void>(Intersect(observations, Frame::Local()));
      ADD_FAILURE() << spoiled.field << " was accepted";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(spoiled.field), std::string::npos) << error.what();
    }
  }
}

TEST(IntersectionOutcomeTest, EveryOutcomeHasItsOwnNameAndSentence) {
  std::set<std::string> names, sentences;
  for (const auto outcome : {kDetermined,
                             kTooFewLooks,
                             kCirclesDoNotMeet,
                             kCirclesTouch,
                             kCirclesCoincide,
                             kWrongSide,
                             kAmbiguous,
                             kNotConverged}) {
    names.insert(NameOf(outcome));
    const std::string sentence = Explain(outcome);
    ASSERT_FALSE(sentence.empty());
    EXPECT_NE(sentence.back(), '.');  // messages go on after it
    sentences.insert(sentence);
  }
  EXPECT_EQ(names.size(), 8u);
  EXPECT_EQ(sentences.size(), 8u);
  EXPECT_STREQ(NameOf(kCirclesCoincide), "circles-coincide");
}

}  // namespace
}  // namespace sarblock
