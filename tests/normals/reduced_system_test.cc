// SPDX-License-Identifier: Apache-2.0
#include "normals/reduced_system.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "linear/dense.h"
#include "normals/back.h"
#include "solve/rank.h"
#include "support/dense_normals.h"
#include "support/small_blocks.h"
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

CorrectionGroup Position(int degree,
                         double sigma_m,
                         PositionCorrection::Axes axes = PositionCorrection::Axes::kTrack) {
  PositionCorrection position;
  position.degree = degree;
  position.axes = axes;
  if (sigma_m > 0.0) position.prior_sigma_m.fill({sigma_m});
  return {"position", position, {}, false};
}

BlockState StateOf(const test::KnownBlock& known, AdjustmentProblem* problem, double offset_m) {
  BlockState state;
  state.start_m = known.truth_m;
  state.displacement_m.assign(known.truth_m.size(), offset_m * Eigen::Vector3d(1.0, -0.7, 0.4));
  state.corrections.setConstant(problem->layout.size(), 0.21 * offset_m);
  UpdateWeights(state, problem);
  return state;
}

/// S of all equations at once: what the columns of the points leave of those of the corrections, by
/// an orthogonal factorisation.
Eigen::MatrixXd SchurComplementOf(const test::DenseEquations& dense) {
  const Eigen::MatrixXd& j = dense.jacobian;
  const Eigen::Index p = dense.first_correction;
  const Eigen::MatrixXd q = dense::Orthogonal(j.leftCols(p)).Q(j.rows());
  const Eigen::MatrixXd below = q.rightCols(j.rows() - p).transpose() * j.rightCols(j.cols() - p);
  return below.transpose() * below;
}

class ReducedSystemTest : public testing::TestWithParam<bool> {
 protected:
  ReducedSystemTest()
      : known_(test::MakeBlock(GetParam() ? test::OrbitPlan(13.1) : test::AircraftPlan(7.9))) {
    test::AddKnownPoint(1, {0.31, 0.47, kNotGiven}, &known_);
    test::AddKnownPoint(5, {0.31, 0.47, 0.59}, &known_);
    test::AddKnownPoint(8, {0.41, 0.57, 0.29}, &known_);
    RangeCorrection range;
    range.bias = true;
    range.bias_prior_sigma_m = 1.9;
    problem_.emplace(known_.block,
                     std::vector<CorrectionGroup>{Position(1, 2.7), {"radar", range, {}, true}});
    state_ = StateOf(known_, &*problem_, 1.7);
    system_.emplace(*problem_);
    system_->Form(state_, {}, nullptr);
    condition_ = FactorRegular(&*system_).condition;
    dense_ = test::MakeDenseEquations(*problem_, state_);
  }
  test::KnownBlock known_;
  std::optional<AdjustmentProblem> problem_;
  BlockState state_;
  std::optional<ReducedSystem> system_;
  double condition_ = 0.0;
  test::DenseEquations dense_;
};

// Second route: S of the dense normal matrix, undone by the factor: S^-1 S_dense = I.
TEST_P(ReducedSystemTest, IsTheSchurComplementOfTheDenseNormals) {
  const Eigen::MatrixXd s = SchurComplementOf(dense_);
  const Eigen::Index n = s.rows();
  const Eigen::VectorXd unit = s.diagonal().cwiseSqrt();
  const Eigen::MatrixXd product =
      unit.asDiagonal() * system_->SolveFor(s) * unit.cwiseInverse().asDiagonal();
  EXPECT_LT((product - Eigen::MatrixXd::Identity(n, n)).norm(), 1e-15 * 50.0 * condition_);
  // The selected inverse holds the same blocks (the pattern is full here: all see all).
  const Eigen::MatrixXd inverse = system_->SelectedInverse().blocks.ToDense();
  EXPECT_LT((unit.asDiagonal() * inverse * s * unit.cwiseInverse().asDiagonal() -
             Eigen::MatrixXd::Identity(n, n))
                .norm(),
            1e-15 * 50.0 * condition_);
}

