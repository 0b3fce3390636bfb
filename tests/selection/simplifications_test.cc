// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "adjust/adjust.h"
#include "selection/simplify.h"
#include "solve/reduced_engine.h"
#include "solve/start.h"
#include "support/small_blocks.h"
#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

const SimplificationBound& Find(const std::vector<SimplificationBound>& bounds,
                                const std::string& name) {
  return *std::find_if(
      bounds.begin(), bounds.end(), [&](const SimplificationBound& b) { return b.name == name; });
}

/// An adjustment problem and its solution.
struct Solved {
  Solved(const Block& block,
         const std::vector<CorrectionGroup>& groups,
         const Simplified& simplified = {})
      : problem(block, groups, simplified) {
    state = ComputeStartValues(&problem, nullptr).state;
    for (int round = 0; round < 3; ++round) {
      SolveOptions options;
      options.settle_below = 1e-9;
      static_cast<void>(SolveReduced(problem, {}, options, &state, nullptr));
      UpdateWeights(state, &problem);
    }
  }
  AdjustmentProblem problem;
  BlockState state;
};

/// Largest difference of positions over all points and directions, in standard deviations.
double LargestShift(const Block& block,
                    const std::vector<Eigen::Vector3d>& a_m,
                    const std::vector<Eigen::Vector3d>& b_m,
                    const std::vector<SymmetricEnu>& covariance_m2) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a_m.size(); ++i) {
    largest =
        std::max(largest, test::DistanceInSigmas(block.frame, a_m[i], b_m[i], covariance_m2[i]));
  }
  return largest;
}

std::vector<Eigen::Vector3d> PositionsOf(const BlockState& state) {
  std::vector<Eigen::Vector3d> out;
  for (std::size_t i = 0; i < state.start_m.size(); ++i) out.push_back(state.Position(i));
  return out;
}

/// Position corrections up to a degree, without priors; of degree 0 across and up alone.
std::vector<CorrectionGroup> Positions(int degree) {
  PositionCorrection position;
  position.degree = degree;
  position.components[0] = degree > 0;
  CorrectionGroup group;
  group.name = "position";
  group.model = position;
  return {group};
}

/// Orbits that are off by some metres, with control all round.
test::KnownBlock ShiftedOrbits() {
  test::BlockPlan plan = test::OrbitPlan();
  plan.points = 40;
  test::KnownBlock known = test::MakeBlock(plan);
  test::AddNoise(3, 1.0, &known);
  for (std::size_t point = 0; point < 12; ++point)
    test::AddKnownPoint(point, {0.3, 0.3, 0.3}, &known);
  test::ShiftPath(0, {4.1, -2.3, 3.7}, &known.block);
  test::ShiftPath(2, {-1.9, 5.3, 2.1}, &known.block);
  return known;
}

AdjustOptions Given(const std::vector<CorrectionGroup>& groups, double limit) {
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = groups;
  options.selection.simplify = limit;
  return options;
}

// Second route: all points solved again with straight flights. The bound holds for every point and
// direction, and it is not idle.
TEST(SimplificationsTest, StraightFlightsMoveNoPointBeyondTheirBound) {
  const test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  const Solved full(known.block, {});
  const SimplificationBound bound =
      Find(BoundSimplifications(full.problem, full.state, 0.01), "linear-velocity");
  const Solved straight(known.block, {}, {.linear_velocity = true});
  AdjustOptions options;
  options.covariance = CovarianceLevel::kIntersection;
  const AdjustResult fixed = IntersectBlock(known.block, options);
  const double largest = LargestShift(known.block,
                                      PositionsOf(full.state),
                                      PositionsOf(straight.state),
                                      fixed.points.covariance_m2);
  EXPECT_LE(largest, 1.02 * bound.fraction);  // first order
  EXPECT_GE(largest, 0.1 * bound.fraction);
  EXPECT_FALSE(bound.allowed);
  EXPECT_NEAR(bound.bound_m, bound.fraction * bound.sigma_m, 1e-9 * bound.bound_m);
}

// Closed form: height of a tangent plane at the distance d is d^2 / 2r.
TEST(SimplificationsTest, TheFlatFrameIsThatOfATangentPlane) {
  const test::KnownBlock known = test::MakeBlock(test::OrbitPlan());
  const Solved solved(known.block, {});
  const SimplificationBound bound =
      Find(BoundSimplifications(solved.problem, solved.state, 0.01), "flat-frame");
  AdjustOptions options;
  options.covariance = CovarianceLevel::kIntersection;
  const AdjustResult fixed = IntersectBlock(known.block, options);
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p_m : fixed.points.position_m) middle_m += p_m;
  middle_m /= static_cast<double>(fixed.points.position_m.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < fixed.points.position_m.size(); ++i) {
    const double d_m = (fixed.points.position_m[i] - middle_m).cross(middle_m.normalized()).norm();
    largest = std::max(
        largest, d_m * d_m / (2.0 * middle_m.norm()) / std::sqrt(fixed.points.covariance_m2[i][2]));
  }
  // The ellipsoid's normal and the radius differ by up to 0.2 degrees.
  EXPECT_NEAR(bound.fraction / largest, 1.0, 0.02);
}

// Exact: nothing to bound where looks are not squinted, paths not corrected, the frame flat.
TEST(SimplificationsTest, WhatIsNotThereCostsNothing) {
  const test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  const Solved solved(known.block, {});
  const auto bounds = BoundSimplifications(solved.problem, solved.state, 0.01);
  for (const char* name : {"flat-frame", "fixed-track-axes"}) {
    EXPECT_EQ(Find(bounds, name).fraction, 0.0) << name;
    EXPECT_TRUE(Find(bounds, name).allowed) << name;
  }
}

