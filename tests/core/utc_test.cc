// SPDX-License-Identifier: Apache-2.0
#include "core/utc.h"

#include <gtest/gtest.h>

namespace sarblock {
namespace {

UtcTime At(const char* text) {
  const auto time = ParseUtc(text);
  EXPECT_TRUE(time) << text;
  return time.value_or(UtcTime{});
}

TEST(UtcTimeTest, DifferencesAreExactToTheLastGivenDigit) {  // hand arithmetic
  const UtcTime a = At("2022-10-16T01:50:44.577283"), b = At("UTC=2022-10-16T01:51:09.741403Z");
  EXPECT_NEAR(SecondsBetween(a, b), 25.164120, 1e-15 * 25);
  EXPECT_EQ(SecondsBetween(At("2023-01-08T00:00:00"), At("2023-01-09T00:00:00")), 86400.0);
  EXPECT_EQ(SecondsBetween(At("2024-02-28T12:00:00"), At("2024-03-01T12:00:00")), 172800.0);
}

// IERS Bulletin C 52: 2016-12-31T23:59:60 was; Bulletin C 49: 2015-06-30T23:59:60.
TEST(UtcTimeTest, LeapSecondsCount) {
  EXPECT_EQ(SecondsBetween(At("2016-12-31T23:59:59.5"), At("2017-01-01T00:00:00.5")), 2.0);
  EXPECT_EQ(SecondsBetween(At("2016-12-31T23:59:60.25"), At("2017-01-01T00:00:00.25")), 1.0);
  EXPECT_EQ(SecondsBetween(At("2015-06-30T00:00:00"), At("2015-07-01T00:00:00")), 86401.0);
  EXPECT_EQ(SecondsBetween(At("2017-12-31T23:59:59"), At("2018-01-01T00:00:00")), 1.0);
}

// The two time scales of a restituted orbit file: TAI 2023-08-23T12:32:16.035127 is UTC ...:39.
TEST(UtcTimeTest, AgreesWithTheTaiOfAnOrbitFile) {
  const UtcTime utc = At("UTC=2023-08-23T12:31:39.035127");
  const UtcTime days_1970 = At("1972-01-01T00:00:00");  // TAI - UTC = 10 s, 730 days after 1970
  EXPECT_EQ(days_1970.tai_whole, 730 * 86400 + 10);
  EXPECT_EQ(utc.tai_whole, (53 * 365 + 13 + 234) * 86400LL + 12 * 3600 + 32 * 60 + 16);
}

TEST(UtcTimeTest, TextReadsBackToTheSameSecond) {  // round trip over every leap and a plain day
  for (const char* text : {"1972-01-01T00:00:00Z",
                           "1972-06-30T23:59:60Z",
                           "1998-12-31T23:59:60Z",
                           "2016-12-31T23:59:59Z",
                           "2016-12-31T23:59:60Z",
                           "2017-01-01T00:00:00Z",
                           "2017-01-01T00:00:01Z",
                           "2022-10-16T01:50:44Z",
                           "2030-02-28T23:59:59Z"}) {
    EXPECT_EQ(UtcText(At(text)), text);
    EXPECT_EQ(UtcText(WholeSecond(At(text))), text);
  }
  EXPECT_EQ(UtcText(At("2022-10-16T01:50:44.999999")), "2022-10-16T01:50:44Z");
}

TEST(UtcTimeTest, RefusesWhatIsNoTime) {
  for (const char* text : {"",
                           "2022",
                           "2022-10-16",
                           "2022-10-16 01:50:44",
                           "2022-13-16T01:50:44",
                           "2022-02-29T01:50:44",
                           "2022-10-16T24:00:00",
                           "2022-10-16T01:60:00",
                           "2022-10-16T01:50:60",
                           "2022-06-30T23:59:60",
                           "1971-12-31T00:00:00",
                           "2022-10-16T01:50:44.",
                           "2022-10-16T01:50:4",
                           "2022-10-16T01:50:44.5x",
                           "-022-10-16T01:50:44",
                           "2022-10-16T01:50:44.5e0",
                           "TAI=2022"}) {
    EXPECT_FALSE(ParseUtc(text)) << text;
  }
}

}  // namespace
}  // namespace sarblock