// Second route: the Newton step of all unknowns by a dense least-squares solution.
TEST_P(ReducedSystemTest, GivesTheDenseNewtonStep) {
  const Eigen::MatrixXd& j = dense_.jacobian;
  const Eigen::VectorXd length = j.colwise().norm();
  const Eigen::MatrixXd scaled = j * length.cwiseInverse().asDiagonal();
  const Eigen::VectorXd step = -(length.cwiseInverse().asDiagonal() *
                                 dense::PivotedOrthogonal(scaled).Solve(dense_.residual).col(0));
  const Eigen::VectorXd expected = step.tail(problem_->layout.size());
  const Eigen::VectorXd difference = system_->Step() - expected;
  EXPECT_GT(expected.norm(), 0.01);
  EXPECT_LT(difference.norm(), 1e-9 * expected.norm());
  // Length of the step in sigmas: |J step|. Cost: half the square sum. Gradient by columns.
  EXPECT_NEAR(system_->NewtonDecrement(), (j * step).norm(), 1e-9 * (j * step).norm());
  EXPECT_NEAR(
      system_->cost(), 0.5 * dense_.residual.squaredNorm(), 1e-12 * dense_.residual.squaredNorm());
  const Eigen::VectorXd g = (j.transpose() * dense_.residual).cwiseQuotient(length);
  EXPECT_NEAR(system_->gradient(), g.cwiseAbs().maxCoeff(), 1e-10 * g.norm());
  EXPECT_TRUE(system_->weak_points().empty());
  EXPECT_EQ(system_->looks_not_evaluated(), 0);
}

/// J'e of all unknowns at a state with one of them moved.
Eigen::VectorXd GradientAt(const AdjustmentProblem& problem,
                           BlockState state,
                           const test::DenseEquations& dense,
                           Eigen::Index unknown,
                           double by) {
  if (unknown >= dense.first_correction) {
    state.corrections[unknown - dense.first_correction] += by;
  } else {
    for (std::size_t point = 0; point < dense.column_of_point.size(); ++point) {
      const int first = dense.column_of_point[point];
      if (first < 0 || unknown < first || unknown >= first + 3) continue;
      state.displacement_m[point][unknown - first] += by;
    }
  }
  const test::DenseEquations there = test::MakeDenseEquations(problem, state);
  return there.jacobian.transpose() * there.residual;
}

/// Newton's step of the corrections by second derivatives of the cost, differences of the dense
/// gradient.
Eigen::VectorXd StepOfDifferences(const AdjustmentProblem& problem,
                                  const BlockState& state,
                                  const test::DenseEquations& dense) {
  const Eigen::Index n = dense.jacobian.cols();
  Eigen::MatrixXd hessian(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double by = 0.03;  // m; of a drift m at the ends of the strip
    hessian.col(k) =
        (GradientAt(problem, state, dense, k, by) - GradientAt(problem, state, dense, k, -by)) /
        (2.0 * by);
  }
  const Eigen::VectorXd gradient = dense.jacobian.transpose() * dense.residual;
  return -hessian.fullPivLu().solve(gradient).tail(problem.layout.size());
}

// Second route: second derivatives by differences of the dense gradient.
TEST_P(ReducedSystemTest, GivesTheStepOfSecondDerivatives) {
  const Eigen::VectorXd expected = StepOfDifferences(*problem_, state_, dense_);
  const Eigen::VectorXd gauss_newton = system_->Step();
  for (const double damping : {0.0, 1e-14}) {
    ReducedSystem curved(*problem_);
    curved.Form(state_, {.curved = true}, nullptr, damping);
    ASSERT_TRUE(curved.FactorDamped());
    const double left = (curved.Step() - expected).norm();
    // Left out: in the geocentric frame heights of control curve as ranges of orbits do.
    const double left_out = GetParam() ? 0.25 : 0.02;
    EXPECT_LT(left, left_out * (gauss_newton - expected).norm()) << damping;
  }
}

