// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"

#include <cmath>
#include <vector>

#include "normals/point.h"
#include "normals/reduced_system.h"
#include "quality/point_sweep.h"
#include "solve/rank.h"
#include "support/dense_normals.h"
#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

CorrectionGroup KnownPosition() {
  PositionCorrection position;
  position.degree = 1;
  position.prior_sigma_m.fill({2.9});
  return {"position", position, {}, false};
}

test::KnownBlock MakeFixed(const test::BlockPlan& plan) {
  test::KnownBlock known = test::MakeBlock(plan);
  test::AddKnownPoint(0, {0.31, 0.47, 0.83}, &known, PointRole::kControl, 0.57);
  test::AddKnownPoint(3, {0.53, 0.29, kNotGiven}, &known);
  test::AddKnownPoint(4, {kNotGiven, kNotGiven, 0.37}, &known);
  test::AddKnownPoint(7, {0.43, 0.61, 0.71}, &known);
  test::AddNoise(41, 1.0, &known);
  return known;
}

/// The linearised problem at true positions and nominal paths.
struct Linearised {
  explicit Linearised(test::KnownBlock* known_block)
      : known(*known_block), problem(known.block, {KnownPosition()}) {
    state.start_m = known.truth_m;
    state.displacement_m.assign(known.truth_m.size(), Eigen::Vector3d::Zero());
    state.corrections = Eigen::VectorXd::Zero(problem.layout.size());
    UpdateWeights(state, &problem);
  }
  test::KnownBlock& known;
  AdjustmentProblem problem;
  BlockState state;
};

/// How the whitened equations of a look answer to one sigma in its range (first column) and in its
/// time, by differences of the equations themselves: no rotation is assumed.
Eigen::Matrix2d AnswerToSigmas(Linearised* at, std::size_t point, std::uint64_t look) {
  Looks& looks = at->known.block.looks;
  const LookSigma sigma = at->known.block.SigmaOf(look);
  WhitenedLook evaluated;
  const auto error = [&] {
    EXPECT_TRUE(EvaluateWhitened(at->problem, at->state, {}, point, look, &evaluated));
    return evaluated.whitened_error;
  };
  Eigen::Matrix2d out;
  double& range_m = looks.range_m[look];
  const double step_m = 0.01 * sigma.range_m, r_m = range_m;
  range_m = r_m + step_m;
  Eigen::Vector2d up = error();
  range_m = r_m - step_m;
  out.col(0) = (up - error()) / 0.02;
  range_m = r_m;
  // The length of a second step does not matter for a direction; whitened it has length 1.
  double& time_s = looks.time_s[look];
  const double t_s = time_s, step_s = 1e-5;
  time_s = t_s + step_s;
  up = error();
  time_s = t_s - step_s;
  out.col(1) = (up - error()).normalized();
  time_s = t_s;
  return out;
}

/// Two routes: a dense covariance in extended precision and the differences above against the
/// elimination of the point, squinted or not, control full, correlated and partial.
void ExpectDense(const test::BlockPlan& plan) {
  test::KnownBlock known = MakeFixed(plan);
  Linearised at(&known);
  const test::DenseEquations dense = test::MakeDenseEquations(at.problem, at.state);
  const Eigen::MatrixXd c = test::DenseCovariance(dense.jacobian);
  const Eigen::MatrixXd q =
      Eigen::MatrixXd::Identity(dense.jacobian.rows(), dense.jacobian.rows()) -
      dense.jacobian * c * dense.jacobian.transpose();
  const Eigen::MatrixXd gain = c * dense.jacobian.transpose();
  ReducedSystem system(at.problem);
  system.Form(at.state, {}, nullptr);
  FactorRegular(&system);
  const CorrectionCovariance inverse = system.SelectedInverse();
  Eigen::Index row = 0;
  for (std::size_t point = 0; point < known.block.points.size(); ++point) {
    const PointResiduals residuals =
        PointLinearization(at.problem, at.state, &inverse).At(point).Residuals();
    const Eigen::Index m = residuals.size();
    Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(m, m);
    for (std::size_t k = 0; k < residuals.looks.size(); ++k) {
      const auto r = static_cast<Eigen::Index>(2 * k);
      turn.block<2, 2>(r, r) = AnswerToSigmas(&at, point, residuals.looks[k]);
    }
    EXPECT_LT((turn.transpose() * turn - Eigen::MatrixXd::Identity(m, m)).norm(), 1e-6);
    const Eigen::MatrixXd expected = turn.transpose() * q.block(row, row, m, m) * turn;
    const Eigen::VectorXd v = turn.transpose() * dense.residual.segment(row, m);
    const Eigen::MatrixXd shift = gain.block(dense.column_of_point[point], row, 3, m) * turn;
    for (Eigen::Index i = 0; i < m; ++i) {
      // Differences leave 1e-7; the sign of an error is that of the equation, not of the time.
      EXPECT_NEAR(residuals.q_vv(i, i), expected(i, i), 1e-6);
      EXPECT_NEAR(std::abs(residuals.v[i]), std::abs(v[i]), 1e-5);
      EXPECT_NEAR(residuals.shift_m.col(i).norm(), shift.col(i).norm(), 1e-5);
      for (Eigen::Index k = 0; k < m; ++k) {
        EXPECT_NEAR(std::abs(residuals.q_vv(i, k)), std::abs(expected(i, k)), 1e-6);
      }
    }
    row += m;
  }
}

TEST(ResidualCovarianceTest, IsThatOfTheDenseMatrices) { ExpectDense(test::AircraftPlan()); }
TEST(ResidualCovarianceTest, IsThatOfTheDenseMatricesUnderSquint) {
  ExpectDense(test::AircraftPlan(37.0));
}
TEST(ResidualCovarianceTest, IsThatOfTheDenseMatricesFromOrbit) {
  ExpectDense(test::OrbitPlan(13.0, true));
}

// Theory: four equations of three unknowns leave one direction of residuals; all tests of a tie
// point with two looks are one test.
TEST(ResidualCovarianceTest, TwoLooksHaveOneTest) {
  test::BlockPlan plan = test::AircraftPlan();
  plan.looks_per_point = 2;
  test::KnownBlock known = test::MakeBlock(plan);
  test::AddNoise(5, 1.0, &known);
  Linearised at(&known);
  ReducedSystem system(at.problem);
  system.Form(at.state, {}, nullptr);
  FactorRegular(&system);
  const CorrectionCovariance inverse = system.SelectedInverse();
  for (std::size_t point = 0; point < known.block.points.size(); ++point) {
    const PointResiduals residuals =
        PointLinearization(at.problem, at.state, &inverse).At(point).Residuals();
    ASSERT_EQ(residuals.size(), 4);
    for (Eigen::Index i = 1; i < 4; ++i) {
      ASSERT_GT(residuals.q_vv(i, i), 1e-9);
      EXPECT_NEAR(std::abs(residuals.Correlation(0, i)), 1.0, 1e-9);
    }
    EXPECT_LE(residuals.q_vv.trace(), 1.0 + 1e-12);
  }
}

}  // namespace
}  // namespace sarblock
