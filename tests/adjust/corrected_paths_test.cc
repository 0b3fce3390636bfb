// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"

#include <array>

#include "model/problem.h"
#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// Two routes: the corrected path that a result writes, interpolated, against the model with the
/// estimated parameters. The bound is the interpolation of turning axes between states.
void ExpectPathsOfModel(const Block& block, const AdjustOptions& options, double bound_m) {
  const AdjustResult result = Adjust(block, options);
  ASSERT_TRUE(result.usable()) << testing::PrintToString(result.warnings);
  const AdjustmentProblem problem(block, options.groups);
  Eigen::VectorXd x(static_cast<Eigen::Index>(result.parameters.size()));
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    x[static_cast<Eigen::Index>(i)] = result.parameters[i].value;
  }
  EXPECT_GT(x.cwiseAbs().maxCoeff(), 0.1);  // there is something to write
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    const Pass& source = block.passes[pass];
    for (int k = 1; k < 200; ++k) {
      const double time_s = source.start_s + (source.end_s - source.start_s) * k / 200.3;
      const auto model = problem.model.CorrectedMotionAt(pass, time_s, x);
      const auto written = result.corrected_paths[pass].At(time_s);
      ASSERT_TRUE(model && written) << source.id << " at " << time_s;
      EXPECT_LT((model->motion.position_m - written->position_m).norm(), bound_m) << time_s;
      EXPECT_LT((model->motion.velocity_mps - written->velocity_mps).norm(), 0.02) << time_s;
    }
  }
}

test::KnownBlock NoisyBlock(test::BlockPlan plan) {
  plan.points = 60;
  test::KnownBlock known = test::MakeBlock(plan);
  test::AddNoise(11, 1.0, &known);
  for (const std::size_t point : std::array<std::size_t, 5>{0U, 7U, 19U, 33U, 48U}) {
    test::AddKnownPoint(point, {0.5, 0.5, 0.5}, &known);
  }
  return known;
}

AdjustOptions WithPosition(const PositionCorrection& position) {
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}, {"time", TimeCorrection{1e-3}, {}, false}};
  return options;
}

TEST(CorrectedPathsTest, FollowASplineBetweenTheNominalStates) {
  for (const test::BlockPlan& plan : {test::AircraftPlan(), test::OrbitPlan()}) {
    const test::KnownBlock known = NoisyBlock(plan);
    PositionCorrection position;
    position.basis = PositionCorrection::Basis::kSpline;
    const Pass& first = known.block.passes.front();
    position.knot_spacing_s = (first.end_s - first.start_s) / 6.3;
    position.prior_sigma_m = {{{3.0}, {3.0}, {3.0}}};
    ExpectPathsOfModel(known.block, WithPosition(position), 1e-4);
  }
}

TEST(CorrectedPathsTest, FollowAPolynomialOfAHighDegree) {
  for (const test::BlockPlan& plan : {test::AircraftPlan(), test::OrbitPlan()}) {
    const test::KnownBlock known = NoisyBlock(plan);
    PositionCorrection position;
    position.degree = 7;
    position.prior_sigma_m = {{{3.0}, {3.0}, {3.0}}};
    ExpectPathsOfModel(known.block, WithPosition(position), 1e-4);
  }
}

}  // namespace
}  // namespace sarblock
