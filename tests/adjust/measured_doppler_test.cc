// SPDX-License-Identifier: Apache-2.0
// Looks whose Doppler is the measurement, at exact times (docs/theory/observations.md). Evidence:
// closed forms of their equations, two engines, invariance and seeded statistics.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/model/result.h"

#include <cmath>
#include <vector>

#include "linear/dense.h"
#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// Four squinted passes of an aircraft whose Dopplers are known to some hertz.
test::KnownBlock DopplerBlock(double squint_deg) {
  test::BlockPlan plan = test::AircraftPlan(squint_deg, true);
  plan.sigma = {0.7, 1.9, AzimuthUnit::kHertz};
  return test::MakeBlock(plan);
}

/// All looks of a pass at one time, as in an image in polar format: Dopplers and ranges then.
void GiveOneTime(test::KnownBlock* known) {
  Block& block = known->block;
  for (std::size_t j = 0; j < block.points.size(); ++j) {
    for (std::size_t i = block.looks.offsets[j]; i < block.looks.offsets[j + 1]; ++i) {
      const Pass& pass = block.passes[block.looks.pass[i]];
      const double time_s = 0.5 * (pass.start_s + pass.end_s);
      const Motion motion = *pass.path.At(time_s);
      const Eigen::Vector3d d_m = known->truth_m[j] - motion.position_m;
      block.looks.time_s[i] = time_s;
      block.looks.range_m[i] = d_m.norm();
      block.looks.cone[i] = 2.0 * motion.velocity_mps.dot(d_m) / (d_m.norm() * pass.wavelength_m);
    }
  }
}

/// Rows of a point with the path held: (|d| - R)/sigma_R and (2 v.d/(lambda |d|) - f)/sigma_f, and
/// their gradients by hand.
struct Rows {
  Eigen::VectorXd error;
  Eigen::Matrix<double, Eigen::Dynamic, 3> d_point;
};
Rows RowsOf(const Block& block, std::size_t point, const Eigen::Vector3d& p_m) {
  const std::size_t begin = block.looks.offsets[point], end = block.looks.offsets[point + 1];
  const auto count = 2 * static_cast<Eigen::Index>(end - begin);
  Rows out{Eigen::VectorXd(count), Eigen::Matrix<double, Eigen::Dynamic, 3>(count, 3)};
  for (std::size_t i = begin; i < end; ++i) {
    const Pass& pass = block.passes[block.looks.pass[i]];
    const Motion motion = *pass.path.At(block.looks.time_s[i]);
    const Eigen::Vector3d d = p_m - motion.position_m, v = motion.velocity_mps;
    const double rho = d.norm(), per_m = 2.0 / (pass.wavelength_m * rho);
    const LookSigma sigma = block.SigmaOf(i);
    const Eigen::Index row = 2 * static_cast<Eigen::Index>(i - begin);
    out.error[row] = (rho - block.looks.range_m[i]) / sigma.range_m;
    out.d_point.row(row) = d.transpose() / rho / sigma.range_m;
    out.error[row + 1] = (per_m * v.dot(d) - block.looks.cone[i]) / sigma.azimuth;
    out.d_point.row(row + 1) =
        per_m * (v - (v.dot(d) / (rho * rho)) * d).transpose() / sigma.azimuth;
  }
  return out;
}

struct Solved {
  Eigen::Vector3d position_m;
  Eigen::Matrix3d covariance_m2;
  double square = 0.0;
};
Solved SolvePoint(const Block& block, std::size_t point, Eigen::Vector3d p_m) {
  Solved out;
  for (int iteration = 0; iteration < 15; ++iteration) {
    const Rows rows = RowsOf(block, point, p_m);
    out.covariance_m2 = dense::Cholesky(rows.d_point.transpose() * rows.d_point).Inverse();
    p_m -= out.covariance_m2 * (rows.d_point.transpose() * rows.error);
    out.square = rows.error.squaredNorm();
  }
  out.position_m = p_m;
  return out;
}

class MeasuredDopplerTest : public testing::TestWithParam<double> {};

