// SPDX-License-Identifier: Apache-2.0
// The ordinary adjustment code in the geometry of Leberl (1979).
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/leberl/formulas.h"

#include <array>
#include <cmath>

#include "support/paper_block.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

struct Swath {
  double base_m, height_m, near_m, far_m, range_sigma_m;
};
constexpr std::array<Swath, 2> kSwaths = {
    {{8e3, 10e3, 13e3, 25e3, 10.0}, {40e3, 375e3, 365e3, 425e3, 100.0}}};
constexpr int kSteps = 24;

std::vector<Eigen::Vector3d> AcrossTheSwath(const Swath& swath) {
  std::vector<Eigen::Vector3d> points_m;
  for (int k = 0; k <= kSteps; ++k) {
    points_m.emplace_back(
        731.7 * k - 9000.0, swath.near_m + (swath.far_m - swath.near_m) * k / kSteps, 0.0);
  }
  return points_m;
}

// Two routes: closed form against the covariance of the result. z = 0, positions fixed.
void ExpectEq25(const Swath& swath,
                const std::vector<Eigen::Vector3d>& points_m,
                const AdjustResult& result) {
  ASSERT_EQ(result.points.covariance_m2.size(), points_m.size());
  for (std::size_t j = 0; j < points_m.size(); ++j) {
    const leberl::RangeNoise noise = leberl::NoiseOfRange(
        {.base_m = swath.base_m, .height_m = swath.height_m, .ground_range_m = points_m[j].y()},
        swath.range_sigma_m);
    const SymmetricEnu& c = result.points.covariance_m2[j];
    EXPECT_NEAR(std::sqrt(c[1]), noise.sigma_y_m, 1e-9 * noise.sigma_y_m) << points_m[j].y();
    EXPECT_NEAR(std::sqrt(c[2]), noise.sigma_z_m, 1e-9 * noise.sigma_z_m) << points_m[j].y();
  }
}

Block SwathBlock(const Swath& swath, const std::vector<Eigen::Vector3d>& points_m) {
  return test::MakePaperBlock({{0.0, swath.height_m, swath.range_sigma_m},
                               {swath.base_m, swath.height_m, swath.range_sigma_m}},
                              points_m);
}

TEST(PaperGeometryTest, IntersectionOfABlockHasTheSigmasOfEq25AcrossBothSwaths) {
  for (const Swath& swath : kSwaths) {
    const auto points_m = AcrossTheSwath(swath);
    AdjustOptions options;
    options.covariance = CovarianceLevel::kIntersection;
    ExpectEq25(swath, points_m, IntersectBlock(SwathBlock(swath, points_m), options));
  }
}

TEST(PaperGeometryTest, AdjustmentWithFixedPathsHasTheSigmasOfEq25AcrossBothSwaths) {
  for (const Swath& swath : kSwaths) {
    const auto points_m = AcrossTheSwath(swath);
    for (const CovarianceLevel level : {CovarianceLevel::kIntersection, CovarianceLevel::kBlock}) {
      AdjustOptions options;
      options.covariance = level;
      const AdjustResult result = Adjust(SwathBlock(swath, points_m), options);
      ASSERT_TRUE(result.usable());
      ExpectEq25(swath, points_m, result);
    }
  }
}

TEST(PaperGeometryTest, PredictionWithoutMeasuredValuesHasTheSigmasOfEq25) {
  const Swath& swath = kSwaths[0];
  const auto points_m = AcrossTheSwath(swath);
  Block block = SwathBlock(swath, points_m);
  block.looks.time_s.assign(block.looks.size(), kNotGiven);
  block.looks.range_m.assign(block.looks.size(), kNotGiven);
  ExpectEq25(swath, points_m, Predict(block, {}, points_m));
}

// The paper's own number, two digits: "1.9 km" for sigma_r = 100 m in the middle of the model.
TEST(PaperGeometryTest, VoirHasSigmasOf1Point9Kilometres) {
  const AdjustResult result = IntersectBlock(SwathBlock(kSwaths[1], {{37.3, 395e3, 0.0}}), {});
  const SymmetricEnu& c = result.points.covariance_m2[0];
  EXPECT_NEAR(std::sqrt(c[1]), 1.9e3, 50.0);
  EXPECT_NEAR(std::sqrt(c[2]), 1.9e3, 50.0);
}

// Leberl (1979), Fig. 5: forward and backward from one line, the circles coincide.
TEST(PaperGeometryTest, SingleFlightIsRefusedWithItsReasonWhateverTheSquints) {
  for (const auto& [forward_deg, backward_deg] :
       {std::array{15.0, -15.0}, std::array{31.0, -7.0}, std::array{23.0, 4.0}}) {
    const Block block = test::MakePaperBlock(
        {{0.0, 10e3, 1.0, forward_deg * kRadPerDeg}, {0.0, 10e3, 1.0, backward_deg * kRadPerDeg}},
        {{37.3, 14321.0, 12.3}, {-411.7, 17321.0, -45.6}, {913.1, 22321.0, 0.7}});
    for (const bool intersect : {false, true}) {
      try {
        const AdjustResult result = intersect ? IntersectBlock(block, {}) : Adjust(block, {});
        ADD_FAILURE() << "accepted: " << result.usable();
      } catch (const UndeterminedError& error) {
        EXPECT_THAT(error.what(), HasSubstr("single flight line"));
        EXPECT_THAT(error.what(), HasSubstr("P1"));
      }
    }
  }
}

}  // namespace
}  // namespace sarblock
