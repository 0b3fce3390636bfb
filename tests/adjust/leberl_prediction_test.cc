// SPDX-License-Identifier: Apache-2.0
#include "adjust/leberl_prediction.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/leberl/formulas.h"

#include <cmath>
#include <numbers>

#include "support/paper_block.h"
#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using leberl::Signs;

constexpr double kBase_m = 8123.0, kHeight_m = 10457.0;
const std::vector<Eigen::Vector3d> kPoints_m = {
    {-731.0, 14321.0, 0.0}, {417.0, 19871.0, 312.7}, {1313.0, 23917.0, -145.1}};

Block PairBlock(const std::vector<Eigen::Vector3d>& points_m = kPoints_m) {
  return test::MakePaperBlock({{0.0, kHeight_m, 1.7}, {kBase_m, kHeight_m, 2.9}}, points_m);
}

CorrectionGroup Position(std::array<double, 3> sigma_m) {
  PositionCorrection position;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!std::isnan(sigma_m[axis])) position.prior_sigma_m[axis] = {sigma_m[axis]};
  }
  return {"position", position, {}, false};
}

AdjustOptions With(std::vector<CorrectionGroup> groups) {
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = std::move(groups);
  options.pairs = PairChoice::kAll;
  return options;
}

leberl::StereoConfiguration At(const Eigen::Vector3d& p_m) {
  return {.base_m = kBase_m, .height_m = kHeight_m - p_m.z(), .ground_range_m = p_m.y()};
}

TEST(LeberlPredictionTest, NoiseIsTheCovarianceOfATwoLookIntersection) {  // two routes
  const AdjustResult result = IntersectBlock(PairBlock(), {});
  for (std::size_t j = 0; j < kPoints_m.size(); ++j) {
    const SymmetricEnu& c = result.points.covariance_m2[j];
    EXPECT_NEAR(result.points.sigma_leberl_across_m[j], std::sqrt(c[1]), 1e-8);
    EXPECT_NEAR(result.points.sigma_leberl_up_m[j], std::sqrt(c[2]), 1e-8);
    EXPECT_EQ(result.points.sigma_leberl_path_across_m[j], 0.0);  // paths held
    EXPECT_NEAR(result.points.leberl_across_azimuth_rad[j], 0.0, 1e-12);
  }
}

// Hand evaluation of Eq. 14 and 15, station by station.
TEST(LeberlPredictionTest, PathSigmasAreEq14And15OfThePriors) {
  const AdjustResult result = Adjust(PairBlock(), With({Position({41.0, 13.0, 7.0})}));
  for (std::size_t j = 0; j < kPoints_m.size(); ++j) {
    double across_m2 = 0.0, up_m2 = 0.0;
    for (const leberl::StereoErrors& e : {leberl::StereoErrors{.first = {.dy0_m = 13.0}},
                                          leberl::StereoErrors{.first = {.dz0_m = 7.0}},
                                          leberl::StereoErrors{.second = {.dy0_m = 13.0}},
                                          leberl::StereoErrors{.second = {.dz0_m = 7.0}}}) {
      across_m2 += std::pow(AcrossError(At(kPoints_m[j]), e), 2);
      up_m2 += std::pow(HeightError(At(kPoints_m[j]), e), 2);
    }
    EXPECT_NEAR(result.points.sigma_leberl_path_across_m[j], std::sqrt(across_m2), 1e-7);
    EXPECT_NEAR(result.points.sigma_leberl_path_up_m[j], std::sqrt(up_m2), 1e-7);
  }
}

// Two routes. Two zero-Doppler images without control: every point has two range equations for y
// and z, so the block knows no more about them than the paper does.
TEST(LeberlPredictionTest, IsTheBlockCovarianceOfAPairWithoutControl) {
  const AdjustResult result = Adjust(PairBlock(), With({Position({41.0, 13.0, 7.0})}));
  const auto check = [](double noise_m, double path_m, double variance_m2) {
    EXPECT_NEAR(std::hypot(noise_m, path_m), std::sqrt(variance_m2), 1e-7);
  };
  for (std::size_t j = 0; j < kPoints_m.size(); ++j) {
    const PointResults& p = result.points;
    check(p.sigma_leberl_across_m[j], p.sigma_leberl_path_across_m[j], p.covariance_m2[j][1]);
    check(p.sigma_leberl_up_m[j], p.sigma_leberl_path_up_m[j], p.covariance_m2[j][2]);
  }
  ASSERT_EQ(result.pairs.size(), 3u);
  for (const PairResult& q : result.pairs) {
    check(q.sigma_leberl_across_m, q.sigma_leberl_path_across_m, q.covariance_m2[1]);
    check(q.sigma_leberl_up_m, q.sigma_leberl_path_up_m, q.covariance_m2[2]);
  }
}

