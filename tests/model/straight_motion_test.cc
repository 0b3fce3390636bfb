// SPDX-License-Identifier: Apache-2.0
// The short way of straight paths against the general one, and the step of the points after a step
// of the corrections against its definition, on every kind of path.
#include "model/straight_motion.h"

#include "sarblock/core/random.h"

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "normals/back_substitution.h"
#include "normals/elimination.h"
#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

struct Scenario {
  test::KnownBlock known;
  std::vector<CorrectionGroup> groups;
};

struct Case {
  std::string name;
  std::function<Scenario()> make;
  std::size_t straight = 0;  ///< passes that the short way applies to
};
std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }

CorrectionGroup Position(int degree, std::vector<std::string> passes = {}) {
  PositionCorrection position;
  position.degree = degree;
  return {"position", position, std::move(passes), false};
}

CorrectionGroup Range(bool shared) {
  RangeCorrection range;
  range.bias = range.scale = true;
  return {shared ? "radar" : "range", range, {}, shared};
}

Scenario Make(test::BlockPlan plan, bool straight, std::vector<CorrectionGroup> groups) {
  for (test::PassPlan& pass : plan.passes) pass.straight = straight;
  Scenario s{test::MakeBlock(plan), std::move(groups)};
  test::Hold(0, {0.31, 0.47, 0.83}, &s.known, PointRole::kControl, 0.57);
  test::Hold(3, {0.53, 0.29, kNotGiven}, &s.known);
  test::Hold(4, {kNotGiven, kNotGiven, 0.37}, &s.known);
  return s;
}

/// Constant and drift here, a constant of two components there, nothing on the last pass.
Scenario Mixed() {
  PositionCorrection constant;
  constant.degree = 0;
  constant.axes = PositionCorrection::Axes::kFrame;
  constant.components = {true, false, true};
  CorrectionGroup second{"constant", constant, {"A3"}, false};
  return Make(
      test::AircraftPlan(), true, {Position(1, {"A1", "A2"}), second, Range(false), Range(true)});
}

Scenario OneSwings() {
  test::BlockPlan plan = test::AircraftPlan();
  for (std::size_t i = 1; i < plan.passes.size(); ++i) plan.passes[i].straight = true;
  Scenario s{test::MakeBlock(plan), {Position(1), Range(false)}};
  return s;
}

Scenario Spline() {
  PositionCorrection spline;
  spline.basis = PositionCorrection::Basis::kSpline;
  spline.knot_spacing_s = 12.7;
  return Make(test::AircraftPlan(), true, {{"position", spline, {"A1"}, false}, Range(true)});
}

Scenario Timed() {
  return Make(test::AircraftPlan(),
              true,
              {Position(1), {"time", TimeCorrection{}, {"A2"}, false}, Range(false)});
}

std::vector<Case> Cases() {
  const auto aircraft = [](double squint_deg, bool doppler) {
    return [squint_deg, doppler] {
      return Make(test::AircraftPlan(squint_deg, doppler), true, {Position(1), Range(false)});
    };
  };
  const auto usual = [](double squint_deg, bool doppler) {
    return [squint_deg, doppler] {
      return Make(test::AircraftPlan(squint_deg, doppler), true, {Position(1)});
    };
  };
  return {{"usual", usual(0.0, false), 4},
          {"usual_squint", usual(20.0, false), 4},
          {"usual_doppler", usual(7.0, true), 4},
          {"straight", aircraft(0.0, false), 4},
          {"straight_squint", aircraft(20.0, false), 4},
          {"straight_doppler", aircraft(7.0, true), 4},
          {"mixed_and_shared", Mixed, 4},
          {"one_swings", OneSwings, 3},
          {"spline", Spline, 3},
          {"time_bias", Timed, 3},
          {"orbit",
           [] {
             return Make(test::OrbitPlan(), false, {Position(1), Range(true)});
           },
           0}};
}

class StraightMotionTest : public testing::TestWithParam<Case> {
 protected:
  StraightMotionTest()
      : scenario_(GetParam().make()), problem_(scenario_.known.block, scenario_.groups) {
    state_.start_m = scenario_.known.truth_m;
    RandomStream random(4711, 5);
    const auto draw = [&random](double size) { return size * (2.0 * random.Uniform() - 1.0); };
    for (std::size_t j = 0; j < state_.start_m.size(); ++j) {
      state_.displacement_m.emplace_back(draw(3.7), draw(2.9), draw(4.3));
    }
    state_.corrections.resize(problem_.layout.size());
    dx_.resize(problem_.layout.size());
    for (int i = 0; i < problem_.layout.size(); ++i) {
      const Parameter& parameter = problem_.layout.parameters[static_cast<std::size_t>(i)];
      const double size = parameter.name == "range.scale" ? 3.1e-5
                          : parameter.unit == "s"         ? 0.013
                                                          : 2.7;
      state_.corrections[i] = draw(size);
      dx_[i] = draw(size);
    }
    UpdateWhitening(state_, &problem_);
  }
  Scenario scenario_;
  AdjustmentProblem problem_;
  BlockState state_;
  Eigen::VectorXd dx_;
};