// Closed forms of both equations, solved densely point by point: 1e-9 in the covariance, and a
// square sum that is theirs. Half a metre of noise.
TEST_P(MeasuredDopplerTest, AnswersTheClosedFormsOfRangeAndDoppler) {
  for (const bool one_time : {false, true}) {
    SCOPED_TRACE(one_time ? "one time a pass" : "one squint a pass");
    test::KnownBlock known = DopplerBlock(GetParam());
    if (one_time) GiveOneTime(&known);
    test::AddNoise(31, 1.0, &known);
    const AdjustResult adjusted = Adjust(known.block, {});
    ASSERT_TRUE(adjusted.usable());
    double square = 0.0;
    for (std::size_t j = 0; j < known.truth_m.size(); ++j) {
      const Solved solved = SolvePoint(known.block, j, known.truth_m[j]);
      square += solved.square;
      EXPECT_LT((solved.position_m - adjusted.points.position_m[j]).norm(), 1e-6) << j;
      const Eigen::Matrix3d off = MatrixOf(adjusted.points.covariance_m2[j]) - solved.covariance_m2;
      EXPECT_LT(off.norm(), 1e-9 * solved.covariance_m2.norm()) << j;
    }
    EXPECT_NEAR(adjusted.sigma0_squared * adjusted.redundancy(), square, 1e-6 * square);
  }
}

// Another route to the same: the intersection of geometry, whose weights take the measured range.
TEST_P(MeasuredDopplerTest, IntersectsWithTheSameCovariance) {
  test::KnownBlock known = DopplerBlock(GetParam());
  const AdjustResult met = IntersectBlock(known.block, {});
  for (std::size_t j = 0; j < known.truth_m.size(); ++j) {
    const Solved solved = SolvePoint(known.block, j, known.truth_m[j]);
    EXPECT_LT((solved.position_m - met.points.position_m[j]).norm(), 1e-6) << j;
    const Eigen::Matrix3d off = MatrixOf(met.points.covariance_m2[j]) - solved.covariance_m2;
    EXPECT_LT(off.norm(), 1e-9 * solved.covariance_m2.norm()) << j;
  }
}

