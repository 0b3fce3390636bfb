// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/geometry/look_equations.h"

#include <cmath>
#include <string>

#include "model/problem.h"
#include "support/scene_blocks.h"
#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

class PredictedLookTest : public testing::TestWithParam<double> {};

// Second route: the time at which the cone holds the point, by Newton's method on the path itself,
// and the range there, under noise of the stated size.
TEST_P(PredictedLookTest, IsTheTimeAndTheRangeOfThePath) {
  test::KnownBlock known = test::MakeBlock(test::OrbitPlan(GetParam()));
  test::AddNoise(17, 1.0, &known);
  const Block& block = known.block;
  const AdjustmentProblem problem(block, {});
  BlockState state;
  state.start_m = known.truth_m;
  state.displacement_m.assign(known.truth_m.size(), Eigen::Vector3d::Zero());
  for (std::size_t point = 0; point < known.truth_m.size(); ++point) {
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      Cone cone;
      cone.squint_rad = block.looks.cone[i];
      const FlightPath& path = block.passes[block.looks.pass[i]].path;
      const auto predicted_s =
          SolveConeTime(path, known.truth_m[point], cone, block.looks.time_s[i]);
      ASSERT_TRUE(predicted_s.has_value());
      const double range_m = (known.truth_m[point] - path.At(*predicted_s)->position_m).norm();
      LookColumns columns;
      LookEvaluation at;
      ASSERT_TRUE(EvaluateLook(problem.model, state, point, i, {}, &columns, &at));
      // Coordinates are rounded to 1e-9 m. The path is a cubic, and continued as one.
      EXPECT_NEAR(at.whitened_error[1] * at.azimuth_unit_m,
                  (*predicted_s - block.looks.time_s[i]) * at.azimuth_unit_m,
                  3e-7);
      EXPECT_NEAR(at.whitened_error[0], range_m - block.looks.range_m[i], 3e-7);
      EXPECT_GT(std::abs(at.whitened_error[1]), 1e-9);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Squints, PredictedLookTest, testing::Values(0.0, 20.0, 60.0));

/// Mean of e' C^-1 e / 3 over the tie points.
double NormalisedSquare(const test::SceneBlock& made, const AdjustResult& result) {
  double sum = 0.0, count = 0.0;
  for (std::size_t j = 0; j < made.block.points.size(); ++j) {
    if (made.block.points.role[j] != PointRole::kTie || !IsSolved(result.points.status[j]))
      continue;
    const double off = test::DistanceInSigmas(made.block.frame,
                                              result.points.position_m[j],
                                              made.truth.points_m[j],
                                              result.points.covariance_m2[j]);
    sum += off * off / 3.0;
    count += 1.0;
  }
  return sum / count;
}

// Six thousand looks say nothing of the length along the flights, which four control points give to
// a hundredth. Equations that hold the measured times as exact have errors proportional to that
// length, win by shrinking it and end 50 sigmas short (NEES 67 to 82 with these seeds,
// docs/validation.md). The errors of all points are one scale and one shift, so that NEES spreads
// like a chi-square of two over two: below 5 in 99 of 100 draws.
TEST(AdjustedTimeScaleTest, ManyLooksDoNotShrinkTheBlock) {
  for (const std::string seed : {"1", "2", "3"}) {
    SCOPED_TRACE("seed " + seed);
    const test::SceneBlock made = test::SimulatedSceneBlock(
        "benchmarks",
        "strips",
        {"seed=" + seed,
         "points.count=1500",
         "control.count=4",
         "control.sigma_m=[1500,100,100]",
         "adjust.correction.position.sigma_m=[[10000,5000],[100,50],[100,50]]"});
    const AdjustResult result = Adjust(made.block, made.options);
    ASSERT_TRUE(result.usable());
    EXPECT_LT(NormalisedSquare(made, result), 5.0);
    // The looks fit as well as noise does: s0^2 has a standard deviation of 0.017.
    EXPECT_NEAR(result.sigma0_squared, 1.0, 0.08);
  }
}

}  // namespace
}  // namespace sarblock