// Second route: LookModel::Evaluate, which finds the path anew for every look.
TEST_P(StraightMotionTest, LooksAreThoseOfTheLookModel) {
  const StraightMotions motions(problem_.model, state_.corrections);
  const std::vector<StraightStep> steps = motions.StepsFor(dx_);
  std::size_t straight = 0;
  for (std::size_t pass = 0; pass < problem_.block.passes.size(); ++pass) {
    if (motions.Apply(pass)) ++straight;
  }
  EXPECT_EQ(straight, GetParam().straight);
  const Looks& looks = problem_.block.looks;
  for (std::size_t j = 0; j < problem_.block.points.size(); ++j) {
    for (std::size_t i = looks.offsets[j]; i < looks.offsets[j + 1]; ++i) {
      if (!motions.Apply(looks.pass[i])) continue;
      WhitenedLook expected, at;
      ASSERT_TRUE(EvaluateWhitened(problem_, state_, {}, j, i, &expected));
      ASSERT_TRUE(EvaluateWhitened(problem_, state_, {}, j, i, &at, &motions));
      // Distances of 1e4 m, rounded to 2e-12 m.
      EXPECT_LT((at.error_m - expected.error_m).norm(), 2e-11);
      EXPECT_LT((at.error_1 - expected.error_1).norm(), 1e-10);
      EXPECT_LT((at.by_point - expected.by_point).norm(), 1e-14 * expected.by_point.norm());
      ASSERT_EQ(at.columns.column_count, expected.columns.column_count);
      Eigen::Vector2d along_1 = Eigen::Vector2d::Zero();
      std::size_t column = 0;
      for (int b = 0; b < at.columns.block_count; ++b) {
        const ParameterBlock& block =
            problem_.layout
                .blocks[static_cast<std::size_t>(at.columns.block[static_cast<std::size_t>(b)])];
        for (int c = 0; c < block.size; ++c, ++column) {
          for (std::size_t row = 0; row < 2; ++row) {
            const double value = expected.row[row][column];
            EXPECT_NEAR(at.row[row][column], value, 1e-13 * std::max(1.0, std::abs(value)));
            along_1[static_cast<Eigen::Index>(row)] += value * dx_[block.offset + c];
          }
        }
      }
      // J_c dx as it is defined: the sum over the columns.
      Eigen::Vector2d error_m, direct_1;
      Eigen::Matrix<double, 2, 3> by_point;
      ASSERT_TRUE(motions.EvaluateAlong(i,
                                        state_.start_m[j],
                                        state_.displacement_m[j],
                                        steps[looks.pass[i]],
                                        problem_.whitening[i],
                                        &error_m,
                                        &by_point,
                                        &direct_1));
      EXPECT_LT((direct_1 - along_1).norm(), 1e-12 * std::max(1.0, along_1.norm()));
      EXPECT_EQ(error_m, at.error_m);
      EXPECT_EQ(by_point, at.by_point);
    }
  }
}

// Second route: the least squares step of every point by its own QR factors, all partials formed.
TEST_P(StraightMotionTest, PointsFollowAStepAsTheirFactorsSay) {
  Weighting huber{RobustLoss::kHuber, 1.345, false}, bent = huber;
  bent.second_order = true;
  for (const Weighting& weighting : {Weighting{}, huber, bent}) {
    for (const double damping_1 : {0.0, 3.1e-4, 2.3}) {
      const PointSteps steps = SubstituteBack(problem_, state_, weighting, damping_1, dx_);
      double promised_1 = 0.0;
      for (std::size_t j = 0; j < problem_.block.points.size(); ++j) {
        PointFactor factor;
        FactorPoint(problem_, state_, weighting, damping_1, j, &factor);
        for (int k = 0; k < factor.look_count; ++k) {
          const WhitenedLook& look = factor.looks[static_cast<std::size_t>(k)];
          Eigen::VectorXd local(look.columns.column_count);
          GatherColumns(problem_.layout, look.columns, dx_, local.data());
          for (std::size_t row = 0; row < 2; ++row) {
            const Eigen::Map<const Eigen::VectorXd> j_c(look.row[row].data(), local.size());
            factor.e[2 * static_cast<std::size_t>(k) + row] += j_c.dot(local);
          }
        }
        const Eigen::Vector3d step_m =
            -factor.r.triangularView<Eigen::Upper>().solve(Project(factor, factor.e));
        const Eigen::Vector3d taken_m = steps.displacement_m[j] - state_.displacement_m[j];
        EXPECT_LT((taken_m - step_m).norm(), 1e-10 * (1.0 + step_m.norm())) << j;
        promised_1 += 0.5 * (-factor.gradient.dot(step_m) +
                             damping_1 * step_m.cwiseAbs2().dot(factor.square_1));
      }
      EXPECT_NEAR(steps.promised_1, promised_1, 1e-9 * (1.0 + std::abs(promised_1)));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Paths,
                         StraightMotionTest,
                         testing::ValuesIn(Cases()),
                         [](const testing::TestParamInfo<Case>& tested) {
                           return tested.param.name;
                         });

// Hand count: a look outside its path has no value, and its point goes by the others.
TEST(StraightMotionDomainTest, ALookOutsideThePathIsLeftOut) {
  Scenario s = Make(test::AircraftPlan(), true, {Position(1)});
  Looks& looks = s.known.block.looks;
  looks.time_s[looks.offsets[5]] = 1e6;
  const AdjustmentProblem all(s.known.block, s.groups);
  AdjustmentProblem without(s.known.block, s.groups);
  without.look_used[looks.offsets[5]] = 0;
  BlockState state;
  state.start_m = s.known.truth_m;
  state.displacement_m.assign(state.start_m.size(), {1.7, -2.3, 0.9});
  state.corrections.setConstant(all.layout.size(), 0.13);
  UpdateWhitening(state, &without);
  AdjustmentProblem same(s.known.block, s.groups);
  same.whitening = without.whitening;
  same.model.adjusted_times() = without.model.adjusted_times();
  const Eigen::VectorXd dx = Eigen::VectorXd::Constant(all.layout.size(), 0.31);
  EXPECT_EQ(SubstituteBack(same, state, {}, 0.0, dx).displacement_m[5],
            SubstituteBack(without, state, {}, 0.0, dx).displacement_m[5]);
}

}  // namespace
}  // namespace sarblock
