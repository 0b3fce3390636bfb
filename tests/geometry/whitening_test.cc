// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/look_equations.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

Eigen::Matrix2d Dense(const Whitening& w) {
  Eigen::Matrix2d m;
  m << w.w00, 0.0, w.w10, w.w11;
  return m;
}

// Second route: the 2 x 2 covariance formed and factorised by Eigen.
TEST(WhiteningTest, IsTheInverseCholeskyFactorOfTheCovariance) {
  const double sigma_r_m = 1.37, sigma_t_s = 2.9e-3;
  for (const double r_mps : {0.0, 61.3, -148.7, 233.0}) {
    const TimeRates rates{r_mps, -187.25};
    Eigen::Matrix2d covariance;
    const double t2 = sigma_t_s * sigma_t_s;
    covariance << sigma_r_m * sigma_r_m + r_mps * r_mps * t2, r_mps * rates.doppler_mps * t2,
        r_mps * rates.doppler_mps * t2, rates.doppler_mps * rates.doppler_mps * t2;
    const Eigen::Matrix2d lower = covariance.llt().matrixL();
    const Eigen::Matrix2d expected = lower.inverse();
    const Eigen::Matrix2d w = Dense(WhitenTime(sigma_r_m, sigma_t_s, rates));
    // Entries up to 2 per metre, a covariance of condition 10: rounding stays below 1e-14.
    EXPECT_LT((w - expected).cwiseAbs().maxCoeff(), 2e-14) << r_mps;
    EXPECT_LT((w * covariance * w.transpose() - Eigen::Matrix2d::Identity()).norm(), 1e-14);
  }
}

TEST(WhiteningTest, IsTwoDivisionsWithoutSquint) {
  const Whitening w = WhitenAzimuth(2.5, 0.8, {0.0, -7411.3, 7411.3});
  EXPECT_NEAR(w.w00, 0.4, 1e-16);
  EXPECT_NEAR(w.w11, 1.25, 1e-15);
  EXPECT_EQ(w.w10, 0.0);
  const Eigen::Vector2d whitened = w.Apply(5.0, -1.6);
  EXPECT_NEAR(whitened[0], 2.0, 1e-15);
  EXPECT_NEAR(whitened[1], -2.0, 1e-15);
}

TEST(WhiteningTest, MetresAlongTrackAtTheTargetAreSecondsTimesTheSpeedOfTheLook) {
  const TimeRates rates{43.7, -151.9, 173.2};
  const Whitening metres = WhitenAzimuth(1.9, 173.2 * 0.013, rates);
  const Whitening seconds = WhitenTime(1.9, 0.013, rates);
  EXPECT_NEAR(metres.w00, seconds.w00, 1e-15);
  EXPECT_NEAR(metres.w10, seconds.w10, 1e-15);
  EXPECT_NEAR(metres.w11, seconds.w11, 1e-15);
}

// An azimuth error of one standard deviation alone must weigh exactly one: e = (r, d) sigma_t has
// the norm 1 as sigma_R -> 0 (closed form of the rank-one covariance).
TEST(WhiteningTest, AnAzimuthErrorWeighsItsStandardDeviation) {
  const TimeRates rates{-97.3, -160.1};
  const double sigma_t_s = 4.1e-3;
  const Whitening w = WhitenTime(1e-6, sigma_t_s, rates);
  const Eigen::Vector2d e = w.Apply(rates.range_mps * sigma_t_s, rates.doppler_mps * sigma_t_s);
  // sigma_R^2/(r sigma_t)^2 = 6e-12 is what the range error takes away.
  EXPECT_NEAR(e.norm(), 1.0, 1e-9);
}

}  // namespace
}  // namespace sarblock
