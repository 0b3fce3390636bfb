// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

AdjustOptions SomeCorrections() {
  PositionCorrection position;
  position.degree = 1;
  position.prior_sigma_m.fill({3.1});
  RangeCorrection range;
  range.bias = true;
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}, {"radar", range, {}, true}};
  options.pairs = PairChoice::kList;
  return options;
}

const PointPairs kPairs = {{1, 6}, {9, 2}};

test::KnownBlock PlannedBlock(bool orbit) {
  test::KnownBlock known = test::MakeBlock(orbit ? test::OrbitPlan() : test::AircraftPlan());
  test::AddKnownPoint(0, {0.31, 0.47, 0.83}, &known, PointRole::kControl, 0.4);
  test::AddKnownPoint(4, {0.53, 0.29, kNotGiven}, &known);
  test::AddKnownPoint(7, {kNotGiven, kNotGiven, 0.37}, &known);
  return known;
}

double Size(const SymmetricEnu& c) { return c[0] + c[1] + c[2]; }

void ExpectSameCovariances(const AdjustResult& a, const AdjustResult& b) {
  ASSERT_EQ(a.points.covariance_m2.size(), b.points.covariance_m2.size());
  for (std::size_t j = 0; j < a.points.covariance_m2.size(); ++j) {
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_NEAR(a.points.covariance_m2[j][k],
                  b.points.covariance_m2[j][k],
                  1e-9 * Size(b.points.covariance_m2[j]));
    }
  }
  ASSERT_EQ(a.parameters.size(), b.parameters.size());
  for (std::size_t i = 0; i < a.parameters.size(); ++i) {
    EXPECT_NEAR(a.parameters[i].sigma, b.parameters[i].sigma, 1e-9 * b.parameters[i].sigma);
  }
  ASSERT_EQ(a.pairs.size(), 2U);
  ASSERT_EQ(b.pairs.size(), 2U);
  for (std::size_t q = 0; q < 2; ++q) {
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_NEAR(a.pairs[q].covariance_m2[k],
                  b.pairs[q].covariance_m2[k],
                  1e-9 * Size(b.pairs[q].covariance_m2));
    }
  }
}

class PredictTest : public testing::TestWithParam<bool> {};

// Two routes: on noise-free data the adjustment ends where the prediction stands.
TEST_P(PredictTest, IsTheCovarianceOfAnAdjustmentWithoutNoise) {
  const test::KnownBlock known = PlannedBlock(GetParam());
  const AdjustResult adjusted = Adjust(known.block, SomeCorrections(), kPairs);
  const AdjustResult predicted = Predict(known.block, SomeCorrections(), known.truth_m, kPairs);
  ASSERT_TRUE(adjusted.usable());
  EXPECT_EQ(predicted.status, AdjustStatus::kPredicted);
  EXPECT_EQ(predicted.points.status[3], PointStatus::kPredicted);
  EXPECT_TRUE(std::isnan(predicted.sigma0_squared));
  EXPECT_EQ(predicted.redundancy(), adjusted.redundancy());
  ExpectSameCovariances(predicted, adjusted);
}

// Round trip: times and ranges taken away come back from the geometry.
TEST_P(PredictTest, FillsMeasurementsThatAreMissing) {
  const test::KnownBlock known = PlannedBlock(GetParam());
  test::KnownBlock plan = known;
  for (std::size_t i = 0; i < plan.block.looks.size(); ++i) {
    plan.block.looks.range_m[i] = kNotGiven;
    if (i % 2 == 0) plan.block.looks.time_s[i] = kNotGiven;
  }
  const Block filled = FillMeasurements(plan.block, known.truth_m);
  for (std::size_t i = 0; i < filled.looks.size(); ++i) {
    // e_d below 1e-7 m at 173 m/s or more.
    EXPECT_NEAR(filled.looks.time_s[i], known.block.looks.time_s[i], 1e-9);
    EXPECT_NEAR(filled.looks.range_m[i], known.block.looks.range_m[i], 2e-9);
    EXPECT_FALSE(filled.looks.rejected(i));
  }
  ExpectSameCovariances(Predict(plan.block, SomeCorrections(), known.truth_m, kPairs),
                        Predict(known.block, SomeCorrections(), known.truth_m, kPairs));
}

// Every pass sees every point here, so no looks at all means the same looks.
TEST_P(PredictTest, TakesAllVisibleLooksWhereTheBlockHasNone) {
  const test::KnownBlock known = PlannedBlock(GetParam());
  Block plan = known.block;
  plan.looks = {};
  plan.looks.offsets.assign(plan.points.size() + 1, 0);
  ExpectSameCovariances(Predict(plan, SomeCorrections(), known.truth_m, kPairs),
                        Predict(known.block, SomeCorrections(), known.truth_m, kPairs));
  // A pass that looks to the other side sees nothing.
  plan.passes[1].side = plan.passes[1].side == LookSide::kLeft ? LookSide::kRight : LookSide::kLeft;
  const Block filled = FillMeasurements(plan, known.truth_m);
  EXPECT_EQ(filled.looks.size(), known.block.looks.size() - plan.points.size());
  for (const std::uint32_t pass : filled.looks.pass) EXPECT_NE(pass, 1U);
}

