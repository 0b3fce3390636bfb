// SPDX-License-Identifier: Apache-2.0
// The stability study in small: every family at a comfortable and at a hard step, the production
// adjustment beside the same one in 50 digits.
#include "sarblock/study/stability.h"

#include "sarblock/core/error.h"
#include "sarblock/core/parallel.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

StabilityRow Row(double sigma_digits_1, double error_sigma_1) {
  StabilityRow row;
  row.sigma_digits_1 = sigma_digits_1;
  row.covariance_digits_1 = 9.1;
  row.error_sigma_1 = error_sigma_1;
  return row;
}

// Hand-made rows on both sides of the two limits.
TEST(JudgeStabilityTest, CallsWrongWhatClaimsMoreThanItHas) {
  EXPECT_EQ(JudgeStability(Row(6.1, 0.9e-3), {}), StabilityOutcome::kOk);
  EXPECT_EQ(JudgeStability(Row(5.9, 1e-7), {}), StabilityOutcome::kWrong);
  EXPECT_EQ(JudgeStability(Row(11.3, 1.1e-3), {}), StabilityOutcome::kWrong);
  EXPECT_EQ(JudgeStability(StabilityRow{}, {}), StabilityOutcome::kWrong);  // nothing compared
}

TEST(JudgeStabilityTest, TakesOnlyAWarningOfTheNumbersForAnExcuse) {
  const StabilityRow row = Row(4.7, 1e-7);
  EXPECT_EQ(JudgeStability(row, {"nearly undetermined: A1"}), StabilityOutcome::kWarned);
  EXPECT_EQ(JudgeStability(row, {"2 of 10 points are not determined and left out"}),
            StabilityOutcome::kWrong);
  EXPECT_EQ(JudgeStability(Row(8.2, 1e-7), {"control on one line"}), StabilityOutcome::kWarned);
}

TEST(JudgeStabilityTest, CallsARefusalARefusal) {
  StabilityRow row;
  row.exit_code = 4;
  EXPECT_EQ(JudgeStability(row, {}), StabilityOutcome::kRefused);
}

TEST(StabilityStudyTest, HasTwentyFiveFamiliesAndFiveHundredSteps) {
  std::set<std::string> names;
  std::size_t steps = 0;
  for (const StabilityFamily& family : StabilityFamilies()) {
    names.insert(family.name);
    steps += family.values.size();
  }
  EXPECT_EQ(names.size(), StabilityFamilies().size());
  EXPECT_GE(names.size(), 25U);
  EXPECT_GE(steps, 500U);
}

TEST(StabilityStudyTest, NamesTheNearestOfAFamilyThatDoesNotExist) {
  try {
    (void)RunStabilityStep("sqint", 3.1, 1);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("did you mean squint?"));
  }
}

/// stability.csv: a row a step, messages with their quotes doubled.
void WriteTable(const char* path, const std::vector<StabilityRow>& rows) {
  std::ofstream file(path);
  file << "family,parameter,value,condition,outcome,covariance_digits,position_digits,message,"
          "exit_code,sigma_digits,error_sigma,normal_digits,single_digits,ceres_digits\n";
  const auto number = [](double value) {
    return std::isfinite(value) ? (std::ostringstream() << value).str() : std::string();
  };
  for (const StabilityRow& row : rows) {
    std::string message;
    for (const char c : row.message) message += c == '"' ? "\"\"" : std::string(1, c);
    file << row.family << ',' << row.parameter << ',' << row.value << ',' << number(row.condition)
         << ',' << NameOf(row.outcome) << ',' << number(row.covariance_digits_1) << ','
         << number(row.position_digits_1) << ",\"" << message << "\"," << row.exit_code << ','
         << number(row.sigma_digits_1) << ',' << number(row.error_sigma_1) << ','
         << number(row.normal_digits_1) << ',' << number(row.single_digits_1) << ','
         << number(row.ceres_digits_1) << '\n';
  }
}

// Against 50 digits: no step claims more digits than it has, and every refusal says why. With
// SARBLOCK_STABILITY_CSV=FILE in the environment all steps of all families, written to the file.
TEST(StabilityStudyTest, IsNeverWrongWithoutSayingSo) {
  const char* table = std::getenv("SARBLOCK_STABILITY_CSV");
  std::vector<std::pair<std::string, double>> steps;
  for (const StabilityFamily& family : StabilityFamilies()) {
    for (std::size_t k = 0; k < family.values.size(); ++k) {
      if (table == nullptr && k != 1 && k != family.values.size() / 2) continue;
      steps.emplace_back(family.name, family.values[k]);
    }
  }
  std::vector<StabilityRow> rows(steps.size());
  ParallelForChunks(steps.size(), 1, [&](std::size_t, std::size_t begin, std::size_t) {
    rows[begin] = RunStabilityStep(steps[begin].first, steps[begin].second, 2);
  });
  if (table != nullptr) WriteTable(table, rows);
  std::size_t ok = 0;
  for (const StabilityRow& row : rows) {
    SCOPED_TRACE(row.family + " " + std::to_string(row.value) + ": " + row.message);
    EXPECT_NE(row.outcome, StabilityOutcome::kWrong)
        << row.sigma_digits_1 << " digits of a sigma, " << row.error_sigma_1 << " sigmas off";
    if (row.outcome == StabilityOutcome::kRefused) {
      EXPECT_THAT(row.message, testing::SizeIs(testing::Gt(20U)));
    }
    if (row.outcome == StabilityOutcome::kOk) ++ok;
  }
  // It is no virtue to refuse or to warn of everything.
  EXPECT_GE(ok, table == nullptr ? rows.size() / 2 : rows.size() / 3);
}

}  // namespace
}  // namespace sarblock
