// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <vector>

#include "cost/look_cost.h"
#include "linear/dense.h"
#include "solve/ceres_engine.h"
#include "support/small_blocks.h"
#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using RowMajor3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

std::vector<CorrectionGroup> FrameOffsetRangeAndSquint() {
  PositionCorrection position;
  position.axes = PositionCorrection::Axes::kFrame;
  RangeCorrection range;
  range.bias = range.scale = true;
  return {{"position", position, {}, false},
          {"range", range, {}, true},
          {"squint", SquintCorrection{}, {}, true}};
}

/// Range and azimuth time weighted, for Ceres' automatic derivatives: nominal motion given, a
/// constant offset of the antenna, range bias and scale, squint bias. The time by a fixed-point
/// iteration, which carries the derivatives with it.
struct SphereAndCone {
  Motion motion;
  Eigen::Vector3d start_m;
  double range_m;
  double squint_rad;
  LookWeights w;

  template <typename T>
  bool operator()(
      const T* displacement, const T* range, const T* squint, const T* offset, T* residuals) const {
    using std::sin;
    using std::sqrt;
    T dt = T(0.0), rho = T(0.0);
    for (int step = 0; step < 800; ++step) {
      T square = T(0.0), speed2 = T(0.0), product = T(0.0);
      for (int k = 0; k < 3; ++k) {
        const double v0 = motion.velocity_mps[k], a0 = motion.acceleration_mps2[k];
        const double j0 = motion.jerk_mps3[k];
        const T moved = dt * (v0 + dt * (0.5 * a0 + dt * (j0 / 6.0)));
        const T v = v0 + dt * (a0 + dt * (0.5 * j0));
        const T d = (start_m[k] - motion.position_m[k]) + displacement[k] - offset[k] - moved;
        square += d * d;
        speed2 += v * v;
        product += v * d;
      }
      rho = sqrt(square);
      const T e_d = product / sqrt(speed2) - rho * sin(squint_rad + squint[0]);
      dt += e_d / motion.velocity_mps.norm();  // the rate but for some tenths
    }
    residuals[0] = w.range_per_m * (rho - range_m + range[0] + range[1] * rho);
    residuals[1] = w.azimuth_per_unit * dt;
    return true;
  }
};

/// A block with its problem at a state off the truth.
class LookCostTest : public testing::TestWithParam<double> {
 protected:
  explicit LookCostTest(double squint_deg = GetParam())
      : known_(test::MakeBlock(test::OrbitPlan(squint_deg))),
        problem_(known_.block, FrameOffsetRangeAndSquint()) {
    state_.start_m = known_.truth_m;
    state_.displacement_m.assign(known_.truth_m.size(), Eigen::Vector3d(13.7, -8.3, 21.9));
    state_.corrections.setZero(problem_.layout.size());
    UpdateWeights(state_, &problem_);
  }
  test::KnownBlock known_;
  AdjustmentProblem problem_;
  BlockState state_;
};

// Second route: derivatives by ceres::Jet of the two equations written down once more.
TEST_P(LookCostTest, AgreesWithAutomaticDerivatives) {
  const Block& block = known_.block;
  const std::size_t point = 5;
  const std::array<double, 3> displacement{13.7, -8.3, 21.9}, offset{171.3, -63.9, 44.1};
  const std::array<double, 2> range{11.3, 2.7e-5};
  const double squint = 1.9e-3;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    Motion motion;
    ASSERT_TRUE(problem_.model.paths()[block.looks.pass[i]].ReadNominal(
        block.looks.time_s[i], block.looks.time_s[i], &motion));
    const ceres::AutoDiffCostFunction<SphereAndCone, 2, 3, 2, 1, 3> automatic(
        new SphereAndCone{motion,
                          known_.truth_m[point],
                          block.looks.range_m[i],
                          block.looks.cone[i],
                          problem_.weights[i]});
    const CostPointer made =
        LookCostOf(problem_, FlightsOf(problem_)[block.looks.pass[i]], &state_.start_m[point], i);
    const ceres::CostFunction& cost = *made;
    ASSERT_EQ(cost.parameter_block_sizes(), automatic.parameter_block_sizes());
    const std::array<const double*, 4> blocks{
        displacement.data(), range.data(), &squint, offset.data()};
    std::array<std::array<double, 6>, 4> computed{}, expected{};
    std::array<double*, 4> computed_at{}, expected_at{};
    for (std::size_t b = 0; b < 4; ++b) {
      computed_at[b] = computed[b].data();
      expected_at[b] = expected[b].data();
    }
    Eigen::Vector2d residual, reference;
    ASSERT_TRUE(cost.Evaluate(blocks.data(), residual.data(), computed_at.data()));
    ASSERT_TRUE(automatic.Evaluate(blocks.data(), reference.data(), expected_at.data()));
    // Residuals: weights near 1 per metre times coordinates rounded to 1e-9 m.
    EXPECT_LT((residual - reference).norm(), 1e-8);
    for (std::size_t b = 0; b < 4; ++b) {
      double scale = 0.0;
      for (const double value : expected[b]) scale = std::max(scale, std::abs(value));
      for (std::size_t k = 0; k < 6; ++k) {
        EXPECT_NEAR(computed[b][k], expected[b][k], 1e-12 * scale) << "block " << b << " " << k;
      }
    }
    // Without Jacobians, and with some of them, the residuals are the same.
    Eigen::Vector2d alone;
    ASSERT_TRUE(cost.Evaluate(blocks.data(), alone.data(), nullptr));
    EXPECT_EQ(alone, residual);
    std::array<double*, 4> some{nullptr, nullptr, computed_at[2], nullptr};
    const std::array<double, 6> before = computed[2];
    ASSERT_TRUE(cost.Evaluate(blocks.data(), alone.data(), some.data()));
    EXPECT_EQ(computed[2], before);
  }
}

