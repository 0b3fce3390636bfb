// SPDX-License-Identifier: Apache-2.0
// Seeded statistics of path errors that last: simulated as a process of spline coefficients,
// adjusted with its prior and with one of independent coefficients.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <string>
#include <vector>

#include "statistics/scene_statistics.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

bool FollowsProcess(const test::SquareSum& sum) {
  return ChiSquareInterval(0.999, sum.degrees).Contains(sum.value);
}

/// Twelve strips held by four corners, knots 60 s apart. `process` are the further keys of the
/// process, as the scene and the correction name them.
Scene StripsWith(const std::string& process, const std::vector<std::string>& of_scene, bool white) {
  const std::string sigma_m = "[20, 20, 15]";
  std::vector<std::string> set{
      "points.count=150",
      "check.count=0",
      "control.layout=corners",
      "control.count=4",
      "navigation={process_sigma_m=" + sigma_m + ", knot_spacing_s=60}",
      "adjust.correction={position={basis='spline', knot_spacing_s=60, sigma_m=" + sigma_m +
          (white ? "" : ", " + process) + "}}"};
  set.insert(set.end(), of_scene.begin(), of_scene.end());
  return test::ShippedScene("block-12-strips", set);
}

const std::vector<std::string> kMarkovScene{"navigation.process=gauss-markov",
                                            "navigation.correlation_time_s=300"};
const std::string kMarkov = "process='gauss-markov', correlation_time_s=300";

TEST(ProcessPriorStatisticsTest, NormalisedErrorsFollowChiSquareWithTheProcess) {
  const std::vector<std::string> walk_scene{"navigation.process=random-walk",
                                            "navigation.constant_sigma_m=[5, 4, 3]"};
  for (const Scene& scene :
       {StripsWith(kMarkov, kMarkovScene, false),
        StripsWith("process='random-walk', start_sigma_m=[5, 4, 3]", walk_scene, false)}) {
    const test::SceneStatistics sums = test::RunDraws(scene, test::DrawsAsked(), 9300);
    EXPECT_EQ(sums.unsolved, 0U);
    std::printf("points %.3f pairs %.3f corrections %.3f residuals %.3f\n",
                sums.point.mean(),
                sums.pair.mean(),
                sums.corrections.mean(),
                sums.residuals.mean());
    for (const test::SquareSum& sum : {sums.point, sums.pair, sums.corrections, sums.residuals}) {
      EXPECT_TRUE(FollowsProcess(sum)) << sum.mean() << " of " << sum.degrees;
    }
  }
}

// A mutation kept as a test: the same errors believed to be forgotten from knot to knot.
TEST(ProcessPriorStatisticsTest, WithIndependentCoefficientsTheyDoNot) {
  const test::SceneStatistics sums = test::RunDraws(
      StripsWith(kMarkov, kMarkovScene, true), std::max<std::size_t>(test::DrawsAsked(), 20), 9300);
  std::printf("points %.3f\n", sums.point.mean());
  EXPECT_FALSE(FollowsProcess(sums.point)) << sums.point.mean();
}

}  // namespace
}  // namespace sarblock
