// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include "leberl/rigorous.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

// Closed form (the derivation stands in the header): rank 2 for every forward/backward pair.
TEST(SingleFlightTest, CirclesCoincideForEveryForwardAndBackwardPair) {
  RandomStream random(20240611, 7);
  for (int i = 0; i < 2000; ++i) {
    const double height_m = 1e3 + 4e5 * random.Uniform();
    const double side = random.Uniform() < 0.5 ? -1.0 : 1.0;
    const SingleFlightPair pair{
        .height_m = height_m,
        .ground_range_m = side * height_m * (0.2 + 3.0 * random.Uniform()),
        .first_squint_rad = (2.0 + 58.0 * random.Uniform()) * kRadPerDeg,
        .second_squint_rad = -(2.0 + 58.0 * random.Uniform()) * kRadPerDeg,
    };
    const SingleFlightProof proof = ProveSingleFlight(pair);
    ASSERT_EQ(proof.rank, 2) << proof.singular[2];
    ASSERT_LE(proof.plane_gap_m, 1e-8);  // rounding of ranges up to 3e6 m
    ASSERT_LE(proof.radius_gap_m, 1e-8);
    ASSERT_EQ(proof.outcome, IntersectionOutcome::kCirclesCoincide) << NameOf(proof.outcome);
  }
}

TEST(SingleFlightTest, SaysWhyThereIsNoStereo) {  // 3-4-5: radius 5 km
  const SingleFlightProof proof = ProveSingleFlight(
      {.height_m = 3e3, .ground_range_m = 4e3, .first_squint_rad = 0.3, .second_squint_rad = -0.2});
  EXPECT_NE(proof.reason.find("same circle of radius 5000 m"), std::string::npos) << proof.reason;
  EXPECT_GT(proof.singular[1], 0.1);  // both looks differ: it is not one look twice
}

TEST(SingleFlightTest, RefusesWhatIsNoPair) {
  EXPECT_THROW((void)ProveSingleFlight({0.0, 4e3, 0.3, -0.2}), InputError);
  EXPECT_THROW((void)ProveSingleFlight({3e3, 0.0, 0.3, -0.2}), InputError);
  EXPECT_THROW((void)ProveSingleFlight({3e3, 4e3, 0.3, 0.3}), InputError);
  EXPECT_THROW((void)ProveSingleFlight({3e3, 4e3, 1.6, 0.3}), InputError);
}

}  // namespace
}  // namespace sarblock
