// SPDX-License-Identifier: Apache-2.0
// The basin of the adjustment (docs/validation.md), a few draws of each scene: paths off by
// kilometres, one look in twenty or ten wrong, every way of asking. Most come home, and none is
// accepted with a point wrong that nobody touched.
#include "statistics/basin.h"

#include <algorithm>

#include "statistics/scene_statistics.h"
#include "support/scene_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

class BasinTest : public testing::TestWithParam<const char*> {};

TEST_P(BasinTest, HoldsPathErrorsOfKilometresAndGrossErrors) {
  test::BasinScene scene(GetParam(), 120);
  const std::size_t draws = std::min<std::size_t>(test::DrawsAsked(), 20);
  std::size_t recovered = 0, tried = 0;
  for (const test::BasinCell& cell : {test::BasinCell{0.0, 0.05, test::GrossError::kMatch},
                                      test::BasinCell{2000.0, 0.05, test::GrossError::kAzimuth},
                                      test::BasinCell{5000.0, 0.10, test::GrossError::kMatch}}) {
    for (std::size_t draw = 0; draw < draws; ++draw) {
      const test::BasinWay& way = test::BasinWays()[draw % test::BasinWays().size()];
      const test::BasinOutcome outcome = scene.Run(cell, way, 700 + draw);
      EXPECT_FALSE(outcome.wrong) << way.name << " " << draw << " " << outcome.worst_sigma;
      EXPECT_FALSE(outcome.mirror) << way.name << " " << draw;
      ++tried;
      recovered += outcome.recovered ? 1U : 0U;
    }
  }
  // One in fifty is allowed to fail: three in 60 are beyond 99.9 percent then.
  EXPECT_GE(recovered + 1 + tried / 12, tried);
}

// A path off by three times its height fits with half of its control points let go as well as with
// all of them: accepted without them, a point stood 53 standard deviations off.
TEST(ControlOfConsensusTest, DecidesForThePathThatItBelongsTo) {
  test::BasinScene scene("leberl-aircraft", 150);
  const test::BasinCell cell{20000.0, 0.05, test::GrossError::kAzimuth};
  const test::BasinOutcome outcome = scene.Run(cell, test::BasinWays().front(), 2003);
  EXPECT_TRUE(outcome.accepted) << outcome.words;
  EXPECT_LT(outcome.worst_sigma, 6.0);
}

// Tukey's loss let go of all four control looks of one of two passes, 1.8 km off: every tie point
// fitted the path that its prior alone held, and stood up to 77 standard deviations off, accepted.
TEST(ControlOfConsensusTest, HoldsEveryPassUnderALoss) {
  const test::BasinCell cell{1000.0, 0.05, test::GrossError::kMatch};
  const auto tukey = test::BasinWays()[3];
  test::BasinScene scene("leberl-voir", 150);
  const test::BasinOutcome outcome = scene.Run(cell, tukey, 3018);
  EXPECT_TRUE(outcome.recovered) << outcome.words;
  EXPECT_LT(outcome.worst_sigma, 6.0);
  scene.LeaveConsensusAway();
  const test::BasinOutcome alone = scene.Run(cell, tukey, 3018);
  EXPECT_FALSE(alone.wrong) << alone.worst_sigma;
  EXPECT_TRUE(alone.recovered || !alone.accepted) << alone.words;
}

// Three neighbouring strips settled 100 m off: of the points with three looks and more that S7
// sees, 11 of 21 were left out as contradictions, and those with two looks met all the same.
// Accepted, points that nobody touched stood up to 73 standard deviations off.
TEST(ConsensusTest, IsNoneWhereHalfOfThePointsThatDecideAreLeftOut) {
  test::BasinScene scene("block-12-strips", 150);
  const test::BasinCell cell{1000.0, 0.10, test::GrossError::kRange};
  const test::BasinOutcome outcome = scene.Run(cell, test::BasinWays().front(), 5079);
  EXPECT_FALSE(outcome.wrong) << outcome.worst_sigma;
  EXPECT_FALSE(outcome.accepted && !outcome.recovered) << outcome.words;
}

// Under a loss a pass stood off its place and lost good looks, a third to half of those that decide
// about it, while gross errors took a tenth of the others': accepted, points that nobody touched
// stood 12 and 191 standard deviations off.
TEST(ConsensusTest, IsAskedForWhereALossTakesMoreFromOnePassThanFromOthers) {
  test::BasinScene strips("block-12-strips", 150);
  const auto& ways = test::BasinWays();
  const test::BasinOutcome half =
      strips.Run({500.0, 0.10, test::GrossError::kRange}, ways[2], 7011);
  EXPECT_TRUE(half.recovered) << half.words;
  test::BasinScene venus("venus-magellan", 150);
  const test::BasinCell cell{5000.0, 0.05, test::GrossError::kRange};
  EXPECT_TRUE(venus.Run(cell, ways[3], 7006).recovered);
  strips.LeaveConsensusAway();
  const test::BasinOutcome alone =
      strips.Run({500.0, 0.10, test::GrossError::kRange}, ways[2], 7011);
  EXPECT_FALSE(alone.accepted);
  EXPECT_NE(alone.words.find("pass S3 lost at least half of its looks at points of three looks"),
            std::string::npos)
      << alone.words;
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         BasinTest,
                         testing::Values("block-12-strips",
                                         "cross-wise",
                                         "earth-same-side",
                                         "leberl-aircraft",
                                         "moon-alse",
                                         "venus-magellan"),
                         [](const auto& scene) { return test::TestNameOf(scene.param); });

}  // namespace
}  // namespace sarblock
