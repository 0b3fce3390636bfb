// SPDX-License-Identifier: Apache-2.0
// Delays that were left in, in blocks that are good enough to see them.
#include "sarblock/diagnose/diagnose.h"
#include "sarblock/reduction/reduction.h"

#include <cmath>
#include <string>
#include <vector>

#include "support/scene_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// Ranges of this standard deviation, all else as good.
test::SceneBlock PreciseBlock(const std::string& scene,
                              std::vector<std::string> sets,
                              double sigma_m = 0.05) {
  const auto times = [&](double factor) { return std::to_string(factor * sigma_m); };
  const std::string control = times(0.6), flown = times(0.4);
  sets.insert(sets.end(),
              {"looks.range_sigma_m=" + times(1.0),
               "looks.azimuth_sigma_m=" + times(2.0),
               "control.sigma_m=[" + control + "," + control + "," + control + "]",
               "control.count=16",
               "control.layout=grid",
               "check.count=0",
               "points.count=200",
               "navigation.constant_sigma_m=[" + flown + "," + flown + "," + flown + "]",
               "navigation.drift_sigma_m=[0,0,0]",
               "flight.0.epoch_utc=\"2022-06-15T10:40:00Z\"",
               "flight.1.epoch_utc=\"2022-06-15T17:10:00Z\""});
  if (scene == "earth-same-side") sets.push_back("flight.2.epoch_utc=\"2022-06-17T17:10:00Z\"");
  test::SceneBlock made = test::SimulatedSceneBlock("scenes", scene, sets);
  PositionCorrection position;
  position.prior_sigma_m.fill({0.4 * sigma_m});
  made.options.groups = {{"position", position, {}, false}};
  made.options.corrections = CorrectionChoice::kGiven;
  return made;
}

const Explanation& First(const Diagnosis& diagnosis) { return diagnosis.explanations.at(0); }

TEST(DelaysTest, AZenithDelayIsDistinguishedFromABias) {
  const test::SceneBlock left_in =
      PreciseBlock("earth-same-side", {"truth.delay.troposphere=standard"});
  const Diagnosis diagnosis = Diagnose(left_in.block, left_in.options);
  EXPECT_EQ(First(diagnosis).cause, "range.troposphere");
  EXPECT_NEAR(First(diagnosis).value, ZenithDelay_m(0.0), 4.0 * First(diagnosis).sigma);
  EXPECT_TRUE(First(diagnosis).cure.cures);
  const test::SceneBlock bias = PreciseBlock("earth-same-side", {"truth.delay.range_m=2.5"});
  EXPECT_EQ(First(Diagnose(bias.block, bias.options)).cause, "range.bias");
}

TEST(DelaysTest, TimesThatGrowWithRangeAreThoseOfTheEcho) {
  test::SceneBlock made = PreciseBlock("earth-asc-desc", {});
  constexpr double kMiddle_m = 850e3, kLight_mps = 299792458.0;
  for (std::size_t i = 0; i < made.block.looks.size(); ++i) {
    made.block.looks.time_s[i] += (made.block.looks.range_m[i] - kMiddle_m) / kLight_mps;
  }
  const Diagnosis diagnosis = Diagnose(made.block, made.options);
  EXPECT_EQ(First(diagnosis).cause, "time.bistatic");
  EXPECT_TRUE(First(diagnosis).cure.cures);
}

TEST(DelaysTest, ATideThatTwoHoursOfTheDaySeeDifferently) {
  const test::SceneBlock left_in = PreciseBlock("earth-asc-desc", {"truth.delay.tide=solid"}, 0.02);
  const Diagnosis diagnosis = Diagnose(left_in.block, left_in.options);
  EXPECT_EQ(First(diagnosis).cause, "control.tide");
  EXPECT_TRUE(First(diagnosis).cure.cures);
}

TEST(DelaysTest, NothingIsSaidWhereTheyAreTakenOff) {
  const test::SceneBlock good = PreciseBlock("earth-asc-desc",
                                             {"truth.delay.troposphere=standard",
                                              "reduction.troposphere=standard",
                                              "truth.delay.tide=solid",
                                              "reduction.tide=solid"});
  EXPECT_FALSE(Diagnose(good.block, good.options).contradicts);
}

}  // namespace
}  // namespace sarblock
