// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/geometry/look_equations.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include "linear/dense.h"
#include "support/small_blocks.h"
#include <Eigen/QR>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// The explicit model of one point, paths held: (t - t_p)/sigma_t and (R - R_p)/sigma_R of every
/// look, t_p by solving the cone equation.
Eigen::VectorXd ExplicitResiduals(const Block& block,
                                  std::size_t point,
                                  const Eigen::Vector3d& p_m) {
  const std::size_t begin = block.looks.offsets[point], end = block.looks.offsets[point + 1];
  Eigen::VectorXd out = Eigen::VectorXd::Zero(2 * static_cast<Eigen::Index>(end - begin));
  for (std::size_t i = begin; i < end; ++i) {
    if (block.looks.rejected(i)) continue;  // its rows stay 0
    const Pass& pass = block.passes[block.looks.pass[i]];
    Cone cone;
    cone.squint_rad = block.looks.cone[i];
    const auto time_s = SolveConeTime(pass.path, p_m, cone, block.looks.time_s[i]);
    if (!time_s) throw std::logic_error("a point of the test left its pass");
    const double range_m = (p_m - pass.path.At(*time_s)->position_m).norm();
    const LookSigma sigma = block.SigmaOf(i);
    const Eigen::Index row = 2 * static_cast<Eigen::Index>(i - begin);
    out[row] = (block.looks.time_s[i] - *time_s) / sigma.azimuth;
    out[row + 1] = (block.looks.range_m[i] - range_m) / sigma.range_m;
  }
  return out;
}

/// Gauss-Newton with differences over 10 m: the equations bend by 1e-6 per metre, so a
/// Jacobian right to 1e-9 and, iterated, a solution right to the rounding of t.
Eigen::Vector3d SolveExplicit(const Block& block, std::size_t point, Eigen::Vector3d p_m) {
  for (int iteration = 0; iteration < 12; ++iteration) {
    const Eigen::VectorXd residual = ExplicitResiduals(block, point, p_m);
    Eigen::MatrixXd jacobian(residual.size(), 3);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Eigen::Vector3d step_m = 10.0 * Eigen::Vector3d::Unit(k);
      jacobian.col(k) = (ExplicitResiduals(block, point, p_m + step_m) -
                         ExplicitResiduals(block, point, p_m - step_m)) /
                        20.0;
    }
    p_m -= dense::PivotedOrthogonal(jacobian).Solve(residual).col(0);
  }
  return p_m;
}

class ExplicitModelTest : public testing::TestWithParam<double> {};

// A second model: explicit (t predicted by solving the cone) against that of the program (the cone
// as a condition, its time adjusted). They are one. Noise is coarse, half a kilometre: with the
// measured times as exact the points would lie metres apart.
TEST_P(ExplicitModelTest, AnswersTheSamePointsUnderNoise) {
  test::BlockPlan plan = test::OrbitPlan(GetParam());
  plan.sigma = {410.0, 0.061, AzimuthUnit::kSeconds};
  plan.points = 40;
  AdjustOptions options;
  options.covariance = CovarianceLevel::kNone;
  options.tolerance = 1e-9;
  for (const double noise : {1.0, 0.25, 0.0625}) {
    test::KnownBlock known = test::MakeBlock(plan);
    test::AddNoise(4711, noise, &known);
    // Every third point keeps two of its three looks, with one equation to spare.
    for (std::size_t j = 0; j < plan.points; j += 3) {
      known.block.looks.flags[known.block.looks.offsets[j] + 1] |= Looks::kRejected;
    }
    const AdjustResult adjusted = Adjust(known.block, options);
    ASSERT_TRUE(adjusted.usable());
    for (std::size_t j = 0; j < plan.points; ++j) {
      const Eigen::Vector3d p_m = SolveExplicit(known.block, j, known.truth_m[j]);
      // Shifts are kept to 6e-8 of themselves, of some 450 m.
      EXPECT_LT((p_m - adjusted.points.position_m[j]).norm(), noise * 1e-4) << j;
    }
  }
}

// Two looks of three unknowns have one redundant equation, and a look alone fits both models: where
// all residuals vanish both must answer the same point.
TEST_P(ExplicitModelTest, AnswersTheSamePointWithoutNoise) {
  test::BlockPlan plan = test::OrbitPlan(GetParam());
  plan.points = 5;
  const test::KnownBlock known = test::MakeBlock(plan);
  const AdjustResult implicit = Adjust(known.block, {});
  for (std::size_t j = 0; j < plan.points; ++j) {
    const Eigen::Vector3d start_m = known.truth_m[j] + Eigen::Vector3d(120.0, -70.0, 90.0);
    // Times rounded to 6e-14 s and coordinates to 1e-9 m, over intersections of 15 degrees.
    EXPECT_LT((SolveExplicit(known.block, j, start_m) - implicit.points.position_m[j]).norm(),
              1e-7);
  }
}

INSTANTIATE_TEST_SUITE_P(Squints, ExplicitModelTest, testing::Values(0.0, 20.0, 60.0));

}  // namespace
}  // namespace sarblock