// The same second route. Corrections that accelerate the antenna turn the cone, and by that move
// the crossing of points: a second derivative as large as the others where a polynomial is of
// second degree.
TEST(SecondDerivativesTest, CountTheAccelerationOfCorrections) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan(7.9));
  test::AddKnownPoint(1, {0.31, 0.47, 0.39}, &known);
  test::AddKnownPoint(5, {0.31, 0.47, 0.59}, &known);
  test::AddKnownPoint(8, {0.41, 0.57, 0.29}, &known);
  AdjustmentProblem problem(known.block, {Position(3, 2.7)});
  const BlockState state = StateOf(known, &problem, 1.7);
  const Eigen::VectorXd expected =
      StepOfDifferences(problem, state, test::MakeDenseEquations(problem, state));
  ReducedSystem plain(problem), curved(problem);
  plain.Form(state, {}, nullptr);
  curved.Form(state, {.curved = true}, nullptr);
  ASSERT_TRUE(plain.FactorDamped());
  ASSERT_TRUE(curved.FactorDamped());
  const double left = (curved.Step() - expected).norm();
  EXPECT_LT(left, 0.02 * (plain.Step() - expected).norm()) << left;
}

// Second route: what is left of all equations after a step of some ten metres, and the dense
// least-squares solution of that with the Jacobian from before the step.
TEST(BendOfStepTest, GivesTheDenseStepAgainstWhatAStepLeaves) {
  for (const bool orbits : {false, true}) {
    SCOPED_TRACE(orbits);
    test::KnownBlock known =
        test::MakeBlock(orbits ? test::OrbitPlan(13.1) : test::AircraftPlan(7.9));
    test::AddKnownPoint(1, {0.31, 0.47, 0.39}, &known);
    test::AddKnownPoint(5, {0.31, 0.47, 0.59}, &known);
    test::AddKnownPoint(8, {0.41, 0.57, 0.29}, &known);
    AdjustmentProblem problem(known.block, {Position(3, 20.7)});
    const BlockState state = StateOf(known, &problem, 1.7);
    ReducedSystem system(problem);
    system.Form(state, {}, nullptr);
    ASSERT_TRUE(system.FactorDamped());
    const Eigen::VectorXd dx =
        Eigen::VectorXd::LinSpaced(problem.layout.size(), -30.0, 45.0) + system.Step();
    BlockState after = state;
    after.displacement_m = SubstituteBack(problem, state, {}, 0.0, dx).displacement_m;
    after.corrections += dx;
    const test::DenseEquations here = test::MakeDenseEquations(problem, state);
    const test::DenseEquations there = test::MakeDenseEquations(problem, after);
    Eigen::VectorXd step(here.jacobian.cols());
    step.tail(dx.size()) = dx;
    for (std::size_t point = 0; point < here.column_of_point.size(); ++point) {
      step.segment<3>(here.column_of_point[point]) =
          after.displacement_m[point] - state.displacement_m[point];
    }
    const Eigen::VectorXd left = there.residual - here.residual - here.jacobian * step;
    const Eigen::VectorXd length = here.jacobian.colwise().norm();
    const Eigen::MatrixXd scaled = here.jacobian * length.cwiseInverse().asDiagonal();
    const Eigen::VectorXd expected =
        -(length.cwiseInverse().asDiagonal() * dense::PivotedOrthogonal(scaled).Solve(left).col(0))
             .eval()
             .tail(dx.size());
    const Eigen::VectorXd bend = -system.SolveFor(BendOfStep(problem, state, {}, 0.0, dx));
    EXPECT_GT(expected.norm(), 1e-3 * dx.norm());
    EXPECT_LT((bend - expected).norm(), 1e-8 * expected.norm());
    // Along the step itself, by the dense residuals: points take their part first.
    const Eigen::MatrixXd of_points = here.jacobian.leftCols(here.jacobian.cols() - dx.size());
    const Eigen::VectorXd kept =
        left - of_points * dense::PivotedOrthogonal(of_points).Solve(left).col(0);
    const double along = (here.jacobian.rightCols(dx.size()) * dx).dot(kept);
    std::vector<SampledPoint> all;
    for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
      if (problem.Solves(point)) all.push_back({point, 1.0});
    }
    EXPECT_NEAR(BendsAlongSteps(problem, state, dx, all)[0], along, 1e-8 * std::abs(along));
  }
}