// A prediction is of the geometry and the weights: ranges that are a kilometre off show nowhere.
TEST_P(PredictTest, HasNoTestsOfWhatWasMeasured) {
  test::KnownBlock known = PlannedBlock(GetParam());
  const AdjustResult clean = Predict(known.block, SomeCorrections(), known.truth_m, kPairs);
  for (double& range_m : known.block.looks.range_m) range_m += 1e3;
  const AdjustResult predicted = Predict(known.block, SomeCorrections(), known.truth_m, kPairs);
  for (const AdjustResult* result : {&clean, &predicted}) {
    for (std::size_t k = 0; k < 2; ++k) {
      ASSERT_EQ(result->quality.w[k].size(), known.block.looks.size());
      for (const float w : result->quality.w[k]) EXPECT_TRUE(std::isnan(w));
      EXPECT_EQ(result->assessment.tests.looks_above[k], 0U);
    }
    EXPECT_FALSE(result->control_quality.empty());
    for (const ControlQuality& control : result->control_quality) {
      EXPECT_TRUE(std::isnan(control.w));
      EXPECT_GT(control.redundancy, 0.0);
    }
    EXPECT_EQ(result->assessment.tests.control_above, 0U);
    for (const PassShare& share : result->assessment.shares) {
      EXPECT_TRUE(std::isnan(share.square_sum));
      EXPECT_GT(share.redundancy, 0.0);
    }
  }
  EXPECT_EQ(predicted.assessment.tests.figures.tests, clean.assessment.tests.figures.tests);
  EXPECT_EQ(clean.assessment.tests.figures.tests, 2U * known.block.looks.size() + 6U);
}

// Second route: the least checked observation of each kind by all of their own figures.
TEST_P(PredictTest, NamesWhatOthersHardlyCheck) {
  const test::KnownBlock known = PlannedBlock(GetParam());
  const AdjustResult result = Predict(known.block, SomeCorrections(), known.truth_m, kPairs);
  const QualitySummary& summary = result.assessment.tests;
  const double delta0 = summary.figures.delta0;
  const CheckedObservations& control = summary.checked[2];
  EXPECT_EQ(control.count, 3U + 2U + 1U);  // components fixed
  std::size_t hardly = 0;
  double farthest_m = 0.0;
  for (const ControlQuality& of : result.control_quality) {
    hardly += of.redundancy < 0.1 ? 1U : 0U;
    farthest_m = std::max(farthest_m, delta0 * of.shift_m / std::sqrt(of.redundancy));
  }
  EXPECT_EQ(control.hardly, hardly);
  EXPECT_NEAR(control.shift_m, farthest_m, 1e-6 * farthest_m);
  const double sigma_m = std::sqrt(
      known.block.points.FindKnown(control.point)->covariance_enu_m2(control.part, control.part));
  EXPECT_NEAR(control.blunder_m, delta0 * sigma_m / std::sqrt(control.redundancy), 1e-9);
  for (std::size_t k = 0; k < 2; ++k) {
    const CheckedObservations& looks = summary.checked[k];
    const std::vector<float>& redundancy = result.quality.redundancy[k];
    EXPECT_EQ(looks.count, redundancy.size());
    EXPECT_EQ(
        static_cast<std::ptrdiff_t>(looks.hardly),
        std::count_if(redundancy.begin(), redundancy.end(), [](float r) { return r < 0.1F; }));
    farthest_m = 0.0;
    for (std::size_t i = 0; i < redundancy.size(); ++i) {
      const double r = static_cast<double>(redundancy[i]);
      ASSERT_GT(r, 1e-6);  // four looks of a point, three from orbit, check each other
      const double shift_m = static_cast<double>(result.quality.shift_m[k][i]);
      farthest_m = std::max(farthest_m, delta0 * shift_m / std::sqrt(r));
    }
    EXPECT_NEAR(looks.shift_m, farthest_m, 1e-6 * farthest_m);
  }
}

INSTANTIATE_TEST_SUITE_P(AircraftAndOrbit, PredictTest, testing::Bool());

TEST(PredictReportTest, LeavesOutWhatItCannotPlace) {
  const test::KnownBlock known = PlannedBlock(false);
  std::vector<Eigen::Vector3d> places_m = known.truth_m;
  places_m[5].setConstant(kNotGiven);
  Block plan = known.block;
  for (double& time_s : plan.looks.time_s) time_s = kNotGiven;
  for (double& range_m : plan.looks.range_m) range_m = kNotGiven;
  const AdjustResult result = Predict(plan, SomeCorrections(), places_m, {});
  EXPECT_EQ(result.points.status[5], PointStatus::kUndetermined);
  EXPECT_FALSE(result.points.reason[5].empty());
  EXPECT_EQ(result.points.status[6], PointStatus::kPredicted);
  // With its measurements the point is intersected from them.
  const AdjustResult measured = Predict(known.block, SomeCorrections(), places_m, {});
  EXPECT_EQ(measured.points.status[5], PointStatus::kPredicted);
  EXPECT_LT((measured.points.position_m[5] - known.truth_m[5]).norm(), 1e-6);
}

}  // namespace
}  // namespace sarblock
