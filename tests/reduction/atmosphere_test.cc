// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/reduction/reduction.h"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

// Jehle et al. (2008), by hand: 2.41; 1000^2/8.55e7 - 1000/3411 + 2.41; the same at 4000 m.
TEST(ZenithDelay, FollowsTheStandardAtmosphere) {
  EXPECT_NEAR(ZenithDelay_m(0.0), 2.41, 1e-12);
  EXPECT_NEAR(ZenithDelay_m(1000.0), 2.128526, 1e-6);
  EXPECT_NEAR(ZenithDelay_m(4000.0), 1.424458, 1e-6);
  EXPECT_NEAR(ZenithDelay_m(-430.0), 2.538225, 1e-6);
}

TEST(ZenithDelay, FallsToNothingWithoutAStep) {
  double above_m = ZenithDelay_m(100e3);
  EXPECT_LT(above_m, 1e-5);
  for (double height_m = 99.9e3; height_m >= -1000.0; height_m -= 100.0) {
    const double here_m = ZenithDelay_m(height_m);
    EXPECT_GT(here_m, above_m) << height_m;
    above_m = here_m;
  }
  // Value and slope where the polynomial ends.
  const double below_m = ZenithDelay_m(6000.0) - ZenithDelay_m(5999.0);
  const double beyond_m = ZenithDelay_m(6001.0) - ZenithDelay_m(6000.0);
  EXPECT_NEAR(below_m, beyond_m, 1e-7);
  // A point that diverges while it is solved must not have kilometres of delay.
  EXPECT_EQ(ZenithDelay_m(-1e6), ZenithDelay_m(-1000.0));
}

// Pressures of ISO 2533: 0.0022768 P is what dry air delays, which is all there is up there.
TEST(ZenithDelay, AgreesWithTheStandardPressureOverTheClouds) {
  for (const auto& [height_m, pressure_hpa] : {std::pair{8000.0, 356.52},
                                               {10000.0, 264.36},
                                               {12000.0, 193.30},
                                               {16000.0, 102.87},
                                               {20000.0, 54.749},
                                               {30000.0, 11.719}}) {
    EXPECT_NEAR(ZenithDelay_m(height_m), 0.0022768 * pressure_hpa, 0.025) << height_m;
  }
}

constexpr double k45_rad = std::numbers::pi / 4.0;

// At 45 degrees and sea level the term of gravity is 1. Saturation at 15 C: 6.112 exp(17.62
// 15/258.12) = 17.0166 hPa; half of it: 0.0022768 (1255/288.15 + 0.05) 8.5083 = 0.08534 m.
TEST(ZenithDelay, OfWeatherIsSaastamoinens) {
  const Weather dry{1013.25, 288.15, 0.0, 0.0};
  EXPECT_NEAR(ZenithDelay_m(dry, k45_rad, 0.0), 0.0022768 * 1013.25, 1e-9);
  Weather wet = dry;
  wet.humidity = 0.5;
  EXPECT_NEAR(ZenithDelay_m(wet, k45_rad, 0.0) - ZenithDelay_m(dry, k45_rad, 0.0), 0.08534, 2e-5);
  // Gravity: 1 - 0.00266 at the equator, 1 + 0.00266 at a pole.
  EXPECT_NEAR(ZenithDelay_m(dry, 0.0, 0.0), 2.306968 / 0.99734, 1e-6);
  EXPECT_NEAR(ZenithDelay_m(dry, 2.0 * k45_rad, 0.0), 2.306968 / 1.00266, 1e-6);
}

