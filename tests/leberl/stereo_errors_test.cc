// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "leberl/rigorous.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using leberl::Arrangement;
using leberl::PointError;
using leberl::Presentation;
using leberl::Signs;
using leberl::StationErrors;
using leberl::StereoConfiguration;
using leberl::StereoErrors;

constexpr int kGeometries = 2000;  // of each arrangement
constexpr double kAgreement = 1e-9;

double Between(RandomStream* random, double lower, double upper) {
  return lower + (upper - lower) * random->Uniform();
}

StereoConfiguration RandomConfiguration(RandomStream* random, Arrangement arrangement) {
  StereoConfiguration c;
  c.arrangement = arrangement;
  c.height_m = std::pow(10.0, Between(random, 3.0, 6.0));
  c.ground_range_m = c.height_m * Between(random, 0.3, 3.0);
  if (arrangement == Arrangement::kSameSide) {
    c.base_m = Between(random, -0.9, 0.9) * c.ground_range_m;
    if (std::abs(c.base_m) < 0.02 * c.ground_range_m) c.base_m = 0.02 * c.ground_range_m;
  } else {
    c.base_m = c.ground_range_m * Between(random, 1.2, 3.0);
  }
  if (random->Uniform() < 0.3) {  // the mirror image looks to the other side
    c.base_m = -c.base_m;
    c.ground_range_m = -c.ground_range_m;
  }
  return c;
}

StationErrors RandomErrors(RandomStream* random, double size_m, double direction) {
  return {.dx0_m = size_m * random->Normal(),
          .dy0_m = size_m * random->Normal(),
          .dz0_m = size_m * random->Normal(),
          .dr_m = size_m * random->Normal(),
          .dydot0 = direction * random->Normal(),
          .dzdot0 = direction * random->Normal(),
          .range_scale = direction * random->Normal()};
}

StationErrors Scaled(const StationErrors& e, double factor) {
  return {.dx0_m = factor * e.dx0_m,
          .dy0_m = factor * e.dy0_m,
          .dz0_m = factor * e.dz0_m,
          .dr_m = factor * e.dr_m,
          .dydot0 = factor * e.dydot0,
          .dzdot0 = factor * e.dzdot0,
          .range_scale = factor * e.range_scale};
}

StereoErrors Scaled(const StereoErrors& e, double factor) {
  return {.first = Scaled(e.first, factor), .second = Scaled(e.second, factor)};
}

double Length(const PointError& e) { return std::hypot(e.dx_m, e.dy_m, e.dz_m); }
PointError Minus(const PointError& a, const PointError& b) {
  return {a.dx_m - b.dx_m, a.dy_m - b.dy_m, a.dz_m - b.dz_m};
}

// Largest single term: what a sum of terms that cancel is rounded against.
double TermScale(const StereoConfiguration& c, const StereoErrors& e) {
  double scale = 0.0;
  for (double StationErrors::*const member : {&StationErrors::dx0_m,
                                              &StationErrors::dy0_m,
                                              &StationErrors::dz0_m,
                                              &StationErrors::dr_m,
                                              &StationErrors::dydot0,
                                              &StationErrors::dzdot0,
                                              &StationErrors::range_scale}) {
    StereoErrors first, second;
    first.first.*member = e.first.*member;
    second.second.*member = e.second.*member;
    scale = std::max({scale,
                      Length(leberl::PointErrors(c, first, Signs::kDerived)),
                      Length(leberl::PointErrors(c, second, Signs::kDerived))});
  }
  return scale;
}

class ArrangementTest : public testing::TestWithParam<Arrangement> {};
INSTANTIATE_TEST_SUITE_P(BothSides,
                         ArrangementTest,
                         testing::Values(Arrangement::kSameSide, Arrangement::kOppositeSide));

// Two routes: closed forms against the implicit derivative of the four equations.
TEST_P(ArrangementTest, DerivativeEqualsTheFormulasWithDerivedSigns) {
  RandomStream random(20240611, 1);
  for (int i = 0; i < kGeometries; ++i) {
    const StereoConfiguration c = RandomConfiguration(&random, GetParam());
    ASSERT_NO_THROW(Validate(c));
    const StereoErrors errors{.first = RandomErrors(&random, 3.7, 1.3e-4),
                              .second = RandomErrors(&random, 3.7, 1.3e-4)};
    const PointError formula = leberl::PointErrors(c, errors, Signs::kDerived);
    const PointError derivative = StereoErrorDerivative(c, errors);
    ASSERT_LE(Length(Minus(formula, derivative)), kAgreement * TermScale(c, errors))
        << c.base_m << " " << c.height_m << " " << c.ground_range_m;
  }
}