// Closed form: close points see Eq. 18, 19, 22 and 23 with the derived signs. dB and dH are
// differences of two independent positions. Second order left out: 20 m of 8 km.
TEST(LeberlPredictionTest, PathSigmasOfCloseDifferencesAreEq18To23) {
  const leberl::Difference d{17.3, -11.9};
  const Eigen::Vector3d a_m(37.0, 19871.0, 0.0);
  const AdjustResult result = Adjust(PairBlock({a_m, a_m + Eigen::Vector3d(5.3, d.dy_m, d.dz_m)}),
                                     With({Position({41.0, 13.0, 7.0})}));
  const leberl::Difference base =
      leberl::DifferenceErrorOfBase(At(a_m), d, 13.0 * std::numbers::sqrt2, Signs::kDerived);
  const leberl::Difference height =
      leberl::DifferenceErrorOfHeight(At(a_m), d, 7.0 * std::numbers::sqrt2, Signs::kDerived);
  ASSERT_EQ(result.pairs.size(), 1u);
  const double across_m = std::hypot(base.dy_m, height.dy_m);
  const double up_m = std::hypot(base.dz_m, height.dz_m);
  EXPECT_NEAR(result.pairs[0].sigma_leberl_path_across_m, across_m, 4e-3 * across_m);
  EXPECT_NEAR(result.pairs[0].sigma_leberl_path_up_m, up_m, 4e-3 * up_m);
  // the printed signs would not do: with Dy = Dz / -1.45 the terms of Eq. 19 add to another number
  const leberl::Difference printed =
      leberl::DifferenceErrorOfBase(At(a_m), d, 13.0 * std::numbers::sqrt2, Signs::kPrinted);
  EXPECT_GT(std::abs(std::hypot(printed.dz_m, height.dz_m) - up_m), 0.1 * up_m);
}

TEST(LeberlPredictionTest, ASharedRangeBiasActsOnBothLooksAtOnce) {  // closed form
  RangeCorrection range;
  range.bias = true;
  range.bias_prior_sigma_m = 3.7;
  const auto path_up_m = [&](bool shared) {
    const AdjustOptions options = With({CorrectionGroup{"range", range, {}, shared}});
    return Adjust(PairBlock(), options).points.sigma_leberl_path_up_m[1];
  };
  const leberl::StereoConfiguration c = At(kPoints_m[1]);
  const double first_m = HeightError(c, {.first = {.dr_m = 3.7}});
  const double second_m = HeightError(c, {.second = {.dr_m = 3.7}});
  EXPECT_NEAR(path_up_m(true), std::abs(first_m + second_m), 1e-8);
  EXPECT_NEAR(path_up_m(false), std::hypot(first_m, second_m), 1e-8);
}

TEST(LeberlPredictionTest, APositionWithoutAPriorLeavesThePathSigmaEmpty) {
  Block block = PairBlock();
  for (std::uint32_t j = 0; j < 3; ++j) {  // control, or across and up were not determined
    block.points.role[j] = PointRole::kControl;
    block.points.known.push_back({j, {true, true, true}, Eigen::Matrix3d::Identity()});
    block.points.given_m[j] = kPoints_m[j];
  }
  const AdjustResult across = Adjust(block, With({Position({41.0, kNotGiven, 7.0})}));
  EXPECT_TRUE(std::isnan(across.points.sigma_leberl_path_up_m[0]));
  EXPECT_TRUE(std::isnan(across.pairs[0].sigma_leberl_path_up_m));
  EXPECT_GT(across.points.sigma_leberl_up_m[0], 1.0);
  EXPECT_GT(across.pairs[0].sigma_leberl_up_m, 1.0);
  const AdjustResult along = Adjust(block, With({Position({kNotGiven, 13.0, 7.0})}));
  EXPECT_GT(along.points.sigma_leberl_path_up_m[0], 1.0);
}

