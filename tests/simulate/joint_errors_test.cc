// SPDX-License-Identifier: Apache-2.0
// Errors of simulated flights with a full covariance.
#include "sarblock/core/statistics.h"
#include "sarblock/simulate/scene.h"

#include <cmath>
#include <string>
#include <vector>

#include "linear/dense.h"
#include "simulate/scene.h"
#include "simulate/true_path.h"
#include "support/small_blocks.h"
#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

JointPrior Orbit() {
  JointPrior prior;
  prior.name = "orbit";
  prior.parameters = {"position.along.0", "position.up.1", "time.bias", "position.across.2"};
  prior.sigma = {2.0, 0.7, 1e-4, 0.3};
  prior.correlation = Eigen::Matrix4d{
      {1.0, 0.9, -0.8, 0.1}, {0.9, 1.0, -0.7, 0.0}, {-0.8, -0.7, 1.0, 0.2}, {0.1, 0.0, 0.2, 1.0}};
  return prior;
}

// Seeded statistics: sum of e' Q^-1 e is chi-square, 99.9 percent.
TEST(JointErrorsTest, AreDrawnFromTheMatrix) {
  const Block block = test::MakeBlock(test::AircraftPlan()).block;
  const JointPrior prior = Orbit();
  const Eigen::MatrixXd p = dense::Cholesky(prior.Covariance().matrix()).Inverse();
  double sum = 0.0;
  constexpr int kDraws = 2000;
  for (int draw = 0; draw < kDraws; ++draw) {
    PassError error;
    AddJointErrors(
        {prior}, block.frame, block.passes[0], 3, static_cast<std::uint64_t>(draw), &error);
    const Eigen::Vector4d e(
        error.constant_m[0], error.drift_m[2], error.time_bias_s, error.curvature_m[1]);
    sum += e.dot(p * e);
    EXPECT_EQ(error.constant_m[1], 0.0);
    EXPECT_EQ(error.range_bias_m, 0.0);
  }
  EXPECT_TRUE(ChiSquareInterval(0.999, 4.0 * kDraws).Contains(sum)) << sum / kDraws;
}

// Invariance: other passes and other priors draw their own; a pass that is not named has none.
TEST(JointErrorsTest, ArePassByPass) {
  const Block block = test::MakeBlock(test::AircraftPlan()).block;
  JointPrior prior = Orbit();
  PassError first, second, again, none;
  AddJointErrors({prior}, block.frame, block.passes[0], 0, 5, &first);
  AddJointErrors({prior}, block.frame, block.passes[1], 1, 5, &second);
  AddJointErrors({prior}, block.frame, block.passes[0], 0, 5, &again);
  EXPECT_NE(first.constant_m[0], second.constant_m[0]);
  EXPECT_EQ(first.constant_m[0], again.constant_m[0]);
  prior.passes = {block.passes[1].id};
  AddJointErrors({prior}, block.frame, block.passes[0], 0, 5, &none);
  EXPECT_EQ(none.constant_m[0], 0.0);
}

// Closed form: in frame axes the true path is the nominal one moved by a + x b + (3 x^2 - 1)/2 c,
// its velocity by the derivative of that; in ric axes along the radius.
TEST(JointErrorsTest, FrameAxesMoveThePathAlongTheFrame) {
  const Block block = test::MakeBlock(test::OrbitPlan()).block;
  const Pass& pass = block.passes[0];
  PassError error;
  error.frame_m = {Eigen::Vector3d(1.5, -2.5, 0.75),
                   Eigen::Vector3d(-0.5, 0.25, 3.5),
                   Eigen::Vector3d(0.125, 4.5, -1.25)};
  const TruePath path(block.frame, pass, error, kNotGiven);
  const double half_s = 0.5 * (pass.end_s - pass.start_s);
  for (const double x : {-0.875, 0.25, 0.625}) {
    const double time_s = pass.start_s + (x + 1.0) * half_s;
    const Motion moved = *path.At(time_s), nominal = *pass.path.At(time_s);
    const Eigen::Vector3d by_m =
        error.frame_m[0] + x * error.frame_m[1] + (1.5 * x * x - 0.5) * error.frame_m[2];
    const Eigen::Vector3d rate_mps = (error.frame_m[1] + 3.0 * x * error.frame_m[2]) / half_s;
    EXPECT_LT((moved.position_m - nominal.position_m - by_m).norm(), 1e-8);
    EXPECT_LT((moved.velocity_mps - nominal.velocity_mps - rate_mps).norm(), 1e-10);
  }
  JointPrior radial;
  radial.name = "r";
  radial.axes = JointPrior::Axes::kRic;
  radial.parameters = {"position.radial.0"};
  radial.sigma = {10.0};
  PassError drawn;
  AddJointErrors({radial}, block.frame, pass, 0, 77, &drawn);
  const Eigen::Vector3d r_m = pass.path.At(0.5 * (pass.start_s + pass.end_s))->position_m;
  EXPECT_GT(drawn.frame_m[0].norm(), 0.1);
  EXPECT_LT(drawn.frame_m[0].normalized().cross(r_m.normalized()).norm(), 1e-12);
}

// Hand arithmetic of what the margins of a flight take.
TEST(JointErrorsTest, SigmasAddUp) {
  const JointSigmas sums = SumJointSigmas({Orbit()});
  EXPECT_DOUBLE_EQ(sums.shift_m, 3.0);
  EXPECT_DOUBLE_EQ(sums.end_slope_m, 0.7 + 3.0 * 0.3);
  EXPECT_DOUBLE_EQ(sums.time_bias_s, 1e-4);
  EXPECT_EQ(sums.squint_bias_rad, 0.0);
}

}  // namespace
}  // namespace sarblock