// Each source alone: every single coefficient to 1e-9 of itself.
TEST_P(ArrangementTest, DerivativeEqualsEveryTermOfTheFormulasAlone) {
  RandomStream random(20240611, 2);
  for (int i = 0; i < kGeometries / 4; ++i) {
    const StereoConfiguration c = RandomConfiguration(&random, GetParam());
    for (const StationErrors& one : {StationErrors{.dx0_m = 1.3},
                                     StationErrors{.dy0_m = 1.3},
                                     StationErrors{.dz0_m = 1.3},
                                     StationErrors{.dr_m = 1.3},
                                     StationErrors{.dydot0 = 1.3e-5},
                                     StationErrors{.dzdot0 = 1.3e-5},
                                     StationErrors{.range_scale = 1.3e-5}}) {
      for (const StereoErrors& errors : {StereoErrors{.first = one}, StereoErrors{.second = one}}) {
        const PointError formula = leberl::PointErrors(c, errors, Signs::kDerived);
        const PointError derivative = StereoErrorDerivative(c, errors);
        const double floor_m = 1e-12 * Length(formula);  // zero against rounding
        ASSERT_NEAR(derivative.dx_m, formula.dx_m, kAgreement * std::abs(formula.dx_m) + floor_m);
        ASSERT_NEAR(derivative.dy_m, formula.dy_m, kAgreement * std::abs(formula.dy_m) + floor_m);
        ASSERT_NEAR(derivative.dz_m, formula.dz_m, kAgreement * std::abs(formula.dz_m) + floor_m);
      }
    }
  }
}

// Closed forms with derived signs against the mixed second derivative of the four equations.
TEST_P(ArrangementTest, DifferenceDerivativeEqualsTheFormulasWithDerivedSigns) {
  RandomStream random(20240611, 3);
  for (int i = 0; i < kGeometries; ++i) {
    const StereoConfiguration c = RandomConfiguration(&random, GetParam());
    const leberl::Difference d{1e-2 * c.height_m * random.Normal(),
                               1e-2 * c.height_m * random.Normal()};
    const double size_m = 1e-4 * c.height_m;
    const leberl::Difference base = DifferenceErrorOfBase(c, d, size_m, Signs::kDerived);
    const leberl::Difference height = DifferenceErrorOfHeight(c, d, size_m, Signs::kDerived);
    const leberl::Difference warp =
        RangeWarp(c, 0.7 * size_m, -0.4 * size_m, Signs::kDerived).Apply(d);
    const PointError from_base = DifferenceErrorDerivative(c, {.second = {.dy0_m = size_m}}, d);
    const PointError from_height = DifferenceErrorDerivative(c, {.second = {.dz0_m = size_m}}, d);
    const PointError from_range = DifferenceErrorDerivative(
        c, {.first = {.dr_m = 0.7 * size_m}, .second = {.dr_m = -0.4 * size_m}}, d);
    // terms of either sign: rounded against the size of one of them
    const double scale_m = size_m * std::hypot(d.dy_m, d.dz_m) / std::abs(c.base_m) *
                           (1.0 + std::abs(c.ground_range_m) / c.height_m) *
                           (1.0 + std::abs(c.ground_range_m) / c.height_m);
    ASSERT_NEAR(from_base.dy_m, base.dy_m, kAgreement * scale_m);
    ASSERT_NEAR(from_base.dz_m, base.dz_m, kAgreement * scale_m);
    ASSERT_NEAR(from_height.dy_m, height.dy_m, kAgreement * scale_m);
    ASSERT_NEAR(from_height.dz_m, height.dz_m, kAgreement * scale_m);
    ASSERT_NEAR(from_range.dy_m, warp.dy_m, kAgreement * scale_m);
    ASSERT_NEAR(from_range.dz_m, warp.dz_m, kAgreement * scale_m);
  }
}