// Residuals are given in metres at the target: rho lambda/(2 |v|) times those of the Doppler.
TEST_P(MeasuredDopplerTest, GivesAzimuthResidualsInMetres) {
  test::KnownBlock known = DopplerBlock(GetParam());
  test::AddNoise(7, 1.0, &known);
  const Block& block = known.block;
  const AdjustResult adjusted = Adjust(block, {});
  for (std::size_t j = 0; j < known.truth_m.size(); ++j) {
    const Eigen::Vector3d& p_m = adjusted.points.position_m[j];
    const Rows rows = RowsOf(block, j, p_m);
    for (std::size_t i = block.looks.offsets[j]; i < block.looks.offsets[j + 1]; ++i) {
      const Pass& pass = block.passes[block.looks.pass[i]];
      const Motion motion = *pass.path.At(block.looks.time_s[i]);
      const double unit_m =
          0.5 * pass.wavelength_m * (p_m - motion.position_m).norm() / motion.velocity_mps.norm();
      const auto row = 2 * static_cast<Eigen::Index>(i - block.looks.offsets[j]) + 1;
      EXPECT_NEAR(adjusted.looks.azimuth_residual_m[i], rows.error[row] * 1.9 * unit_m, 1e-6);
      EXPECT_NEAR(
          block.ApproximateAzimuthSigma_m(i, motion.velocity_mps.norm()), 1.9 * unit_m, 1e-2);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Squints, MeasuredDopplerTest, testing::Values(0.0, 20.0, -41.0));

/// Looks of both kinds, all corrections that act on them otherwise than on times, and control.
struct MixedBlock {
  test::KnownBlock known = DopplerBlock(20.0);
  AdjustOptions options;
  MixedBlock() {
    known.block.passes[1].sigma = {0.7, 1.1, AzimuthUnit::kMetres};
    test::AddKnownPoint(0, {0.31, 0.47, 0.83}, &known, PointRole::kControl, 0.4);
    test::AddKnownPoint(4, {0.53, 0.29, 0.4}, &known);
    test::AddKnownPoint(7, {0.5, 0.4, 0.37}, &known);
    test::AddNoise(5, 1.0, &known);
    PositionCorrection position;
    position.degree = 1;
    position.prior_sigma_m.fill({3.1});
    TimeCorrection time;
    time.bias_prior_sigma_s = 0.01;
    SquintCorrection squint;
    squint.bias_prior_sigma_rad = 1e-3;
    options.corrections = CorrectionChoice::kGiven;
    options.groups = {{"position", position, {}, false},
                      {"time", time, {}, false},
                      {"squint", squint, {}, false}};
  }
};

TEST(MixedLooksTest, BothEnginesAnswerTheSame) {  // two routes
  MixedBlock mixed;
  const AdjustResult reduced = Adjust(mixed.known.block, mixed.options);
  mixed.options.engine = Engine::kCeres;
  mixed.options.covariance_method = CovarianceMethod::kCeres;
  const AdjustResult ceres = Adjust(mixed.known.block, mixed.options);
  ASSERT_TRUE(reduced.usable() && ceres.usable());
  for (std::size_t j = 0; j < mixed.known.truth_m.size(); ++j) {
    const Eigen::Matrix3d a = MatrixOf(reduced.points.covariance_m2[j]);
    EXPECT_LT((reduced.points.position_m[j] - ceres.points.position_m[j]).norm(), 1e-5) << j;
    EXPECT_LT((a - MatrixOf(ceres.points.covariance_m2[j])).norm(), 1e-6 * a.norm()) << j;
  }
}

// The covariance depends on the geometry: that of a solution without noise is what is predicted
// from the points.
TEST(MixedLooksTest, ArePredictedAsTheyAreAdjusted) {
  MixedBlock mixed;
  mixed.known = DopplerBlock(20.0);
  mixed.known.block.passes[1].sigma = {0.7, 1.1, AzimuthUnit::kMetres};
  test::AddKnownPoint(0, {0.31, 0.47, 0.83}, &mixed.known);
  test::AddKnownPoint(4, {0.53, 0.29, 0.4}, &mixed.known);
  const Block& block = mixed.known.block;
  const AdjustResult adjusted = Adjust(block, mixed.options);
  Block plan = block;
  for (std::size_t i = 0; i < plan.looks.size(); ++i) {
    plan.looks.range_m[i] = kNotGiven;
    if (i % 2 == 0) plan.looks.time_s[i] = kNotGiven;
  }
  const AdjustResult predicted = Predict(plan, mixed.options, mixed.known.truth_m);
  for (std::size_t j = 0; j < mixed.known.truth_m.size(); ++j) {
    const Eigen::Matrix3d a = MatrixOf(adjusted.points.covariance_m2[j]);
    EXPECT_LT((a - MatrixOf(predicted.points.covariance_m2[j])).norm(), 1e-7 * a.norm()) << j;
  }
}

// A pass clock that is late moves the exact times of its looks: the bias of the time finds it.
TEST(MixedLooksTest, ATimeBiasMovesExactTimes) {
  MixedBlock mixed;
  mixed.known = DopplerBlock(20.0);
  Block& block = mixed.known.block;
  for (std::size_t j = 0; j < 6; ++j) test::AddKnownPoint(j, {0.01, 0.01, 0.01}, &mixed.known);
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (block.looks.pass[i] == 2) block.looks.time_s[i] -= 0.0173;
  }
  TimeCorrection time;
  mixed.options.groups = {{"time", time, {"A3"}, false}};
  const AdjustResult adjusted = Adjust(block, mixed.options);
  ASSERT_EQ(adjusted.parameters.size(), 1U);
  EXPECT_NEAR(adjusted.parameters[0].value, 0.0173, 1e-8);
}

// A mounting error turns the cone: Dopplers of a pass belong to a smaller squint than its
// antenna's.
TEST(MixedLooksTest, ASquintBiasTurnsTheConeOfMeasuredDopplers) {
  MixedBlock mixed;
  mixed.known = DopplerBlock(20.0);
  Block& block = mixed.known.block;
  for (std::size_t j = 0; j < 6; ++j) test::AddKnownPoint(j, {0.01, 0.01, 0.01}, &mixed.known);
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (block.looks.pass[i] != 1) continue;
    const double speed_mps = block.passes[1].path.At(block.looks.time_s[i])->velocity_mps.norm();
    const double hz = 2.0 * speed_mps / block.passes[1].wavelength_m;
    block.looks.cone[i] = hz * std::sin(std::asin(block.looks.cone[i] / hz) - 2.3e-4);
  }
  SquintCorrection squint;
  mixed.options.groups = {{"squint", squint, {"A2"}, false}};
  const AdjustResult adjusted = Adjust(block, mixed.options);
  ASSERT_EQ(adjusted.parameters.size(), 1U);
  EXPECT_NEAR(adjusted.parameters[0].value, 2.3e-4, 1e-9);
}

