// SPDX-License-Identifier: Apache-2.0
// Blocks whose ranges and times hold delays: adjusted with them taken off, and with them left in.
#include "sarblock/adjust/adjust.h"
#include "sarblock/diagnose/diagnose.h"
#include "sarblock/reduction/reduction.h"

#include <cmath>
#include <string>
#include <vector>

#include "support/scene_blocks.h"
#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

std::vector<std::string> Dates(std::size_t flights) {
  std::vector<std::string> sets;
  for (std::size_t i = 0; i < flights; ++i) {
    sets.push_back("flight." + std::to_string(i) + ".epoch_utc=\"2021-0" + std::to_string(i + 1) +
                   "-09T05:30:00Z\"");
  }
  return sets;
}

/// The scene with these settings more.
test::SceneBlock SceneWith(const std::string& name,
                           std::size_t flights,
                           std::vector<std::string> sets) {
  // Looks of some centimetres: a delay left in shows.
  sets.insert(sets.end(),
              {"points.count=80",
               "check.count=0",
               "looks.range_sigma_m=0.05",
               "looks.azimuth_sigma_m=0.1"});
  for (const std::string& date : Dates(flights)) sets.push_back(date);
  return test::SimulatedSceneBlock("scenes", name, sets);
}

/// Largest shift of a point between two results, in sigmas of the first.
double LargestShift(const AdjustResult& a, const AdjustResult& b, const Frame& frame) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.points.position_m.size(); ++i) {
    if (!IsSolved(a.points.status[i])) continue;
    const Eigen::Vector3d shift_m = frame.EnuFromFrame(a.points.position_m[i]) *
                                    (b.points.position_m[i] - a.points.position_m[i]);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double sigma_m = std::sqrt(a.points.covariance_m2[i][static_cast<std::size_t>(k)]);
      largest = std::max(largest, std::abs(shift_m[k]) / sigma_m);
    }
  }
  return largest;
}

struct Term {
  std::string name, scene;
  std::size_t flights;
  std::vector<std::string> models;  ///< behind "truth.delay." or "reduction."
};

class ReductionOfScenes : public testing::TestWithParam<Term> {};