// The same of all errors together, scales of the ranges among them.
TEST_P(ArrangementTest, DifferenceDerivativeEqualsTheSumOfAllErrors) {
  RandomStream random(20240611, 7);
  for (int i = 0; i < kGeometries; ++i) {
    const StereoConfiguration c = RandomConfiguration(&random, GetParam());
    const leberl::Difference d{1e-2 * c.height_m * random.Normal(),
                               1e-2 * c.height_m * random.Normal()};
    const double size_m = 1e-4 * c.height_m;
    StereoErrors errors{.first = RandomErrors(&random, size_m, 1e-4),
                        .second = RandomErrors(&random, size_m, 1e-4)};
    const leberl::Difference formula = DifferenceErrors(c, errors, d, Signs::kDerived);
    const PointError derivative = DifferenceErrorDerivative(c, errors, d);
    const double slope = 1.0 + std::abs(c.ground_range_m) / c.height_m;
    const double scale_m =
        size_m * std::hypot(d.dy_m, d.dz_m) / std::abs(c.base_m) * slope * slope * slope;
    ASSERT_NEAR(derivative.dy_m, formula.dy_m, kAgreement * scale_m);
    ASSERT_NEAR(derivative.dz_m, formula.dz_m, kAgreement * scale_m);
  }
}

// Second order: halving the perturbation quarters what the first order leaves.
TEST_P(ArrangementTest, ExactLeavesTheDerivativeByAQuarterWhereTheErrorHalves) {
  RandomStream random(20240611, 4);
  for (int i = 0; i < kGeometries; ++i) {
    const StereoConfiguration c = RandomConfiguration(&random, GetParam());
    const double size = 2e-5 * std::min(std::abs(c.base_m), c.height_m) /
                        std::max(1.0, std::abs(c.ground_range_m / c.base_m));
    const StereoErrors errors{.first = RandomErrors(&random, size, size / c.height_m),
                              .second = RandomErrors(&random, size, size / c.height_m)};
    const auto whole = StereoErrorExact(c, errors);
    const auto half = StereoErrorExact(c, Scaled(errors, 0.5));
    ASSERT_TRUE(whole && half);
    const PointError slope = StereoErrorDerivative(c, errors);
    const PointError half_slope = StereoErrorDerivative(c, Scaled(errors, 0.5));
    const double left_m = Length(Minus(*whole, slope));
    const double half_left_m = Length(Minus(*half, half_slope));
    ASSERT_LE(left_m, 0.01 * Length(slope));
    ASSERT_NEAR(half_left_m / left_m, 0.25, 0.01) << "geometry " << i;
  }
}

TEST_P(ArrangementTest, ExactDifferenceApproachesItsDerivative) {  // first order in both, by halves
  RandomStream random(20240611, 5);
  for (int i = 0; i < 200; ++i) {
    const StereoConfiguration c = RandomConfiguration(&random, GetParam());
    const double size_m = 1e-4 * std::abs(c.base_m);
    const leberl::Difference d{1e-3 * c.base_m, 0.7e-3 * c.base_m};
    const StereoErrors errors{.second = {.dy0_m = size_m, .dz0_m = 0.6 * size_m, .dr_m = size_m}};
    double left_m[2] = {};
    for (int k = 0; k < 2; ++k) {
      const double f = k == 0 ? 1.0 : 0.5;
      const leberl::Difference small{f * d.dy_m, f * d.dz_m};
      const auto exact = DifferenceErrorExact(c, Scaled(errors, f), small);
      ASSERT_TRUE(exact);
      left_m[k] = Length(Minus(*exact, DifferenceErrorDerivative(c, Scaled(errors, f), small)));
    }
    // the product size * difference is second order, what is left of it third: factor 8
    ASSERT_NEAR(left_m[1] / left_m[0], 0.125, 0.01) << "geometry " << i;
  }
}

// Two routes: Eq. 25 against the covariance of the least-squares intersection.
TEST_P(ArrangementTest, RangeNoiseEqualsTheIntersectionCovariance) {
  RandomStream random(20240611, 6);
  for (int i = 0; i < kGeometries / 10; ++i) {
    const StereoConfiguration c = RandomConfiguration(&random, GetParam());
    const leberl::RangeNoise formula = leberl::NoiseOfRange(c, 1.7);
    const leberl::RangeNoise rigorous = StereoRangeNoise(c, 1.7);
    ASSERT_NEAR(rigorous.sigma_y_m, formula.sigma_y_m, kAgreement * formula.sigma_y_m);
    ASSERT_NEAR(rigorous.sigma_z_m, formula.sigma_z_m, kAgreement * formula.sigma_z_m);
  }
}