TEST(LeberlPredictionTest, TakesThePairWithTheSmallestPredictedSigma) {
  const auto across_m = [](double sigma_3_m) {
    const Block block = test::MakePaperBlock(
        {{0.0, kHeight_m, 1.7}, {3041.0, kHeight_m, 1.7}, {kBase_m, kHeight_m, sigma_3_m}},
        {kPoints_m[0]});
    return IntersectBlock(block, {}).points.sigma_leberl_across_m[0];
  };
  const leberl::StereoConfiguration wide = At(kPoints_m[0]);
  leberl::StereoConfiguration narrow = wide;
  narrow.base_m = 3041.0;
  EXPECT_NEAR(across_m(1.7), leberl::NoiseOfRange(wide, 1.7).sigma_y_m, 1e-8);
  EXPECT_NEAR(across_m(170.0), leberl::NoiseOfRange(narrow, 1.7).sigma_y_m, 1e-8);
}

TEST(LeberlPredictionTest, IsEmptyWhereThePaperHasNoCounterpart) {
  Block one_look = PairBlock();
  one_look.looks.flags[0] = Looks::kRejected;
  const AdjustResult single = IntersectBlock(one_look, {});
  EXPECT_TRUE(std::isnan(single.points.sigma_leberl_across_m[0]));
  EXPECT_GT(single.points.sigma_leberl_across_m[1], 1.0);
  const Block squinted = test::MakePaperBlock(
      {{0.0, kHeight_m, 1.7, 0.35}, {kBase_m, kHeight_m, 1.7, -0.31}}, kPoints_m);
  const AdjustResult intersected = IntersectBlock(squinted, {});
  ASSERT_EQ(intersected.points.status[1], PointStatus::kIntersected);
  EXPECT_TRUE(std::isnan(intersected.points.sigma_leberl_up_m[1]));
}

// Points of one block whose pairs fly north-south and east-west have no common across.
TEST(LeberlPredictionTest, IsEmptyForADifferenceOfPointsWithCrossingAcrossDirections) {
  test::BlockPlan plan = test::AircraftPlan();
  plan.passes = {{LookSide::kLeft, 0.0, 9031.0, 7013.0},
                 {LookSide::kLeft, 0.0, 5017.0, 7013.0},
                 {LookSide::kLeft, 90.0, 9031.0, 7013.0},
                 {LookSide::kLeft, 90.0, 5017.0, 7013.0}};
  plan.looks_per_point = 2;
  plan.points = 4;  // seen by passes 1-2, 2-3, 3-4 and 4-1
  AdjustOptions options;
  options.pairs = PairChoice::kAll;
  const AdjustResult result = Adjust(test::MakeBlock(plan).block, options);
  EXPECT_GT(result.points.sigma_leberl_across_m[0], 0.0);
  EXPECT_TRUE(std::isnan(result.points.sigma_leberl_across_m[1]));
  EXPECT_GT(result.points.sigma_leberl_across_m[2], 0.0);
  const double turned_rad =
      result.points.leberl_across_azimuth_rad[0] - result.points.leberl_across_azimuth_rad[2];
  EXPECT_NEAR(std::abs(std::sin(turned_rad)), 1.0, 1e-3);  // antennas swing by some metres
  for (const PairResult& q : result.pairs) EXPECT_TRUE(std::isnan(q.sigma_leberl_across_m));
}

TEST(LeberlPredictionTest, StandsAloneAtItsOwnLevel) {
  AdjustOptions options = With({Position({41.0, 13.0, 7.0})});
  const AdjustResult block = Adjust(PairBlock(), options);
  options.covariance = CovarianceLevel::kLeberl;
  const AdjustResult alone = Adjust(PairBlock(), options);
  EXPECT_TRUE(alone.points.covariance_m2.empty());
  EXPECT_TRUE(alone.parameter_covariance.empty());
  EXPECT_TRUE(std::isnan(alone.parameters[0].sigma));
  EXPECT_EQ(alone.points.sigma_leberl_up_m, block.points.sigma_leberl_up_m);
  ASSERT_EQ(alone.pairs.size(), block.pairs.size());
  EXPECT_EQ(alone.pairs[2].sigma_leberl_path_up_m, block.pairs[2].sigma_leberl_path_up_m);
  EXPECT_EQ(alone.pairs[2].difference_enu_m, block.pairs[2].difference_enu_m);
  EXPECT_TRUE(std::isnan(alone.pairs[2].covariance_m2[0]));
  options.covariance = CovarianceLevel::kNone;
  EXPECT_TRUE(Adjust(PairBlock(), options).points.sigma_leberl_up_m.empty());
}

}  // namespace
}  // namespace sarblock
