// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "report/made_result.h"
#include "report/result_page.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(CompareResultsTest, FindsNothingBetweenAResultAndItself) {
  const ResultFolder a = test::MadeResult();
  const ResultDifference d = CompareResults(a, a);
  EXPECT_EQ(d.common.size(), 100u);
  EXPECT_EQ(d.only_in_a + d.only_in_b, 0u);
  for (const ResultDifference::Point& point : d.common) EXPECT_EQ(point.shift_length_m, 0.0);
  EXPECT_THAT(d.settings, IsEmpty());
  EXPECT_THAT(d.inputs, IsEmpty());
}

TEST(CompareResultsTest, MatchesPointsByNameAndMeasuresShiftsInTheLargerSigma) {  // hand values
  const ResultFolder a =
      test::MadeOf({{.id = "P", .position_m = {10, 20, 30}, .sigma_m = {1, 2, 4}},
                    {.id = "only a", .sigma_m = {1, 1, 1}},
                    {.id = "lost", .solved = false}});
  const ResultFolder b =
      test::MadeOf({{.id = "new", .sigma_m = {1, 1, 1}},
                    {.id = "lost", .sigma_m = {1, 1, 1}},
                    {.id = "P", .position_m = {11.5, 18, 30}, .sigma_m = {2, 1, 4}}});
  const ResultDifference d = CompareResults(a, b);
  ASSERT_EQ(d.common.size(), 1u);
  const ResultDifference::Point& p = d.common[0];
  EXPECT_EQ(p.a, 0u);
  EXPECT_EQ(p.b, 2u);
  EXPECT_THAT(p.shift_m, ElementsAre(1.5, -2.0, 0.0));
  EXPECT_EQ(p.shift_length_m, 2.5);
  EXPECT_EQ(p.shift_sigmas, 1.0);  // 1.5 / 2, 2 / 2, 0 / 4
  EXPECT_THAT(p.sigma_ratio, ElementsAre(2.0, 0.5, 1.0));
  EXPECT_EQ(d.only_in_a, 1u);
  EXPECT_EQ(d.only_in_b, 2u);
}

TEST(CompareResultsTest, TurnsShiftsOfGeocentricPointsToEastNorthUp) {
  // On the meridian of 90 degrees east: up is +y, east is -x.
  ResultFolder a = test::MadeOf({{.id = "P", .position_m = {0, 1737400, 0}}});
  ResultFolder b = test::MadeOf({{.id = "P", .position_m = {-3, 1737402, 0.5}}});
  for (ResultFolder* result : {&a, &b}) {
    result->file.frame = Frame::Geocentric({"", 1737400.0, 0.0});
  }
  const ResultDifference d = CompareResults(a, b);
  ASSERT_EQ(d.common.size(), 1u);
  EXPECT_NEAR(d.common[0].shift_m[0], 3.0, 1e-9);
  EXPECT_NEAR(d.common[0].shift_m[1], 0.5, 1e-9);
  EXPECT_NEAR(d.common[0].shift_m[2], 2.0, 1e-9);
}

TEST(CompareResultsTest, ListsSettingsInputsAndCorrectionsThatDiffer) {
  ResultFolder a, b;
  a.file.summary.configuration = {{"robust", "\"none\""}, {"datum", "\"given\""}, {"old", "1"}};
  b.file.summary.configuration = {{"robust", "\"huber\""}, {"datum", "\"given\""}};
  a.file.summary.inputs = {{"block.toml", 1, "aa"}, {"points.csv", 2, "bb"}};
  b.file.summary.inputs = {{"block.toml", 1, "aa"}, {"points.csv", 2, "cc"}};
  a.file.parameters = {{"S1", "range.bias", "m", 5.0, 0.5}, {"S2", "range.bias", "m", 1.0, 0.5}};
  b.file.parameters = {{"S1", "range.bias", "m", 4.0, 0.25}};
  const ResultDifference d = CompareResults(a, b);
  ASSERT_EQ(d.settings.size(), 2u);
  EXPECT_THAT(d.settings[0], ElementsAre("old", "1", ""));
  EXPECT_THAT(d.settings[1], ElementsAre("robust", "\"none\"", "\"huber\""));
  EXPECT_THAT(d.inputs, ElementsAre("points.csv"));
  ASSERT_EQ(d.parameters.size(), 1u);
  EXPECT_EQ(d.parameters[0].change, -1.0);
  EXPECT_EQ(d.parameters[0].change_sigmas, 2.0);
  EXPECT_EQ(d.parameters_only_in_a, 1u);
  EXPECT_EQ(d.parameters_only_in_b, 0u);
}

}  // namespace
}  // namespace sarblock