// The standard atmosphere carried up and down has its own pressures.
TEST(ZenithDelay, CarriesWeatherToTheHeight) {
  const auto gravity = [](double height_m) { return 1.0 - 2.8e-7 * height_m; };
  const Weather sea{1013.25, 288.15, 0.0, 0.0};
  const Weather mountain{701.09, 268.66, 0.0, 3000.0};
  for (const auto& [height_m, pressure_hpa] : {std::pair{-500.0, 1074.78},
                                               {3000.0, 701.09},
                                               {8000.0, 356.00},
                                               {11000.0, 226.32},
                                               {15000.0, 120.45},
                                               {20000.0, 54.749}}) {
    const double expected_m = 0.0022768 * pressure_hpa / gravity(height_m);
    EXPECT_NEAR(ZenithDelay_m(sea, k45_rad, height_m), expected_m, 2e-3) << height_m;
    EXPECT_NEAR(ZenithDelay_m(mountain, k45_rad, height_m), expected_m, 2e-3) << height_m;
  }
  // From above the tropopause down: the same as from below.
  const Weather high{209.16, 216.65, 0.0, 11500.0};
  EXPECT_NEAR(ZenithDelay_m(high, k45_rad, 0.0), ZenithDelay_m(sea, k45_rad, 0.0), 2e-3);
}

TEST(ZenithDelay, OfAMeanDayIsNearTheStandard) {
  const Weather mean{1013.25, 288.15, 0.6, 0.0};
  for (const double height_m : {0.0, 500.0, 1500.0, 3000.0, 5000.0}) {
    EXPECT_NEAR(ZenithDelay_m(mean, k45_rad, height_m), ZenithDelay_m(height_m), 0.03) << height_m;
  }
}

// 40.308 20e16/f^2 by hand: 9.65, 5.405 and 1.257 GHz.
TEST(IonosphericDelay, GrowsWithTheSquareOfTheWavelength) {
  const Ionosphere twenty{20.0, 1.0};
  EXPECT_NEAR(IonosphericDelay_m(twenty, kSpeedOfLight_mps / 9.65e9, 0.0), 0.08657, 1e-5);
  EXPECT_NEAR(IonosphericDelay_m(twenty, kSpeedOfLight_mps / 5.405e9, 0.0), 0.27595, 1e-5);
  EXPECT_NEAR(IonosphericDelay_m(twenty, kSpeedOfLight_mps / 1.257e9, 0.0), 5.1021, 1e-4);
  EXPECT_NEAR(IonosphericDelay_m({20.0, 0.5}, kSpeedOfLight_mps / 1.257e9, 0.0), 2.5510, 1e-4);
}

// At 60 degrees: sin z' = 6371/6821 sin 60 = 0.80889, cos z' = 0.58795.
TEST(IonosphericDelay, CrossesTheShellObliquely) {
  const Ionosphere ten{10.0, 1.0};
  const double sixty_rad = std::numbers::pi / 3.0;
  EXPECT_NEAR(IonosphericDelay_m(ten, 0.24, sixty_rad) / IonosphericDelay_m(ten, 0.24, 0.0),
              1.0 / 0.58795,
              1e-4);
}

std::string ProblemOf(void (*task)()) {
  try {
    task();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Validate, NamesWrongUnits) {
  EXPECT_EQ(ProblemOf([] {
              Validate(Weather{101325.0, 288.15, 0.5, 0.0});
            }),
            "pressure_hpa: must be between 200 and 1100 hPa, got 101325");
  EXPECT_EQ(ProblemOf([] {
              Validate(Weather{1013.25, 15.0, 0.5, 0.0});
            }),
            "temperature_k: must be between 180 and 340 K, got 15");
  EXPECT_EQ(ProblemOf([] {
              Validate(Weather{1013.25, 288.15, 50.0, 0.0});
            }),
            "humidity_1: must be between 0 and 1, got 50");
  EXPECT_EQ(ProblemOf([] {
              Validate(Ionosphere{1e6, 1.0});
            }),
            "tec_tecu: must be between 0 and 1000 TECU (1e16 electrons a m2), got 1e+06");
  EXPECT_EQ(ProblemOf([] {
              Validate(Ionosphere{-5.0, 1.0});
            }),
            "tec_tecu: must be between 0 and 1000 TECU (1e16 electrons a m2), got -5");
  EXPECT_EQ(ProblemOf([] {
              Validate(Ionosphere{20.0, 80.0});
            }),
            "share_1: must be between 0 and 1, got 80");
  EXPECT_EQ(ProblemOf([] {
              Validate(Weather{1013.25, 288.15, 0.5, kNotGiven});
            }).substr(0, 8),
            "height_m");
}

}  // namespace
}  // namespace sarblock