INSTANTIATE_TEST_SUITE_P(Squints, LookCostTest, testing::Values(0.0, 19.3, 58.7));

TEST(LookCostDomainTest, RefusesWhereTheModelHasNoValue) {
  const test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  const AdjustmentProblem problem(
      known.block,
      {{"time", TimeCorrection{}, {}, false}, {"air", TroposphereCorrection{}, {}, true}});
  BlockState state;
  state.start_m = known.truth_m;
  const CostPointer cost = LookCostOf(problem, FlightsOf(problem)[0], state.start_m.data(), 0);
  const auto evaluates = [&cost](const Eigen::Vector3d& displacement_m, double bias_s) {
    const double zenith_m = 2.3;
    const std::array<const double*, 3> blocks{displacement_m.data(), &zenith_m, &bias_s};
    Eigen::Vector2d residual;
    return cost->Evaluate(blocks.data(), residual.data(), nullptr);
  };
  const Motion motion = *known.block.passes[0].path.At(known.block.looks.time_s[0]);
  const Eigen::Vector3d to_antenna_m = motion.position_m - known.truth_m[0];
  EXPECT_TRUE(evaluates(Eigen::Vector3d::Zero(), 0.0));
  EXPECT_FALSE(evaluates(Eigen::Vector3d::Zero(), 1e4)) << "outside the path";
  EXPECT_FALSE(evaluates(to_antenna_m, 0.0)) << "at the antenna";
  EXPECT_FALSE(evaluates({0.0, 0.0, to_antenna_m.z()}, 0.0)) << "a level sight line";
  EXPECT_FALSE(evaluates({kNotGiven, 0.0, 0.0}, 0.0)) << "not a number";
}

/// Control of some components at a point of an orbit block.
struct ControlCase {
  std::array<double, 3> sigma_m;
  double correlation;
};
class ControlCostTest : public testing::TestWithParam<ControlCase> {};

