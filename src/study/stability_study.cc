// SPDX-License-Identifier: Apache-2.0
#include "study/stability_study.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

#include "core/threads.h"

namespace sarblock {
namespace {

constexpr std::array kOutcomes = {StabilityOutcome::kOk,
                                  StabilityOutcome::kWarned,
                                  StabilityOutcome::kRefused,
                                  StabilityOutcome::kWrong};
using OutcomeCounts = std::array<std::size_t, kOutcomes.size()>;

StudyCell CellOrEmpty(double value) {
  return std::isfinite(value) ? StudyCell(value) : StudyCell();
}

std::string OneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

StudyRow RowOf(const StabilityRow& row) {
  return {row.family,
          row.parameter,
          row.value,
          CellOrEmpty(row.condition),
          std::string(NameOf(row.outcome)),
          CellOrEmpty(row.covariance_digits_1),
          CellOrEmpty(row.position_digits_1),
          OneLine(row.message),
          static_cast<std::int64_t>(row.exit_code),
          CellOrEmpty(row.sigma_digits_1),
          CellOrEmpty(row.error_sigma_1),
          CellOrEmpty(row.normal_digits_1),
          CellOrEmpty(row.single_digits_1),
          CellOrEmpty(row.ceres_digits_1)};
}

std::string Number(double value, const char* format = "%.3g") {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

/// "5 ok, 3 warned, 0 refused, 0 wrong".
std::string Told(const OutcomeCounts& counts) {
  std::string text;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    text += (k == 0 ? "" : ", ") + std::to_string(counts[k]) + " " + NameOf(kOutcomes[k]);
  }
  return text;
}

/// "9.0 / 14.4": fewest and median.
std::string FewestAndMedian(std::vector<double> digits) {
  if (digits.empty()) return "-";
  std::sort(digits.begin(), digits.end());
  const std::size_t half = digits.size() / 2;
  const double median =
      digits.size() % 2 == 1 ? digits[half] : 0.5 * (digits[half - 1] + digits[half]);
  return Number(digits.front(), "%.1f") + " / " + Number(median, "%.1f");
}

/// Digits of each method by the decade of the condition, warned rows among them.
std::vector<std::string> DigitsByCondition(const StudyTable& table) {
  struct Method {
    const char* column;
    const char* name;
  };
  constexpr std::array kMethods = {Method{"covariance_digits", "production"},
                                   Method{"normal_digits", "all normal equations"},
                                   Method{"ceres_digits", "Ceres"},
                                   Method{"single_digits", "all normal equations, single"}};
  std::map<int, std::vector<std::size_t>> decades;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const double condition = table.Number(row, "condition");
    // Left out where nothing was compared or the program accepted nothing.
    if (condition >= 1.0 && table.Number(row, "exit_code") == 0.0) {
      decades[static_cast<int>(std::floor(std::log10(condition)))].push_back(row);
    }
  }
  std::vector<std::string> words;
  for (const auto& [decade, rows] : decades) {
    std::string line = "condition 1e" + std::to_string(decade) + " to 1e" +
                       std::to_string(decade + 1) + " (" + std::to_string(rows.size()) +
                       " accepted), fewest / median digits: ";
    for (const Method& method : kMethods) {
      std::vector<double> digits;
      for (const std::size_t row : rows) {
        const double value = table.Number(row, method.column);
        if (!std::isnan(value)) digits.push_back(value);
      }
      if (method.column != kMethods.front().column) line += ", ";
      line += std::string(method.name) + " " + FewestAndMedian(std::move(digits));
    }
    words.push_back(std::move(line));
  }
  return words;
}

}  // namespace

StudyPlan PlanStability(const StabilityStudy& study) {
  StudyPlan plan;
  plan.columns = {{"family", StudyCellKind::kText},
                  {"parameter", StudyCellKind::kText},
                  {"value"},
                  {"condition"},
                  {"outcome", StudyCellKind::kText},
                  {"covariance_digits"},
                  {"position_digits"},
                  {"message", StudyCellKind::kText},
                  {"exit_code", StudyCellKind::kInteger},
                  {"sigma_digits"},
                  {"error_sigma"},
                  {"normal_digits"},
                  {"single_digits"},
                  {"ceres_digits"}};
  for (const StabilityFamily& family : study.families) {
    for (const double value : family.values) {
      plan.tasks.push_back(
          {family.name + " " + Number(value), [name = family.name, value](ProgressSink* progress) {
             // All cores: fewer would hold for the steps beside this one too.
             return std::vector<StudyRow>{
                 RowOf(RunStabilityStep(name, value, AvailableCores(), progress))};
           }});
    }
  }
  return plan;
}

std::vector<std::string> DescribeStability(const StabilityStudy& study, const StudyTable& table) {
  OutcomeCounts all{};
  std::map<std::string, OutcomeCounts> by_family;
  std::vector<std::string> wrong;
  double most_error = 0.0, fewest_digits = std::numeric_limits<double>::infinity();
  for (std::size_t row = 0; row < table.size(); ++row) {
    const std::string outcome = table.Text(row, "outcome"), family = table.Text(row, "family");
    const double digits = table.Number(row, "sigma_digits"),
                 error = table.Number(row, "error_sigma");
    for (std::size_t k = 0; k < kOutcomes.size(); ++k) {
      if (outcome != NameOf(kOutcomes[k])) continue;
      ++all[k];
      ++by_family[family][k];
    }
    if (outcome == NameOf(StabilityOutcome::kOk)) {
      most_error = std::max(most_error, error);
      fewest_digits = std::min(fewest_digits, digits);
    } else if (outcome == NameOf(StabilityOutcome::kWrong)) {
      wrong.push_back("wrong: " + family + " at " + Number(table.Number(row, "value")) + ": " +
                      Number(table.Number(row, "covariance_digits"), "%.1f") +
                      " digits of a covariance, " + Number(digits, "%.1f") + " of a sigma, " +
                      Number(error) + " sigmas off");
    }
  }
  std::vector<std::string> words;
  words.push_back(std::to_string(table.size()) + " steps of " +
                  std::to_string(study.families.size()) + " families: " + Told(all));
  if (all[0] > 0) {
    words.push_back("of those that are ok: largest error " + Number(most_error) +
                    " sigmas, fewest digits of a sigma " + Number(fewest_digits, "%.1f"));
  }
  for (std::string& line : DigitsByCondition(table)) words.push_back(std::move(line));
  for (const StabilityFamily& family : study.families) {
    words.push_back(family.name + ": " + Told(by_family[family.name]) + " (" + family.about + ")");
  }
  words.insert(words.end(), wrong.begin(), wrong.end());
  return words;
}

}  // namespace sarblock
