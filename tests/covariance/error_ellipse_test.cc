// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <cmath>

#include "quality/covariance.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

// Hand: axes 3 and 2 m, the longer one 30 degrees clockwise from north (rotate diag(4, 9)).
TEST(EllipseOfTest, TurnsTheMajorAxisToWhereTheErrorsAre) {
  const double s = 0.5, c = std::sqrt(0.75);
  const double ee = 9 * s * s + 4 * c * c, nn = 9 * c * c + 4 * s * s, en = (9 - 4) * s * c;
  const ErrorEllipse e = EllipseOf({ee, nn, 7.0, en, 0.3, -0.2});
  EXPECT_NEAR(e.major_m, 3.0, 1e-14);
  EXPECT_NEAR(e.minor_m, 2.0, 1e-14);
  EXPECT_NEAR(e.azimuth_rad * kDegPerRad, 30.0, 1e-12);
  EXPECT_NEAR(EllipseOf({9, 4, 1, 0, 0, 0}).azimuth_rad * kDegPerRad, 90.0, 1e-12);
  EXPECT_NEAR(EllipseOf({ee, nn, 1, -en, 0, 0}).azimuth_rad * kDegPerRad, 150.0, 1e-12);
}

}  // namespace
}  // namespace sarblock
