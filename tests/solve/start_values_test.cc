// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/statistics.h"

#include <cmath>
#include <string>
#include <vector>

#include "solve/start.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

AdjustOptions FreePositions() {
  PositionCorrection position;
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  return options;
}

test::KnownBlock NoisyBlock(bool orbit) {
  test::BlockPlan plan = orbit ? test::OrbitPlan() : test::AircraftPlan();
  plan.points = 25;
  test::KnownBlock known = test::MakeBlock(plan);
  for (const std::size_t j : {0U, 6U, 11U, 18U, 23U})
    test::AddKnownPoint(j, {0.3, 0.4, 0.5}, &known);
  test::AddNoise(20, 1.0, &known);
  return known;
}

class StartValuesTest : public testing::TestWithParam<bool> {};

// Invariance: where the solution starts must not matter. Start values wrong by 5 km, paths by
// 2 km (which the corrections take up), against the solution started well.
TEST_P(StartValuesTest, ErrorsOfKilometresLeadToTheSameSolution) {
  const test::KnownBlock known = NoisyBlock(GetParam());
  const AdjustResult well = Adjust(known.block, FreePositions());
  ASSERT_TRUE(well.usable());

  Block badly = known.block;
  RandomStream random(5000, 2);
  const auto direction = [&random] {
    return Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
  };
  for (std::size_t j = 0; j < badly.points.size(); ++j) {
    if (badly.points.role[j] == PointRole::kTie) {
      badly.points.given_m[j] = known.truth_m[j] + 5000.0 * direction();
    }
  }
  // The same shift of all states moves track axes on an orbit too; corrections in frame axes and
  // constant ones would undo it exactly, those in track axes to first order of the turning, so
  // only frame axes compare.
  AdjustOptions options = FreePositions();
  std::get<PositionCorrection>(options.groups[0].model).axes = PositionCorrection::Axes::kFrame;
  const AdjustResult frame = Adjust(known.block, options);
  std::vector<Eigen::Vector3d> shift_m;
  for (std::size_t i = 0; i < badly.passes.size(); ++i) {
    shift_m.push_back(2000.0 * direction());
    test::ShiftPath(i, shift_m[i], &badly);
  }
  const AdjustResult far = Adjust(badly, options);
  ASSERT_TRUE(far.usable()) << testing::PrintToString(far.warnings);
  EXPECT_LE(far.iterations, 50);
  for (std::size_t j = 0; j < known.truth_m.size(); ++j) {
    EXPECT_LT(test::DistanceInSigmas(known.block.frame,
                                     frame.points.position_m[j],
                                     far.points.position_m[j],
                                     frame.points.covariance_m2[j]),
              1e-6)
        << j;
  }
  for (std::size_t k = 0; k < far.parameters.size(); ++k) {
    EXPECT_NEAR(far.parameters[k].value + shift_m[k / 3][static_cast<Eigen::Index>(k % 3)],
                frame.parameters[k].value,
                1e-6 * frame.parameters[k].sigma + 1e-8);
  }
}

// Start values alone, the paths right: the same to the last digits that count.
TEST_P(StartValuesTest, GivenCoordinatesOfTiePointsAreStartValuesAndNothingMore) {
  test::KnownBlock known = NoisyBlock(GetParam());
  const AdjustResult free = Adjust(known.block, FreePositions());
  for (std::size_t j = 0; j < known.truth_m.size(); ++j) {
    if (known.block.points.role[j] != PointRole::kTie) continue;
    known.block.points.given_m[j] = known.truth_m[j] + Eigen::Vector3d(2900.0, -2900.0, 2900.0);
  }
  const AdjustResult given = Adjust(known.block, FreePositions());
  ASSERT_TRUE(given.usable());
  EXPECT_EQ(given.observation_count, free.observation_count);
  for (std::size_t j = 0; j < known.truth_m.size(); ++j) {
    const double sigma_m = std::sqrt(free.points.covariance_m2[j][0]);
    EXPECT_LT((given.points.position_m[j] - free.points.position_m[j]).norm(), 1e-6 * sigma_m);
  }
}

INSTANTIATE_TEST_SUITE_P(AircraftAndOrbit, StartValuesTest, testing::Bool());

TEST(StartValuesReportTest, LooksOutsideTheirPathAreCountedAndNamed) {
  test::KnownBlock known = NoisyBlock(false);
  const std::size_t lost = known.block.looks.offsets[8] + 2;
  known.block.looks.time_s[lost] = known.block.passes[2].path.end_s() + 3.7;
  const AdjustResult result = Adjust(known.block, FreePositions());
  EXPECT_TRUE(result.usable());
  EXPECT_EQ(result.looks_not_evaluated, 1U);
  EXPECT_EQ(result.looks_used, 99U);
  EXPECT_THAT(result.warnings,
              Contains(AllOf(HasSubstr("1 looks have no value"), HasSubstr("A3/P9"))));
  EXPECT_EQ(result.looks.rejected[lost], 1);
  EXPECT_EQ(result.points.looks[8], 3U);
}

// Withheld: a check point's coordinates are not even its start values.
TEST(StartValuesReportTest, CheckPointsStartFromTheirLooks) {
  test::KnownBlock known = NoisyBlock(false);
  test::AddKnownPoint(2, {0.1, 0.1, 0.1}, &known, PointRole::kCheck);
  known.block.points.given_m[2] = Eigen::Vector3d(1e6, 1e6, 0.0);
  AdjustmentProblem problem(known.block, {});
  const StartReport start = ComputeStartValues(&problem, nullptr);
  EXPECT_LT((start.state.start_m[2] - known.truth_m[2]).norm(), 10.0);
  EXPECT_EQ(start.state.start_m[0], known.block.points.given_m[0]) << "control starts where it is";
}

}  // namespace
}  // namespace sarblock