// Second route: the step to the full model is the difference of two adjustments, corrections
// estimated in both.
TEST(SimplificationsTest, TheShiftToTheFullModelIsTheDifferenceOfTwoAdjustments) {
  const test::KnownBlock known = ShiftedOrbits();
  const Solved full(known.block, Positions(1));
  const Solved fixed(known.block, Positions(1), {.fixed_track_axes = true});
  const AdjustResult result = Adjust(known.block, Given(Positions(1), 0.01));
  const double direct = LargestShift(
      known.block, PositionsOf(fixed.state), PositionsOf(full.state), result.points.covariance_m2);
  const double predicted =
      ShiftToFullModel(fixed.problem, fixed.state, result.points.covariance_m2);
  EXPECT_GT(direct, 1e-7);
  EXPECT_NEAR(predicted, direct, 0.01 * direct + 1e-7);
  // Without covariance: the length of the whole step, which is not smaller.
  EXPECT_GE(ShiftToFullModel(fixed.problem, fixed.state, {}), 0.99 * predicted);
}

TEST(SimplificationsTest, WhatIsTakenMovesNoPointByMoreThanTheLimit) {
  const test::KnownBlock known = ShiftedOrbits();
  const Solved solved(known.block, Positions(0));
  constexpr double kLimit = 0.3;
  SelectionReport report;
  report.simplifications = BoundSimplifications(solved.problem, solved.state, kLimit);
  const Simplified chosen =
      ChooseSimplified(solved.problem, solved.state, kLimit, &report.simplifications);
  ASSERT_TRUE(chosen.fixed_track_axes);
  EXPECT_FALSE(chosen.linear_velocity);  // orbits are not straight
  const AdjustOptions options = Given(Positions(0), kLimit);
  const AdjustResult simplified = AdjustSimplified(known.block, options, chosen, {}, &report);
  const AdjustResult full = Adjust(known.block, options);
  const double shift = LargestShift(
      known.block, full.points.position_m, simplified.points.position_m, full.points.covariance_m2);
  EXPECT_GT(shift, 0.0);
  EXPECT_LE(shift, kLimit);
  EXPECT_NEAR(report.simplified_shift, shift, 0.01 * shift + 1e-6);
  EXPECT_TRUE(report.simplified.fixed_track_axes);
  const SimplificationBound& bound = Find(report.simplifications, "fixed-track-axes");
  EXPECT_TRUE(bound.taken);
  EXPECT_EQ(bound.verdict, "taken");
  EXPECT_GT(bound.gain, 0.0);
  EXPECT_EQ(Find(report.simplifications, "linear-velocity").verdict, "not allowed");
}

TEST(SimplificationsTest, NothingAboveTheLimitIsTaken) {
  const test::KnownBlock known = ShiftedOrbits();
  const Solved solved(known.block, Positions(0));
  auto bounds = BoundSimplifications(solved.problem, solved.state, 1e-4);
  EXPECT_FALSE(ChooseSimplified(solved.problem, solved.state, 1e-4, &bounds).any());
  for (const char* name : {"flat-frame", "fixed-track-axes", "linear-velocity"}) {
    EXPECT_EQ(Find(bounds, name).verdict, "not allowed") << name;
  }
}

// Straight flights are far above the limit here: as if the choice had erred.
TEST(SimplificationsTest, WhatMovesAPointByMoreIsGivenUpAndTheFullModelAdjusted) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  for (std::size_t point = 0; point < 6; ++point)
    test::AddKnownPoint(point, {0.3, 0.3, 0.3}, &known);
  const AdjustOptions options = Given({}, 0.01);
  SelectionReport report;
  const Solved solved(known.block, {});
  report.simplifications = BoundSimplifications(solved.problem, solved.state, 0.01);
  for (SimplificationBound& bound : report.simplifications) {
    bound.taken = bound.name == "linear-velocity";
  }
  const AdjustResult result =
      AdjustSimplified(known.block, options, {.linear_velocity = true}, {}, &report);
  EXPECT_GT(report.simplified_shift, 0.01);
  EXPECT_FALSE(report.simplified.any());
  const SimplificationBound& bound = Find(report.simplifications, "linear-velocity");
  EXPECT_FALSE(bound.taken);
  EXPECT_THAT(bound.verdict, HasSubstr("given up"));
  const AdjustResult full = Adjust(known.block, options);
  ASSERT_EQ(result.points.position_m.size(), full.points.position_m.size());
  for (std::size_t i = 0; i < full.points.position_m.size(); ++i) {
    EXPECT_EQ(result.points.position_m[i], full.points.position_m[i]);
  }
}

// The program's own way: chosen corrections, then what can be spared, then the adjustment.
TEST(SimplificationsTest, AnAutomaticAdjustmentSaysWhatItTook) {
  const test::KnownBlock known = ShiftedOrbits();
  AdjustOptions options;
  options.corrections = CorrectionChoice::kAuto;
  options.selection.simplify = 0.3;
  options.groups = Positions(0);
  std::get<PositionCorrection>(options.groups[0].model).prior_sigma_m.fill({10.0});
  const AdjustResult result = Adjust(known.block, options);
  ASSERT_TRUE(result.usable());
  ASSERT_EQ(result.selection.simplifications.size(), 3U);
  ASSERT_TRUE(result.selection.simplified.fixed_track_axes);
  EXPECT_LE(result.selection.simplified_shift, 0.3);
  const AdjustResult full = Adjust(known.block, Given(result.selection.groups, 0.3));
  EXPECT_NEAR(
      LargestShift(
          known.block, full.points.position_m, result.points.position_m, full.points.covariance_m2),
      result.selection.simplified_shift,
      0.01 * result.selection.simplified_shift + 1e-6);
}

}  // namespace
}  // namespace sarblock
