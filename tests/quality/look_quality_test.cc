// SPDX-License-Identifier: Apache-2.0
// The quality figures of a result, by routes that share nothing with how they are computed.
#include "sarblock/adjust/adjust.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "normals/reduced_system.h"
#include "quality/assess.h"
#include "quality/point_sweep.h"
#include "solve/rank.h"
#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

AdjustOptions Corrected() {
  PositionCorrection position;
  position.degree = 1;
  position.prior_sigma_m.fill({2.9});
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  return options;
}

test::KnownBlock Held(const test::BlockPlan& plan) {
  test::KnownBlock known = test::MakeBlock(plan);
  test::AddKnownPoint(0, {0.31, 0.47, 0.83}, &known, PointRole::kControl, 0.57);
  test::AddKnownPoint(3, {0.53, 0.29, kNotGiven}, &known);
  test::AddKnownPoint(7, {0.43, 0.61, 0.71}, &known);
  test::AddNoise(41, 1.0, &known);
  return known;
}

/// How fast a zero-Doppler cone error moves with the time of a look.
double AzimuthRate_mps(const Block& block, std::uint64_t look, const Eigen::Vector3d& p_m) {
  const auto motion = block.passes[block.looks.pass[look]].path.At(block.looks.time_s[look]);
  return std::abs(
      LookTimeRates(
          p_m, motion->position_m, motion->velocity_mps, motion->acceleration_mps2, Cone{})
          .doppler_mps);
}

/// Definition: an error of one sigma in a measurement changes its own residual by r sigmas and the
/// point by `shift_m`; the rest of the adjustment is done anew, by the solver. Nonlinearity and the
/// floats of the figures leave 1e-4, one sigma of azimuth in time from the nominal path's speed
/// instead of the corrected one's, metres in ten thousand, 1e-3.
void ExpectTheAnswerOfTheSolver(const test::BlockPlan& plan, bool azimuth) {
  test::KnownBlock known = Held(plan);
  Block& block = known.block;
  const AdjustResult before = Adjust(block, Corrected());
  ASSERT_TRUE(before.usable());
  const std::size_t k = azimuth ? 1 : 0;
  const double tolerance = azimuth ? 1e-3 : 1e-4;
  for (const std::size_t point : {0U, 3U, 5U}) {
    const std::uint64_t look = block.looks.offsets[point] + 1;
    double& measured = azimuth ? block.looks.time_s[look] : block.looks.range_m[look];
    const double kept = measured;
    const LookSigma sigma = block.SigmaOf(look);
    double step = sigma.range_m;
    if (azimuth) {
      const double rate_mps = AzimuthRate_mps(block, look, before.points.position_m[point]);
      const bool seconds = sigma.azimuth_unit == AzimuthUnit::kSeconds;
      step = seconds ? sigma.azimuth : sigma.azimuth / rate_mps;
      EXPECT_NEAR(
          AzimuthSigma_m(block, look, before.points.position_m[point]), step * rate_mps, 1e-12);
    }
    measured = kept + step;
    const AdjustResult after = Adjust(block, Corrected());
    measured = kept;
    const auto v = [&](const AdjustResult& result) {
      return static_cast<double>(result.quality.w[k][look]) *
             std::sqrt(static_cast<double>(result.quality.redundancy[k][look]));
    };
    const auto r = static_cast<double>(before.quality.redundancy[k][look]);
    const auto shift_m = static_cast<double>(before.quality.shift_m[k][look]);
    EXPECT_NEAR(std::abs(v(after) - v(before)), r, tolerance) << point;
    EXPECT_NEAR((after.points.position_m[point] - before.points.position_m[point]).norm(),
                shift_m,
                tolerance * std::max(1.0, shift_m))
        << point;
  }
}

TEST(LookQualityTest, ARangeErrorShowsByItsRedundancy) {
  ExpectTheAnswerOfTheSolver(test::AircraftPlan(), false);
  ExpectTheAnswerOfTheSolver(test::AircraftPlan(31.0), false);
  ExpectTheAnswerOfTheSolver(test::OrbitPlan(), false);
}

