// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "quality/assess.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

CheckResult Check(std::uint32_t point, const Eigen::Vector3d& error_enu_m, double chi_square) {
  CheckResult check;
  check.point = point;
  check.error_enu_m = error_enu_m;
  check.chi_square = chi_square;
  check.components = 3;
  return check;
}

/// Two points with covariances, and one that a search for blunders left out: a position without
/// one.
AdjustResult WithOneLeftOut() {
  AdjustResult result;
  result.points.status = {PointStatus::kAdjusted, PointStatus::kAdjusted, PointStatus::kApart};
  result.points.covariance_m2.resize(3);
  result.checks = {Check(0, {3.0, -1.0, 0.0}, 2.7),
                   Check(1, {-4.0, 7.0, 2.0}, 3.9),
                   Check(2, {811.0, -1548.0, 997.0}, kNotGiven)};
  return result;
}

// Hand arithmetic: sqrt((9 + 16) / 2), sqrt((1 + 49) / 2), sqrt(4 / 2).
TEST(CheckSummaryTest, PointsWithoutAStandardDeviationAreInNoFigure) {
  const CheckSummary summary = SummariseChecks(WithOneLeftOut(), 0.95);
  EXPECT_EQ(summary.points, 2U);
  EXPECT_EQ(summary.points_without_sigma, 1U);
  EXPECT_EQ(summary.components, 6);
  EXPECT_NEAR(summary.rms_m[0], std::sqrt(12.5), 1e-12);
  EXPECT_NEAR(summary.rms_m[1], 5.0, 1e-12);
  EXPECT_NEAR(summary.rms_m[2], std::sqrt(2.0), 1e-12);
  EXPECT_THAT(DescribeChecks(summary, 0.95),
              HasSubstr("0 of 2 points exceed their own 95 % limit (0.1 expected); 1 more have no "
                        "standard deviation"));
}

// Without covariances every point that was solved counts.
TEST(CheckSummaryTest, WithoutCovariancesTheSolvedPointsAreCompared) {
  AdjustResult result = WithOneLeftOut();
  result.points.covariance_m2.clear();
  for (CheckResult& check : result.checks) check.chi_square = kNotGiven;
  const CheckSummary summary = SummariseChecks(result, 0.95);
  EXPECT_EQ(summary.points, 2U);
  EXPECT_NEAR(summary.rms_m[1], 5.0, 1e-12);
  EXPECT_EQ(DescribeChecks(summary, 0.95), "");
}

}  // namespace
}  // namespace sarblock