TEST_P(ReductionOfScenes, PlantedAndTakenOffLeavesThePositions) {
  const auto prefixed = [](const std::string& prefix, std::vector<std::string> list) {
    for (std::string& entry : list) entry.insert(0, prefix);
    return list;
  };
  const Term& term = GetParam();
  const std::vector<std::string> planted = prefixed("truth.delay.", term.models);
  std::vector<std::string> both = planted;
  for (const std::string& set : prefixed("reduction.", term.models)) both.push_back(set);
  const test::SceneBlock without = SceneWith(term.scene, term.flights, {});
  const test::SceneBlock left_in = SceneWith(term.scene, term.flights, planted);
  const test::SceneBlock taken_off = SceneWith(term.scene, term.flights, both);
  for (const Engine engine : {Engine::kReduced, Engine::kCeres}) {
    AdjustOptions options = without.options;
    options.engine = engine;
    const Frame& frame = without.block.frame;
    const AdjustResult exact = Adjust(without.block, options);
    const double left = LargestShift(exact, Adjust(left_in.block, options), frame);
    EXPECT_GT(left, 0.01);
    EXPECT_LT(LargestShift(exact, Adjust(taken_off.block, options), frame),
              std::min(0.01, 0.05 * left));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Terms,
    ReductionOfScenes,
    testing::Values(
        Term{"Troposphere", "earth-same-side", 3, {"troposphere=standard"}},
        Term{"Weather",
             "earth-asc-desc",
             2,
             {"troposphere={pressure_hpa=980,temperature_k=290,humidity_1=0.6,height_m=200}"}},
        Term{"Ionosphere", "earth-same-side", 3, {"ionosphere={tec_tecu=60,share_1=0.9}"}},
        Term{"Tide", "earth-same-side", 3, {"tide=solid"}},
        Term{"Constants", "convergent-squint", 2, {"range_m=4.5", "time_s=-0.01"}},
        Term{"Aircraft", "leberl-aircraft", 2, {"troposphere=standard"}}),
    [](const testing::TestParamInfo<Term>& of) { return of.param.name; });

TEST(ReductionsTest, ColumnsOfTheSameSizeGiveTheSame) {
  const test::SceneBlock scene = SceneWith("earth-same-side",
                                           3,
                                           {"truth.delay.troposphere=standard",
                                            "reduction.troposphere=standard",
                                            "truth.delay.tide=solid",
                                            "reduction.tide=solid",
                                            "reduction.range_m=0.125"});
  const AdjustResult by_models = Adjust(scene.block, scene.options);
  ASSERT_EQ(by_models.reductions.range_m.size(), scene.block.looks.size());
  Block columns = scene.block;
  for (Pass& pass : columns.passes) pass.reduction = {};
  columns.looks.range_delay_m = by_models.reductions.range_m;
  columns.looks.time_shift_s = by_models.reductions.time_s;
  for (std::size_t i = 0; i < columns.looks.size(); ++i) {
    columns.looks.range_m[i] -= columns.looks.range_delay_m[i];
    columns.looks.time_s[i] -= columns.looks.time_shift_s[i];
  }
  const AdjustResult by_columns = Adjust(columns, scene.options);
  for (std::size_t i = 0; i < by_models.points.position_m.size(); ++i) {
    EXPECT_LT((by_columns.points.position_m[i] - by_models.points.position_m[i]).norm(), 1e-9);
  }
  EXPECT_EQ(by_columns.reductions.range_m, by_models.reductions.range_m);
  EXPECT_EQ(by_columns.reductions.terms.front().term, "given");
  // A block that may be changed is as before, and gives the same.
  Block changed = scene.block;
  const AdjustResult in_place = Adjust(&changed, scene.options);
  EXPECT_EQ(in_place.points.position_m, by_models.points.position_m);
  EXPECT_EQ(changed.looks.range_m, scene.block.looks.range_m);
  EXPECT_EQ(changed.passes[0].reduction, scene.block.passes[0].reduction);
}

/// Two passes of one side at the height H see a point at y1 and y2 beside them: from R_k^2 = y_k^2
/// + H^2 and delays Z R_k/H follows that ranges which keep a zenith delay Z put the point Z (1 -
/// y1 y2/H^2) too low.
TEST(ReductionsTest, AZenithDelayLeftInMovesHeightsAsThePlaneSays) {
  constexpr double kFlown_m = 6000.0, kNear_m = 3000.0, kFar_m = 7000.0;
  test::BlockPlan plan;
  for (const double ground_range_m : {kNear_m, kFar_m}) {
    plan.passes.push_back({.side = LookSide::kLeft,
                           .ground_range_m = ground_range_m,
                           .height_m = kFlown_m,
                           .straight = true});
  }
  plan.points = 1;
  plan.sigma = {1.0, 1.0, AzimuthUnit::kMetres};
  test::KnownBlock known = test::MakeBlock(plan);
  AdjustOptions options;
  options.corrections = CorrectionChoice::kNone;
  const Eigen::Vector3d before_m = IntersectBlock(known.block, options).points.position_m[0];
  for (Pass& pass : known.block.passes) {
    pass.reduction.troposphere = TroposphereModel::kStandard;
  }
  const Eigen::Vector3d after_m = IntersectBlock(known.block, options).points.position_m[0];
  const double zenith_m = ZenithDelay_m(before_m.z()) - ZenithDelay_m(kFlown_m);
  const double expected_m = zenith_m * (1.0 - kNear_m * kFar_m / (kFlown_m * kFlown_m));
  EXPECT_NEAR(after_m.z() - before_m.z(), expected_m, 0.02 * expected_m);
  EXPECT_GT(expected_m, 0.4);
}

TEST(ReductionsTest, PlansAreFilledSoThatTheyReduceToGeometry) {
  test::KnownBlock known = test::MakeBlock(test::OrbitPlan());
  test::AddKnownPoint(0, {0.1, 0.1, 0.1}, &known);
  for (Pass& pass : known.block.passes) {
    pass.reduction.troposphere = TroposphereModel::kStandard;
    pass.reduction.time_s = 1e-3;
  }
  Block planned = known.block;
  planned.looks.time_s.assign(planned.looks.size(), kNotGiven);
  planned.looks.range_m.assign(planned.looks.size(), kNotGiven);
  AdjustOptions options;
  options.corrections = CorrectionChoice::kNone;
  const AdjustResult result = Adjust(FillMeasurements(planned, known.truth_m), options);
  // Delays are taken off again until they change by less than a millimetre.
  for (std::size_t i = 0; i < known.truth_m.size(); ++i) {
    EXPECT_LT((result.points.position_m[i] - known.truth_m[i]).norm(), 2e-3);
  }
  EXPECT_LT(Diagnose(FillMeasurements(planned, known.truth_m), options).square_sum, 1e-4);
}

}  // namespace
}  // namespace sarblock
