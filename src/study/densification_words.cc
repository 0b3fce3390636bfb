// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "study/densification.h"

namespace sarblock {
namespace {

std::string Metres(double value_m) {
  std::array<char, 40> text;
  std::snprintf(text.data(), text.size(), "%.3g m", value_m);
  return text.data();
}

std::string Figure(double value) {
  std::array<char, 40> text;
  std::snprintf(text.data(), text.size(), "%.3f", value);
  return text.data();
}

bool IsExchange(const StudyTable& table, std::size_t row) {
  return table.Text(row, "layout").starts_with("exchange ");
}

bool IsPlacement(const StudyTable& table, std::size_t row) {
  return table.Text(row, "layout").starts_with("greedy ") || IsExchange(table, row);
}

/// What exchanging points after the placement whose last row is `last` did.
std::string DescribeExchange(const StudyTable& table, std::size_t last) {
  const std::size_t row = last + 1;
  if (row >= table.size() || !IsExchange(table, row)) return {};
  const std::string exchanged = table.Text(row, "message");
  if (exchanged.empty()) return "; no exchange of one of them lowers the criterion";
  const double before = table.Number(last, "criterion_m2");
  const double after = table.Number(row, "criterion_m2");
  return "; exchanging " + exchanged + " lowers the criterion from " + Figure(before) + " m2 to " +
         Figure(after) + " m2 (" + Figure(100.0 * (1.0 - after / before)) +
         " percent), then no exchange of one does";
}

bool IsDetermined(const StudyTable& table, std::size_t row) {
  return table.Number(row, "determined") == 1.0;
}

std::string ControlOf(const StudyTable& table, std::size_t row) {
  const auto count = static_cast<long>(table.Number(row, "control_points"));
  const std::string layout = table.Text(row, "layout");
  return count == 0   ? "no control at all"
         : count == 1 ? "one control point (" + layout + ")"
                      : std::to_string(count) + " control points (" + layout + ")";
}

/// The two figures that the goal speaks of.
struct Reached {
  double sigma_h_m;
  double sigma_u_m;
};
Reached ReachedBy(const DensificationGoal& goal, const StudyTable& table, std::size_t row) {
  const std::string of = goal.of == DensificationGoal::Of::kMedian ? "median" : "max";
  return {table.Number(row, of + "_sigma_h_m"), table.Number(row, of + "_sigma_u_m")};
}

/// How far from the goal, 1 or less where it is reached.
double Excess(const DensificationGoal& goal, const Reached& reached) {
  double excess = 0.0;
  if (!std::isnan(goal.sigma_h_m)) excess = reached.sigma_h_m / goal.sigma_h_m;
  if (!std::isnan(goal.sigma_u_m)) excess = std::max(excess, reached.sigma_u_m / goal.sigma_u_m);
  return excess;
}

std::string Describe(const DensificationGoal& goal) {
  std::string text;
  if (!std::isnan(goal.sigma_h_m)) text = "sigma_h " + Metres(goal.sigma_h_m);
  if (!std::isnan(goal.sigma_u_m)) {
    text += (text.empty() ? "sigma_u " : " and sigma_u ") + Metres(goal.sigma_u_m);
  }
  return text + (goal.of == DensificationGoal::Of::kMedian ? " in the median" : " everywhere");
}

/// One sentence a variant: the fewest points that reach the goal, of several layouts the best.
void DescribeGoal(const DensificationStudy& study,
                  const StudyTable& table,
                  std::vector<std::string>* words) {
  const DensificationGoal& goal = study.goal;
  if (std::isnan(goal.sigma_h_m) && std::isnan(goal.sigma_u_m)) return;
  std::vector<std::string> variants;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const std::string variant = table.Text(row, "variant");
    if (!IsPlacement(table, row) &&
        std::find(variants.begin(), variants.end(), variant) == variants.end()) {
      variants.push_back(variant);
    }
  }
  for (const std::string& variant : variants) {
    std::optional<std::size_t> fewest, nearest;
    const auto excess = [&](std::size_t row) { return Excess(goal, ReachedBy(goal, table, row)); };
    const auto points = [&](std::size_t row) { return table.Number(row, "control_points"); };
    for (std::size_t row = 0; row < table.size(); ++row) {
      if (IsPlacement(table, row) || !IsDetermined(table, row)) continue;
      if (table.Text(row, "variant") != variant) continue;
      if (!nearest || excess(row) < excess(*nearest)) nearest = row;
      if (excess(row) > 1.0) continue;
      if (!fewest || points(row) < points(*fewest) ||
          (points(row) == points(*fewest) && excess(row) < excess(*fewest))) {
        fewest = row;
      }
    }
    const std::string begin = variant.empty() ? "" : variant + ": ";
    if (fewest) {
      const Reached reached = ReachedBy(goal, table, *fewest);
      words->push_back(begin + ControlOf(table, *fewest) +
                       (points(*fewest) > 1.0 ? " reach " : " reaches ") + Describe(goal) + " (" +
                       Metres(reached.sigma_h_m) + ", " + Metres(reached.sigma_u_m) +
                       "), no smaller layout of the study does");
    } else if (nearest) {
      const Reached reached = ReachedBy(goal, table, *nearest);
      words->push_back(begin + "no layout of the study reaches " + Describe(goal) +
                       "; the nearest is " + ControlOf(table, *nearest) + " with " +
                       Metres(reached.sigma_h_m) + " and " + Metres(reached.sigma_u_m));
    } else {
      words->push_back(begin + "no layout of the study determines the block");
    }
  }
}

/// Where the points of each placement went and what they were worth.
void DescribePlacements(const StudyTable& table, std::vector<std::string>* words) {
  for (std::size_t begin = 0; begin < table.size(); ++begin) {
    if (!IsPlacement(table, begin) || IsExchange(table, begin)) continue;
    if (!table.Text(begin, "added_point").empty()) continue;
    const std::string variant = table.Text(begin, "variant");
    std::string text = (variant.empty() ? "" : variant + ": ") + table.Text(begin, "layout");
    if (!IsDetermined(table, begin)) {
      words->push_back(text + ": " + table.Text(begin, "message"));
      continue;
    }
    text += " placement from " + ControlOf(table, begin) + ":";
    std::size_t last = begin;
    for (std::size_t row = begin + 1; row < table.size(); ++row) {
      if (!IsPlacement(table, row) || table.Text(row, "added_point").empty()) break;
      text += (last == begin ? " " : ", ") + table.Text(row, "added_point") + " at (" +
              std::to_string(std::lround(table.Number(row, "added_east_m"))) + ", " +
              std::to_string(std::lround(table.Number(row, "added_north_m"))) + ")";
      last = row;
    }
    words->push_back(text + "; the worst point goes from sigma_h " +
                     Metres(table.Number(begin, "max_sigma_h_m")) + ", sigma_u " +
                     Metres(table.Number(begin, "max_sigma_u_m")) + " to " +
                     Metres(table.Number(last, "max_sigma_h_m")) + ", " +
                     Metres(table.Number(last, "max_sigma_u_m")) + DescribeExchange(table, last));
  }
}

void DescribeVerification(const DensificationStudy& study,
                          const StudyTable& table,
                          std::vector<std::string>* words) {
  std::size_t verified = 0, agree = 0;
  double least = 1e300, most = 0.0;
  std::string not_agreeing;
  for (std::size_t row = 0; row < table.size(); ++row) {
    if (std::isnan(table.Number(row, "agrees"))) continue;
    ++verified;
    least = std::fmin(least, table.Number(row, "nees"));
    most = std::fmax(most, table.Number(row, "nees"));
    if (table.Number(row, "agrees") == 1.0) {
      ++agree;
    } else {
      not_agreeing += "; not " + ControlOf(table, row) + " " + table.Text(row, "variant") + " (" +
                      Figure(table.Number(row, "nees")) + ", allowed " +
                      Figure(table.Number(row, "nees_lower")) + " to " +
                      Figure(table.Number(row, "nees_upper")) + ")";
    }
  }
  if (verified == 0) return;
  words->push_back("Monte Carlo agrees with the prediction in " + std::to_string(agree) + " of " +
                   std::to_string(verified) + " verified rows, " +
                   std::to_string(study.verify.runs) + " runs each: normalised errors squared " +
                   Figure(least) + " to " + Figure(most) + not_agreeing);
}

}  // namespace

std::vector<std::string> DescribeDensification(const DensificationStudy& study,
                                               const StudyTable& table) {
  std::vector<std::string> words;
  DescribeGoal(study, table, &words);
  DescribePlacements(table, &words);
  DescribeVerification(study, table, &words);
  const auto undetermined = [&] {
    std::size_t count = 0;
    for (std::size_t row = 0; row < table.size(); ++row) {
      if (!IsDetermined(table, row)) ++count;
    }
    return count;
  }();
  if (undetermined > 0) {
    words.push_back(std::to_string(undetermined) + " of " + std::to_string(table.size()) +
                    " blocks cannot be determined with their control; see the column message");
  }
  return words;
}

}  // namespace sarblock