TEST(StereoRangeNoiseTest, EqualsEq25AcrossTheSwathsOfThePaper) {
  for (const auto& [base_m, height_m, near_m, far_m] :
       {std::array{8e3, 10e3, 13e3, 25e3}, std::array{40e3, 375e3, 365e3, 425e3}}) {
    for (int k = 0; k <= 12; ++k) {
      const StereoConfiguration c{.base_m = base_m,
                                  .height_m = height_m,
                                  .ground_range_m = near_m + k / 12.0 * (far_m - near_m)};
      const leberl::RangeNoise formula = leberl::NoiseOfRange(c, 100.0);
      const leberl::RangeNoise rigorous = StereoRangeNoise(c, 100.0);
      EXPECT_NEAR(rigorous.sigma_y_m, formula.sigma_y_m, kAgreement * formula.sigma_y_m);
      EXPECT_NEAR(rigorous.sigma_z_m, formula.sigma_z_m, kAgreement * formula.sigma_z_m);
    }
  }
}

// The stations as the reconstruction uses them, for the second routes below.
const StereoConfiguration kScene{.base_m = 8123.4, .height_m = 10345.6, .ground_range_m = 19876.5};
const Eigen::Vector3d kTruth_m(0.0, 19876.5, 0.0);

std::vector<FixedPathLook> PerturbedSights(const StereoErrors& errors) {
  std::vector<FixedPathLook> observations(2);
  for (std::size_t k = 0; k < 2; ++k) {
    const StationErrors& e = k == 0 ? errors.first : errors.second;
    const Eigen::Vector3d antenna_m(0.0, k == 0 ? 0.0 : kScene.base_m, kScene.height_m);
    observations[k].antenna_m = antenna_m + Eigen::Vector3d(e.dx0_m, e.dy0_m, e.dz0_m);
    observations[k].velocity_mps = 211.0 * Eigen::Vector3d(1.0, e.dydot0, e.dzdot0);
    observations[k].range_m = (1.0 + e.range_scale) * (kTruth_m - antenna_m).norm() + e.dr_m;
    observations[k].side = +1;
    observations[k].range_sigma_m = 1.0;
    observations[k].azimuth_sigma = 1.0;
  }
  return observations;
}

// Two routes: the Newton iteration here against the intersection of the geometry module. The two
// planes agree, so that the answer does not depend on weights.
TEST(StereoErrorExactTest, EqualsTheIntersectionOfTheGeometryModule) {
  const StereoErrors errors{.first = {41.3, -67.9, 12.1, 8.7, 0.0, 0.0},
                            .second = {41.3, 55.3, -21.7, -4.9, 0.0, 0.0}};
  const Intersection found = Intersect(PerturbedSights(errors), Frame::Local());
  ASSERT_EQ(found.outcome, IntersectionOutcome::kDetermined);
  const auto exact = StereoErrorExact(kScene, errors);
  ASSERT_TRUE(exact);
  const Eigen::Vector3d shift_m = found.position_m - kTruth_m;
  EXPECT_NEAR(shift_m.x(), exact->dx_m, 1e-7);  // rounding of 2e4 m in double, times 10 for dtheta
  EXPECT_NEAR(shift_m.y(), exact->dy_m, 1e-7);
  EXPECT_NEAR(shift_m.z(), exact->dz_m, 1e-7);
}