// Hand route: v'v is the quadratic form of the held components' covariance, the Jacobian is the
// central difference (steps of 1 m; the equations are linear but for a lone height, whose bend
// 1/6.4e6 per metre leaves 1e-13).
TEST_P(ControlCostTest, IsTheQuadraticFormOfTheHeldComponents) {
  test::KnownBlock known = test::MakeBlock(test::OrbitPlan());
  test::AddKnownPoint(4, GetParam().sigma_m, &known, PointRole::kControl, GetParam().correlation);
  const AdjustmentProblem problem(known.block, {});
  ASSERT_EQ(problem.control.size(), 1U);
  BlockState state;
  state.start_m = known.truth_m;
  state.start_m[4] += Eigen::Vector3d(3.1, -2.7, 1.3);
  const CostPointer made = ControlCostOf(known.block.frame, problem.control[0], &state.start_m[4]);
  const ceres::CostFunction& cost = *made;
  const Eigen::Vector3d displacement_m(11.9, 7.3, -5.7);
  const auto evaluate = [&cost](const Eigen::Vector3d& at_m, RowMajor3* jacobian) {
    Eigen::VectorXd residual(cost.num_residuals());
    const double* block = at_m.data();
    jacobian->resize(cost.num_residuals(), 3);
    double* out = jacobian->data();
    EXPECT_TRUE(cost.Evaluate(&block, residual.data(), &out));
    return residual;
  };
  RowMajor3 jacobian, unused;
  const Eigen::VectorXd residual = evaluate(displacement_m, &jacobian);
  const Eigen::Vector3d error_m = known.block.frame.EnuFromFrame(known.truth_m[4]) *
                                  (state.start_m[4] + displacement_m - known.truth_m[4]);
  const KnownPosition& position = known.block.points.known[0];
  std::vector<Eigen::Index> fixed;
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (position.fixed[static_cast<std::size_t>(k)]) fixed.push_back(k);
  }
  const Eigen::VectorXd e = error_m(fixed);
  const Eigen::MatrixXd q = position.covariance_enu_m2(fixed, fixed);
  ASSERT_EQ(static_cast<std::size_t>(cost.num_residuals()), fixed.size());
  // A lone height is that of the ellipsoid: 15 m aside on a sphere of 6.4e6 m are 2e-5 m.
  const double bound = fixed.size() == 1 ? 1e-3 : 1e-7;
  EXPECT_NEAR(residual.squaredNorm(), e.dot(dense::Cholesky(q).Solve(e)), bound);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = Eigen::Vector3d::Unit(k);
    const Eigen::VectorXd slope =
        0.5 * (evaluate(displacement_m + step, &unused) - evaluate(displacement_m - step, &unused));
    EXPECT_LT((slope - jacobian.col(k)).norm(), 1e-8);
  }
}

INSTANTIATE_TEST_SUITE_P(Components,
                         ControlCostTest,
                         testing::Values(ControlCase{{0.31, 0.47, 0.83}, 0.0},
                                         ControlCase{{0.31, 0.47, 0.83}, 0.61},
                                         ControlCase{{0.31, 0.47, kNotGiven}, -0.37},
                                         ControlCase{{kNotGiven, kNotGiven, 0.83}, 0.0},
                                         ControlCase{{0.31, kNotGiven, 0.83}, 0.0}));

TEST(PriorCostTest, DividesTheParametersThatHaveAPriorByIt) {
  const test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  PositionCorrection position;
  position.degree = 1;
  position.components = {true, false, true};
  position.prior_sigma_m[2] = {2.5, 0.8};
  const ParameterLayout layout = MakeParameterLayout(known.block, {{"p", position, {"A2"}, false}});
  const CostPointer made = PriorCostOf(layout, 0).cost;
  const ceres::CostFunction& cost = *made;
  ASSERT_EQ(cost.num_residuals(), 2);
  ASSERT_EQ(cost.parameter_block_sizes(), std::vector<int>{4});
  const std::array<double, 4> x{7.0, 8.0, 5.0, -1.2};
  const double* block = x.data();
  std::array<double, 2> residual{};
  std::array<double, 8> jacobian;
  jacobian.fill(99.0);
  double* out = jacobian.data();
  ASSERT_TRUE(cost.Evaluate(&block, residual.data(), &out));
  EXPECT_NEAR(residual[0], 2.0, 1e-15);
  EXPECT_NEAR(residual[1], -1.5, 1e-15);
  EXPECT_EQ(jacobian, (std::array<double, 8>{0.0, 0.0, 0.4, 0.0, 0.0, 0.0, 0.0, 1.25}));
}

TEST(CeresProblemTest, HoldsEveryLookControlAndPriorOnce) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  test::AddKnownPoint(0, {0.3, 0.3, kNotGiven}, &known);
  known.block.looks.flags[3] |= Looks::kRejected;
  PositionCorrection position;
  position.prior_sigma_m[0] = {4.0};
  AdjustmentProblem problem(known.block, {{"p", position, {}, false}});
  BlockState state;
  state.start_m = known.truth_m;
  state.displacement_m.assign(known.truth_m.size(), Eigen::Vector3d::Zero());
  state.corrections.setZero(problem.layout.size());
  UpdateWeights(state, &problem);
  const auto ceres_problem = MakeCeresProblem(problem, {}, &state);
  EXPECT_EQ(ceres_problem->NumResiduals(), 2 * 47 + 2 + 4);
  EXPECT_EQ(ceres_problem->NumParameters(), 3 * 12 + 12);
}

}  // namespace
}  // namespace sarblock
