// SPDX-License-Identifier: Apache-2.0
// Seeded statistics of path errors with a full covariance: simulated from a matrix, adjusted with
// it and without its correlations.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <string>
#include <vector>

#include "statistics/scene_statistics.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr double kJointLevel = 0.999;

bool FollowsJointly(const test::SquareSum& sum) {
  return ChiSquareInterval(kJointLevel, sum.degrees).Contains(sum.value);
}

const std::string kJointParameters =
    R"(["position.along.0","position.across.0","position.up.0","position.along.1","position.across.1","position.up.1"])";
const std::string kJointSigmas = "[6.0,5.0,4.0,2.5,3.0,2.0]";
// Constants that follow each other closely, and the drifts with them.
const std::string kJointCorrelations =
    "[[1,0.95,0.9,0.85,0.8,0.75],[0.95,1,0.95,0.8,0.85,0.8],[0.9,0.95,1,0.75,0.8,0.85],"
    "[0.85,0.8,0.75,1,0.9,0.85],[0.8,0.85,0.8,0.9,1,0.9],[0.75,0.8,0.85,0.85,0.9,1]]";

/// A shipped scene whose paths have the errors of the matrix; `believed` are the keys of the prior
/// of its adjustment.
Scene SceneWith(const std::vector<std::string>& believed) {
  std::vector<std::string> set{"control.count=0",  // priors alone hold the block
                               "navigation.constant_sigma_m=[0,0,0]",
                               "navigation.drift_sigma_m=[0,0,0]",
                               "navigation.prior.path.parameters=" + kJointParameters,
                               "navigation.prior.path.sigma=" + kJointSigmas,
                               "navigation.prior.path.correlation=" + kJointCorrelations,
                               "adjust.correction={position={degree=1}}",
                               "adjust.prior.path.parameters=" + kJointParameters};
  set.insert(set.end(), believed.begin(), believed.end());
  return test::ShippedScene("earth-same-side", set);
}

TEST(JointPriorStatisticsTest, NormalisedErrorsFollowChiSquareWithTheCorrelations) {
  const test::SceneStatistics sums =
      test::RunDraws(SceneWith({"adjust.prior.path.sigma=" + kJointSigmas,
                                "adjust.prior.path.correlation=" + kJointCorrelations}),
                     test::DrawsAsked(),
                     9100);
  EXPECT_EQ(sums.unsolved, 0U);
  for (const test::SquareSum& sum : {sums.point, sums.pair, sums.corrections, sums.residuals}) {
    EXPECT_TRUE(FollowsJointly(sum)) << sum.mean() << " of " << sum.degrees;
  }
}

// A mutation kept as a test: the same errors believed independent. Errors of points are twice what
// their covariance says, in squares. Fewer than 40 draws do not show it for certain.
TEST(JointPriorStatisticsTest, WithoutTheCorrelationsTheyDoNot) {
  const test::SceneStatistics sums =
      test::RunDraws(SceneWith({"adjust.prior.path.sigma=" + kJointSigmas}),
                     std::max<std::size_t>(test::DrawsAsked(), 40),
                     9100);
  EXPECT_FALSE(FollowsJointly(sums.point)) << sums.point.mean();
}

}  // namespace
}  // namespace sarblock