// Second route where the planes disagree: the gradient of the sum of squares, with the errors and
// partials of the geometry module, vanishes at the answer.
TEST(StereoErrorExactTest, IsStationaryWhereThePlanesDisagree) {
  const StereoErrors errors{.first = {41.3, -67.9, 12.1, 8.7, 2.3e-3, -1.1e-3},
                            .second = {-13.7, 55.3, -21.7, -4.9, -1.7e-3, 3.1e-3}};
  const auto exact = StereoErrorExact(kScene, errors);
  ASSERT_TRUE(exact);
  const Eigen::Vector3d p_m = kTruth_m + Eigen::Vector3d(exact->dx_m, exact->dy_m, exact->dz_m);
  Eigen::RowVector3d gradient_m = Eigen::RowVector3d::Zero();
  double square_sum_m2 = 0.0;
  for (const FixedPathLook& observation : PerturbedSights(errors)) {
    LookEquations e;
    ASSERT_TRUE(EvaluateLookEquations(
        p_m, observation.antenna_m, observation.velocity_mps, observation.cone, 0.0, &e));
    const double range_error_m = e.rho_m - observation.range_m;
    gradient_m += range_error_m * e.drho_dp + e.doppler_error_m * e.ded_dp;
    square_sum_m2 += range_error_m * range_error_m + e.doppler_error_m * e.doppler_error_m;
  }
  EXPECT_GT(square_sum_m2, 100.0);     // the planes do disagree, by tens of metres
  EXPECT_LE(gradient_m.norm(), 1e-9);  // metres; rounding of 2e4 m
}

TEST(StereoErrorExactTest, ShiftsRigidlyWithBothStations) {  // invariance, any size of error
  const StereoConfiguration c{.base_m = 8123.4, .height_m = 10345.6, .ground_range_m = 19876.5};
  const StationErrors shift{.dx0_m = 431.0, .dy0_m = -873.0, .dz0_m = 219.0};
  const auto exact = StereoErrorExact(c, {.first = shift, .second = shift}, 345.6);
  ASSERT_TRUE(exact);
  EXPECT_NEAR(exact->dx_m, 431.0, 1e-9);
  EXPECT_NEAR(exact->dy_m, -873.0, 1e-9);
  EXPECT_NEAR(exact->dz_m, 219.0, 1e-9);
}

TEST(StereoErrorExactTest, HasNoAnswerWhereTheCirclesDoNotMeet) {
  const StereoConfiguration c{.base_m = 8123.4, .height_m = 10345.6, .ground_range_m = 9876.5};
  EXPECT_FALSE(StereoErrorExact(c, {.second = {.dr_m = -9800.0}}));
}

TEST(ExactParallaxTest, ApproachesTheFormulaByAQuarterWhereTheHeightHalves) {
  for (const StereoConfiguration& c :
       {StereoConfiguration{.base_m = 8e3, .height_m = 10e3, .ground_range_m = 19e3},
        StereoConfiguration{.base_m = 31e3,
        .height_m = 10e3,
        .ground_range_m = 19e3,
        .arrangement = Arrangement::kOppositeSide}}) {
    for (const Presentation p : {Presentation::kGroundRange, Presentation::kSlantRange}) {
      double left_m[2] = {};
      for (int k = 0; k < 2; ++k) {
        const double height_m = k == 0 ? 20.0 : 10.0;
        const auto exact = ExactParallaxFromHeight(c, height_m, p);
        ASSERT_TRUE(exact);
        left_m[k] = *exact - leberl::ParallaxFromHeight(c, height_m, p);
      }
      EXPECT_NEAR(left_m[1] / left_m[0], 0.25, 0.01);
    }
  }
}

TEST(ExactParallaxTest, ComesBackThroughItsInverse) {  // round trip; -723 m lies below the datum
  const StereoConfiguration c{.base_m = 8e3, .height_m = 10e3, .ground_range_m = 19e3};
  for (const Presentation p : {Presentation::kGroundRange, Presentation::kSlantRange}) {
    for (const double height_m : {-723.1, 0.37, 1541.9}) {
      const auto parallax = ExactParallaxFromHeight(c, height_m, p);
      ASSERT_TRUE(parallax);
      const auto back = ExactHeightFromParallax(c, *parallax, p);
      ASSERT_TRUE(back);
      EXPECT_NEAR(*back, height_m, 1e-9);
    }
  }
}

TEST(ExactParallaxTest, HasNoGroundRangeForAPointCloserThanTheDatum) {
  const StereoConfiguration c{.base_m = 2e3, .height_m = 10e3, .ground_range_m = 3e3};
  EXPECT_FALSE(ExactParallaxFromHeight(c, 900.0, Presentation::kGroundRange));
  EXPECT_TRUE(ExactParallaxFromHeight(c, 900.0, Presentation::kSlantRange));
}

}  // namespace
}  // namespace sarblock