// Definition: ratio of the extreme eigenvalues of S scaled to unit diagonal; the estimate comes
// from inside the spectrum.
TEST_P(ReducedSystemTest, EstimatesTheConditionOfTheScaledMatrix) {
  const Eigen::Index n = problem_->layout.size();
  const Eigen::MatrixXd s = system_->SolveFor(Eigen::MatrixXd::Identity(n, n)).inverse();
  const Eigen::VectorXd unit = s.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::VectorXd values =
      dense::SymmetricEigenvalues(unit.asDiagonal() * s * unit.asDiagonal());
  const double condition = values.maxCoeff() / values.minCoeff();
  EXPECT_LE(condition_, condition * 1.0001);
  EXPECT_GE(condition_, condition * 0.9);
}

INSTANTIATE_TEST_SUITE_P(AircraftAndOrbit, ReducedSystemTest, testing::Bool());

std::vector<std::string> NamesOfRefusal(AdjustmentProblem* problem, const BlockState& state) {
  ReducedSystem system(*problem);
  system.Form(state, {}, nullptr);
  try {
    FactorRegular(&system);
  } catch (const UndeterminedError& error) {
    EXPECT_THAT(error.what(), HasSubstr("; removed by "));
    return error.names();
  }
  return {};
}

// Second route: a dense QR. One pass is a thousand times as precise as the others, so that points
// take all but a millionth of what its equations say of its corrections; a difference of the two
// would leave ten digits of its part of S.
TEST(ReducedSystemDigitsTest, KeepsWhatPointsNearlyTake) {
  const test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  AdjustmentProblem problem(known.block, {Position(1, 0.0)});
  problem.model.ScaleSigmas({{1e-3, 1e-3}, {1.0, 1.0}, {1.0, 1.0}, {1.0, 1.0}});
  const BlockState state = StateOf(known, &problem, 0.3);
  ReducedSystem system(problem);
  system.Form(state, {}, nullptr);
  const test::DenseEquations dense = test::MakeDenseEquations(problem, state);
  const Eigen::MatrixXd expected = SchurComplementOf(dense);
  const Eigen::VectorXd full =
      dense.jacobian.rightCols(problem.layout.size()).colwise().squaredNorm();
  EXPECT_LT(expected(0, 0), 1e-5 * full[0]);
  const Eigen::VectorXd unit = expected.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd error = system.matrix().ToDense() - expected;
  EXPECT_LT((unit.asDiagonal() * error * unit.asDiagonal()).cwiseAbs().maxCoeff(), 1e-11);
}

// Known null space: without control and priors the block may be shifted as a whole; constants of
// all passes and all axes take part.
TEST(ReducedSystemRefusalTest, NamesThePositionsOfABlockThatFloats) {
  const test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  AdjustmentProblem problem(known.block, {Position(0, 0.0, PositionCorrection::Axes::kFrame)});
  const BlockState state = StateOf(known, &problem, 0.3);
  const std::vector<std::string> names = NamesOfRefusal(&problem, state);
  ASSERT_FALSE(names.empty());
  // A shift moves the same axis of all four passes by the same amount.
  for (const std::string& name : names) {
    EXPECT_THAT(name, HasSubstr(" position."));
    const std::string axis = name.substr(name.find(' '));
    for (const char* pass : {"A1", "A2", "A3", "A4"}) {
      EXPECT_THAT(names, Contains(pass + axis));
    }
  }
}

