// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "leberl/rigorous.h"
#include <gtest/gtest.h>

namespace sarblock::leberl {
namespace {

const Triple kUp{0.0, 0.0, 1.0};
const Triple kForward{211.0, 0.0, 0.0};
const Triple kPoint_m{731.0, 13021.0, 0.0};
const ReducedLook kFirst{.antenna_m = {731.0, 0.0, 10007.0}, .velocity_mps = kForward};
const ReducedLook kSecond{.antenna_m = {731.0, 8003.0, 10007.0}, .velocity_mps = kForward};

// Turns about z by `angle` and then exchanges the axes cyclically: some other Cartesian frame.
Triple Turned(const Triple& a, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {a[2], c * a[0] - s * a[1], s * a[0] + c * a[1]};
}

TEST(ReducePairTest, ReturnsThePapersOwnConfiguration) {  // closed form
  const auto c = ReducePair(kPoint_m, kUp, kFirst, kSecond);
  ASSERT_TRUE(c);
  EXPECT_NEAR(c->base_m, 8003.0, 1e-9);
  EXPECT_NEAR(c->height_m, 10007.0, 1e-9);
  EXPECT_NEAR(c->ground_range_m, 13021.0, 1e-9);
  EXPECT_EQ(c->arrangement, Arrangement::kSameSide);
}

TEST(ReducePairTest, DoesNotDependOnTheFrame) {  // invariance
  const auto c = ReducePair(Turned(kPoint_m, 0.7),
                            Turned(kUp, 0.7),
                            {Turned(kFirst.antenna_m, 0.7), Turned(kForward, 0.7)},
                            {Turned(kSecond.antenna_m, 0.7), Turned(kForward, 0.7)});
  ASSERT_TRUE(c);
  EXPECT_NEAR(c->base_m, 8003.0, 1e-9);
  EXPECT_NEAR(c->height_m, 10007.0, 1e-9);
  EXPECT_NEAR(c->ground_range_m, 13021.0, 1e-9);
}

TEST(ReducePairTest, TurnsAPassFlownTheOtherWayAndSeesOppositeSides) {
  ReducedLook far = kSecond;
  far.antenna_m[1] = 25011.0;
  far.velocity_mps = {-190.0, 0.0, 0.0};
  const auto c = ReducePair(kPoint_m, kUp, kFirst, far);
  ASSERT_TRUE(c);
  EXPECT_NEAR(c->base_m, 25011.0, 1e-9);
  EXPECT_NEAR(c->ground_range_m, 13021.0, 1e-9);
  EXPECT_EQ(c->arrangement, Arrangement::kOppositeSide);
  EXPECT_NO_THROW(Validate(*c));
}

TEST(ReducePairTest, TakesTheMeanOfHeightsThatDifferALittle) {
  ReducedLook higher = kSecond;
  higher.antenna_m[2] = 10407.0;
  const auto c = ReducePair(kPoint_m, kUp, kFirst, higher);
  ASSERT_TRUE(c);
  EXPECT_NEAR(c->height_m, 10207.0, 1e-9);
}

TEST(ReducePairTest, IsEmptyWhereThePaperHasNoCounterpart) {
  const auto refused = [](const ReducedLook& second) {
    return !ReducePair(kPoint_m, kUp, kFirst, second).has_value();
  };
  ReducedLook look = kSecond;
  EXPECT_FALSE(refused(look));
  look.velocity_mps = {0.0, 211.0, 0.0};  // cross-wise
  EXPECT_TRUE(refused(look));
  look = kSecond;
  look.velocity_mps = {0.0, 0.0, 0.0};
  EXPECT_TRUE(refused(look));
  look = kSecond;
  look.antenna_m[0] -= 4000.0;  // 20 degrees of squint
  EXPECT_TRUE(refused(look));
  look = kSecond;
  look.antenna_m[2] = 13007.0;
  EXPECT_TRUE(refused(look));
  look.antenna_m[2] = -5.0;
  EXPECT_TRUE(refused(look));
  look = kFirst;  // zero base
  EXPECT_TRUE(refused(look));
  look = kSecond;
  look.antenna_m[1] = kPoint_m[1];  // nadir
  EXPECT_TRUE(refused(look));
}

}  // namespace
}  // namespace sarblock::leberl
