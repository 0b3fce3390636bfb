// SPDX-License-Identifier: Apache-2.0
#include "files/montecarlo_part.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <string>

#include "fuzz/fuzz_targets.h"
#include "io/io_fixture.h"
#include "tables/open.h"
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

IdTable OnePoint() {
  IdTable ids;
  ids.Append("P");
  return ids;
}

/// Adds these tables, of part 2/2 of four runs of one point, to sums of 0.5.
MonteCarloDraws Added(const std::string& draws_csv, const std::string& sums_csv) {
  MonteCarloDraws draws;
  draws.points.emplace_back().square.Add(0.5);
  draws.runs.push_back({1, true, {}, 0.0, {}});
  const auto source =
      TablesOfTexts({{"draws.csv", draws_csv}, {"sums.csv", sums_csv}}, FolderContent::kPart);
  AddPartTables(*source, {0, 2}, 4, OnePoint(), &draws);
  return draws;
}

std::string With(std::string_view table, const std::string& from, const std::string& to) {
  std::string text(table);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

const std::string kGoodDraws(fuzz::kDraws), kGoodSums(fuzz::kSums);

// Hand values: 2^60 units are 1.
TEST(MonteCarloPartTest, TablesAreAddedToWhatIsThere) {
  const MonteCarloDraws draws = Added(kGoodDraws, kGoodSums);
  ASSERT_EQ(draws.runs.size(), 3U);
  EXPECT_EQ(draws.runs[1].run, 0U);
  EXPECT_TRUE(draws.runs[1].converged);
  EXPECT_EQ(draws.runs[1].variance_ratio, (std::array<double, 3>{1.5, 0.5, 1.0}));
  EXPECT_EQ(draws.runs[1].inside, (std::array<double, 3>{0.0, 1.0, 1.0}));
  EXPECT_EQ(draws.runs[2].run, 2U);
  EXPECT_FALSE(draws.runs[2].converged);
  const MonteCarloPoint& sums = draws.points[0];
  EXPECT_EQ(sums.square.Value(), 3.5);
  EXPECT_EQ(sums.product[0].Value(), 1.5);
  EXPECT_EQ(sums.product[1].Value(), 0.5);
  EXPECT_EQ(sums.product[3].Value(), -5.0 * ExactSum::kUnit);
  EXPECT_EQ(sums.inside, (std::array<std::uint32_t, 3>{0, 1, 1}));
}

TEST(MonteCarloPartTest, WhatSuchRunsCannotHaveIsRefusedWithItsPlace) {
  const auto refusal = [](const std::string& draws_csv, const std::string& sums_csv) {
    return test::MessageOf<InputError>([&] { return Added(draws_csv, sums_csv); });
  };
  EXPECT_THAT(refusal(With(kGoodDraws, "\n2,", "\n3,"), kGoodSums),
              StartsWith("draws.csv:3: run: is not the run that stands here in part 2/2"));
  EXPECT_THAT(refusal(With(kGoodDraws, "2,0,,,,,,,\n", ""), kGoodSums),
              StartsWith("draws.csv: run: has 1 of 2 runs of part 2/2"));
  EXPECT_THAT(refusal(kGoodDraws + "4,0,,,,,,,\n", kGoodSums), StartsWith("draws.csv:4: run"));
  EXPECT_THAT(refusal(With(kGoodDraws, "0,1,1.5", "0,1,"), kGoodSums),
              StartsWith("draws.csv:2: variance_ratio_e"));
  EXPECT_THAT(refusal(kGoodDraws, With(kGoodSums, "\nP,", "\nQ,")),
              StartsWith("sums.csv:2: point: is not the point that stands here in the block"));
  EXPECT_THAT(refusal(kGoodDraws, kGoodSums.substr(0, kGoodSums.find("P,"))),
              StartsWith("sums.csv: point: has 0 of 1 points"));
  EXPECT_THAT(refusal(kGoodDraws, With(kGoodSums, "-5", "-5.5")),
              StartsWith("sums.csv:2: sum_en: is no integer"));
  EXPECT_THAT(refusal(kGoodDraws, With(kGoodSums, ",7,", "," + std::string(38, '9') + ",")),
              StartsWith("sums.csv:2: sum_nu: is no sum of 1 runs"));
  EXPECT_THAT(refusal(kGoodDraws, With(kGoodSums, ",0,1,1\n", ",0,1,2\n")),
              StartsWith("sums.csv:2: inside_99: is more than 1 runs"));
}

}  // namespace
}  // namespace sarblock