// Exchanged points in passes of one time, on paths that are off by hundreds of metres: what their
// looks agree on is found by ranges and Dopplers, which distinguish the points of a pass.
TEST(MixedLooksTest, PassesOfOneTimeAgreeDespiteExchangedPoints) {
  test::BlockPlan plan = test::AircraftPlan(20.0, true);
  plan.sigma = {0.7, 1.9, AzimuthUnit::kHertz};
  plan.points = 90;
  test::KnownBlock known = test::MakeBlock(plan);
  GiveOneTime(&known);
  for (const std::size_t j : {0U, 30U, 60U, 88U}) test::AddKnownPoint(j, {0.3, 0.3, 0.3}, &known);
  test::AddNoise(12, 1.0, &known);
  test::ShiftPath(1, {310.0, -270.0, 190.0}, &known.block);
  test::ShiftPath(2, {-230.0, 340.0, -160.0}, &known.block);
  Looks& looks = known.block.looks;
  for (std::size_t j = 3; j < 85; j += 4) {  // in the first pass, each with its neighbour
    const std::size_t a = looks.offsets[j], b = looks.offsets[j + 1];
    std::swap(looks.range_m[a], looks.range_m[b]);
    std::swap(looks.cone[a], looks.cone[b]);
  }
  PositionCorrection position;
  position.degree = 0;
  position.prior_sigma_m.fill({400.0});
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  const AdjustResult adjusted = Adjust(known.block, options);
  EXPECT_TRUE(adjusted.usable());
  std::size_t solved = 0;
  for (std::size_t j = 0; j < known.truth_m.size(); ++j) {
    if (!IsSolved(adjusted.points.status[j])) continue;
    const double off = test::DistanceInSigmas(known.block.frame,
                                              adjusted.points.position_m[j],
                                              known.truth_m[j],
                                              adjusted.points.covariance_m2[j]);
    EXPECT_LT(off, 5.0) << j;
    ++solved;
  }
  EXPECT_GE(solved, 85U);
}

// The search for blunders names a Doppler, whose minimal detectable blunder is in metres too.
TEST(MixedLooksTest, ABlunderInADopplerIsFound) {
  MixedBlock mixed;
  Block& block = mixed.known.block;
  const std::size_t wrong = block.looks.offsets[9] + 2;
  block.looks.cone[wrong] += 25.0 * block.SigmaOf(wrong).azimuth;
  mixed.options.quality.snooping = Snooping::kIterative;
  const AdjustResult adjusted = Adjust(block, mixed.options);
  ASSERT_TRUE(adjusted.snooping && !adjusted.snooping->findings.empty());
  const BlunderFinding& first = adjusted.snooping->findings.front();
  EXPECT_TRUE(first.azimuth);
  ASSERT_EQ(first.looks.size(), 1U);
  EXPECT_EQ(first.looks[0], wrong);
}

}  // namespace
}  // namespace sarblock