TEST(LookQualityTest, AnAzimuthErrorShowsByItsRedundancy) {
  ExpectTheAnswerOfTheSolver(test::AircraftPlan(), true);
  ExpectTheAnswerOfTheSolver(test::OrbitPlan(), true);
}

// Two routes: the sweep over all points against the whole covariance of one point's residuals. The
// second has been compared with dense matrices (residual_covariance_test.cc).
TEST(LookQualityTest, TheSweepIsTheDiagonalOfTheResidualCovariance) {
  for (const double squint_deg : {0.0, 37.0}) {
    test::KnownBlock known = Held(test::AircraftPlan(squint_deg));
    AdjustmentProblem problem(known.block, Corrected().groups);
    BlockState state;
    state.start_m = known.truth_m;
    state.displacement_m.assign(known.truth_m.size(), Eigen::Vector3d::Zero());
    state.corrections = Eigen::VectorXd::Zero(problem.layout.size());
    UpdateWeights(state, &problem);
    ReducedSystem system(problem);
    system.Form(state, {}, nullptr);
    FactorRegular(&system);
    const CorrectionCovariance inverse = system.SelectedInverse();
    const PointSweep sweep = SweepPoints(problem, state, &inverse, true, nullptr);
    for (std::size_t point = 0; point < known.block.points.size(); ++point) {
      const PointResiduals at = PointLinearization(problem, state, &inverse).At(point).Residuals();
      for (std::size_t i = 0; i < 2 * at.looks.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        const std::uint64_t look = at.looks[i / 2];
        // floats
        EXPECT_NEAR(
            static_cast<double>(sweep.quality.redundancy[i % 2][look]), at.q_vv(row, row), 1e-6);
        EXPECT_NEAR(static_cast<double>(sweep.quality.w[i % 2][look]),
                    at.w(row),
                    1e-4 * (1.0 + std::abs(at.w(row))));
        EXPECT_NEAR(static_cast<double>(sweep.quality.shift_m[i % 2][look]),
                    at.shift_m.col(row).norm(),
                    1e-5);
      }
    }
  }
}

// Theory: all redundancy numbers together, those of looks, control and priors, are the redundancy.
// With the priors' own, 1 - sigma^2 / prior^2, nothing is missing.
TEST(LookQualityTest, RedundancyNumbersAddToTheRedundancy) {
  const test::KnownBlock known = Held(test::AircraftPlan(17.0));
  const AdjustResult result = Adjust(known.block, Corrected());
  double sum = 0.0;
  for (const double r : result.points.redundancy) sum += r;
  for (const ControlQuality& control : result.control_quality) sum += control.redundancy;
  for (const ParameterResult& p : result.parameters) {
    sum += 1.0 - p.sigma * p.sigma / (p.prior_sigma * p.prior_sigma);
  }
  EXPECT_NEAR(sum, result.redundancy(), 1e-4);  // floats
}

// Theory: all tests of a tie point with two looks are one (docs/theory/quality.md).
TEST(LookQualityTest, TwoLooksHaveEqualTests) {
  test::BlockPlan plan = test::AircraftPlan();
  plan.points = 20;
  plan.looks_per_point = 2;
  const test::KnownBlock known = Held(plan);
  const AdjustResult result = Adjust(known.block, Corrected());
  const std::uint64_t first = known.block.looks.offsets[10];
  const auto w = [&](std::size_t k, std::uint64_t look) {
    return std::abs(static_cast<double>(result.quality.w[k][look]));
  };
  EXPECT_GT(w(1, first), 1e-3);
  EXPECT_NEAR(w(1, first), w(1, first + 1), 1e-4);
  EXPECT_NEAR(w(0, first), w(1, first), 1e-3);
  EXPECT_NEAR(w(0, first + 1), w(1, first), 1e-3);
  EXPECT_LT(result.points.redundancy[10], 1.0);
}

}  // namespace
}  // namespace sarblock