// Known null space: a point held in height only stops up, never the horizontal shift.
TEST(ReducedSystemRefusalTest, NamesOnlyWhatMovesWhenHeightsAreHeld) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  for (std::size_t j = 0; j < 12; ++j) test::AddKnownPoint(j, {kNotGiven, kNotGiven, 0.2}, &known);
  AdjustmentProblem problem(known.block, {Position(0, 0.0, PositionCorrection::Axes::kFrame)});
  const BlockState state = StateOf(known, &problem, 0.0);
  const std::vector<std::string> names = NamesOfRefusal(&problem, state);
  ASSERT_FALSE(names.empty());
  for (const std::string& name : names) EXPECT_EQ(name.find("position.z"), std::string::npos);
}

TEST(ReducedSystemRefusalTest, NamesAParameterThatNoLookSees) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  for (std::size_t j = 0; j < 12; ++j) test::AddKnownPoint(j, {0.2, 0.3, 0.4}, &known);
  for (std::size_t i = 0; i < known.block.looks.size(); ++i) {
    if (known.block.looks.pass[i] == 2) known.block.looks.flags[i] |= Looks::kRejected;
  }
  RangeCorrection range;
  range.bias = true;
  AdjustmentProblem problem(known.block, {{"range", range, {}, false}});
  const BlockState state = StateOf(known, &problem, 0.0);
  EXPECT_THAT(NamesOfRefusal(&problem, state), ElementsAre("A3 range.bias"));
}

// Closed form: along shifts and a time bias of a straight pass are the same thing.
TEST(ReducedSystemRefusalTest, NamesAlongAndTimeThatAreTheSame) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  for (std::size_t j = 0; j < 12; ++j) test::AddKnownPoint(j, {0.2, 0.3, 0.4}, &known);
  Pass& pass = known.block.passes[0];
  std::vector<StateVector> straight = pass.path.states();
  const Eigen::Vector3d v_mps(173.0, 4.7, 0.0);
  for (StateVector& state : straight) {
    state.position_m = Eigen::Vector3d(20100.0, -18100.0, 9150.0) + v_mps * (state.time_s - 391.7);
    state.velocity_mps = v_mps;
  }
  pass.path = FlightPath(straight);
  PositionCorrection along;
  along.components = {true, false, false};
  AdjustmentProblem problem(
      known.block, {{"position", along, {"A1"}, false}, {"time", TimeCorrection{}, {"A1"}, false}});
  const BlockState state = StateOf(known, &problem, 0.0);
  std::vector<std::string> names = NamesOfRefusal(&problem, state);
  std::sort(names.begin(), names.end());
  EXPECT_THAT(names, ElementsAre("A1 position.along.0", "A1 time.bias"));
}

// Zero base: two looks from one path have the same circle, nothing holds the point on it.
TEST(ReducedSystemWeakPointTest, ListsAPointOfZeroBase) {
  test::BlockPlan plan = test::AircraftPlan();
  plan.passes = {plan.passes[0], plan.passes[0], plan.passes[2]};
  test::KnownBlock known = test::MakeBlock(plan);
  // Point 3 loses its third look, point 7 keeps one look and a full control.
  const auto look = [](std::size_t point, std::size_t pass) { return 3 * point + pass; };
  known.block.looks.flags[look(3, 2)] |= Looks::kRejected;
  test::AddKnownPoint(7, {0.3, 0.3, 0.3}, &known);
  known.block.looks.flags[look(7, 0)] |= Looks::kRejected;
  known.block.looks.flags[look(7, 1)] |= Looks::kRejected;
  AdjustmentProblem problem(known.block, {});
  const BlockState state = StateOf(known, &problem, 0.2);
  ReducedSystem system(problem);
  system.Form(state, {}, nullptr);
  ASSERT_EQ(system.weak_points().size(), 1U);
  EXPECT_EQ(system.weak_points()[0].point, 3U);
  EXPECT_LT(system.weak_points()[0].reciprocal_condition, kMinPointCondition);
}

}  // namespace
}  // namespace sarblock
